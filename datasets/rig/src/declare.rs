//! How an effect or a kind of noise is declared: its name, and each parameter with default, unit and neutral value.

/// One parameter of an effect or of a kind of noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterSpec {
    /// Its name.
    pub name: &'static str,
    /// Its unit; `1` for a ratio.
    pub unit: &'static str,
    /// What it is where no value is given: a size that real tables show.
    pub default: f64,
    /// The value at which the effect vanishes; `None` for a parameter of place or form, which [`Effect::scaled`] keeps.
    pub neutral: Option<f64>,
}

/// Declares an effect or a kind of noise as a struct of its parameters (all `f64`); behind those of an effect stands what it does.
macro_rules! declare {
    ($(#[$doc:meta])* $kind:ident = $name:literal { $($parameters:tt)* } fn $($does:tt)*) => {
        declare! { $(#[$doc])* $kind = $name { $($parameters)* } }

        impl Acts for $kind {
            fn $($does)*
        }
    };
    ($(#[$doc:meta])* $kind:ident = $name:literal {
        $($(#[$about:meta])* $field:ident: $default:literal, $unit:literal, $neutral:expr;)*
    }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $kind {
            $($(#[$about])* pub $field: f64,)*
        }

        impl Default for $kind {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $kind {
            pub(crate) const NAME: &'static str = $name;
            pub(crate) const PARAMETERS: &'static [$crate::ParameterSpec] = &[
                $($crate::ParameterSpec {
                    name: stringify!($field), unit: $unit, default: $default, neutral: $neutral,
                },)*
            ];

            pub(crate) fn parameter(&mut self, name: &str) -> Option<&mut f64> {
                match name {
                    $(stringify!($field) => Some(&mut self.$field),)*
                    _ => None,
                }
            }
        }
    };
}
pub(crate) use declare;

/// Declares the enum of all effects, or of all kinds of noise: lookup by name, and by parameter.
macro_rules! declare_all {
    ($(#[$doc:meta])* $all:ident: $does:ident by $as_does:ident; $($kind:ident),* $(,)?) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(tag = "name", content = "parameters", rename_all = "snake_case")]
        pub enum $all {
            $(#[doc = concat!("See [`", stringify!($kind), "`].")] $kind($kind),)*
        }

        impl $all {
            /// Each with its default parameters.
            pub fn all() -> Vec<Self> {
                vec![$(Self::$kind($kind::default()),)*]
            }

            /// Its name, as in files and `--hide`.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$kind(_) => $kind::NAME,)* }
            }

            /// Its parameters, in the order in which `--hide` takes their values.
            pub fn parameters(&self) -> &'static [$crate::ParameterSpec] {
                match self { $(Self::$kind(_) => $kind::PARAMETERS,)* }
            }

            fn parameter(&mut self, name: &str) -> Option<&mut f64> {
                match self { $(Self::$kind(kind) => kind.parameter(name),)* }
            }

            /// The one of this name with its defaults.
            pub fn named(name: &str) -> Option<Self> {
                Self::all().into_iter().find(|kind| kind.name() == name)
            }

            /// The value of a parameter; `None` if it has none of that name.
            pub fn get(&self, name: &str) -> Option<f64> {
                let mut copy = *self;
                copy.parameter(name).map(|value| *value)
            }

            /// Sets a parameter; false if it has none of that name.
            pub fn set(&mut self, name: &str, value: f64) -> bool {
                self.parameter(name)
                    .map(|parameter| *parameter = value)
                    .is_some()
            }

            pub(crate) fn $as_does(&self) -> &dyn $does {
                match self { $(Self::$kind(kind) => kind,)* }
            }
        }
    };
}
pub(crate) use declare_all;
