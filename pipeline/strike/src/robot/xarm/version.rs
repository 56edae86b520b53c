//! Which arm and firmware are driven.

/// Axes of the arm that this drives.
const AXES: &str = "7";
/// The oldest firmware that takes the lines that are sent.
const FIRMWARE: (u32, u32, u32) = (1, 11, 100);

/// An xArm7 with a firmware that takes the lines that are sent; the text is as `7,7,SN,BOX,v1.12.10`.
pub(super) fn check_version(text: &str) -> Result<(), String> {
    let numbers: Vec<&str> = text.split(',').collect();
    let firmware = || {
        let last = numbers.last()?.rsplit(['v', 'V']).next()?;
        let mut parts = last.split('.').map(|part| {
            let digits: String = part.chars().take_while(char::is_ascii_digit).collect();
            digits.parse::<u32>().ok()
        });
        Some((parts.next()??, parts.next()??, parts.next()??))
    };
    let axes = numbers.first().and_then(|text| text.chars().last());
    if axes.is_none_or(|axes| AXES != axes.to_string()) {
        return Err(format!(
            "the controller says `{text}`: this drives an xArm with {AXES} axes"
        ));
    }
    match firmware() {
        Some(found) if found >= FIRMWARE => Ok(()),
        _ => Err(format!(
            "the controller says `{text}`: its firmware must be {}.{}.{} or later",
            FIRMWARE.0, FIRMWARE.1, FIRMWARE.2
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_xarm7_with_a_new_firmware_is_driven() {
        for text in [
            "7,7,XI1300,AC1300,v1.12.10",
            "7,7,,,V2.0.0",
            "v7,7,a,b,v1.11.100",
        ] {
            assert_eq!(check_version(text), Ok(()), "{text}");
        }
        for text in [
            "6,6,XI1300,AC1300,v1.12.10",
            "7,7,a,b,v1.10.9",
            "",
            "7",
            "7,7,a,b,vx",
        ] {
            assert!(check_version(text).is_err(), "{text}");
        }
    }
}
