/// Declares an enum without fields whose values have names: every value stands once, beside its name.
#[macro_export]
macro_rules! named {
    (
        $(#[$of_enum:meta])*
        pub enum $name:ident {
            $($(#[$of_value:meta])* $value:ident = $text:literal,)*
        }
    ) => {
        $(#[$of_enum])*
        pub enum $name {
            $($(#[$of_value])* $value,)*
        }

        impl $name {
            /// All, in their order.
            pub const ALL: [Self; [$($text),*].len()] = [$(Self::$value),*];

            /// The name, as files or pages have it.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $text,)*
                }
            }
        }
    };
}
