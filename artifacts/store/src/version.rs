//! Names of versions: `v` and a number of at least four digits.

pub(crate) fn name(number: u64) -> String {
    format!("v{number:04}")
}

/// The number of a version's name; none where it is no such name.
pub(crate) fn number(text: &str) -> Option<u64> {
    let number = text.strip_prefix('v')?.parse().ok()?;
    (name(number) == text).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_and_its_number_go_together() {
        for value in [0, 1, 9_999, 10_000, u64::MAX] {
            assert_eq!(number(&name(value)), Some(value));
        }
        for text in [
            "", "v", "v1", "v00001", "v+001", "V0001", "v0001/..", "../v0001", "v0001 ", "lock",
        ] {
            assert_eq!(number(text), None, "{text}");
        }
    }
}
