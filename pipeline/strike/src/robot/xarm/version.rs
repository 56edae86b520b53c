//! Which arm and firmware are driven.

use std::time::Duration;

use crate::robot::arm::{ArmLimits, Identity, version_in};

/// The oldest firmware whose real-time report is served.
const FIRMWARE: (u32, u32) = (2, 1);
/// Number of the Lite6's kind; an xArm's is the number of its axes.
const LITE6: u32 = 9;

/// An xArm5, 6 or 7, or a Lite6, with a firmware that serves what is read; the text is as `7,7,SN,BOX,v2.4.0`. Gives the arm and its
/// number of axes.
pub(super) fn identify(text: &str) -> Result<(Identity, u32), String> {
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let digits = |text: &str| {
        let digits = text.trim_start_matches(|c: char| !c.is_ascii_digit());
        let end = digits
            .find(|c: char| !c.is_ascii_digit())
            .unwrap_or(digits.len());
        digits[..end].parse::<u32>().ok()
    };
    let [axes, kind, serial, _, _, ..] = parts[..] else {
        return Err(format!(
            "the controller says `{text}`: it is none of an xArm"
        ));
    };
    let speed = match (digits(axes), digits(kind)) {
        (Some(axes @ 5..=7), Some(kind)) if axes == kind => 1.0,
        (Some(6), Some(LITE6)) => 0.5,
        _ => {
            return Err(format!(
                "the controller says `{text}`: this drives an xArm5, xArm6, xArm7 or Lite6"
            ));
        }
    };
    if parts
        .last()
        .and_then(|text| version_in(text))
        .is_none_or(|found| found < FIRMWARE)
    {
        return Err(format!(
            "the controller says `{text}`: its firmware must be {}.{} or later",
            FIRMWARE.0, FIRMWARE.1
        ));
    }
    if serial.is_empty() {
        return Err(format!(
            "the controller says `{text}`: it states no serial number, by which one program claims it"
        ));
    }
    let limits = ArmLimits {
        speed,
        acceleration: 50.0,
        jerk: Some(100.0),
        start: Duration::from_millis(60),
    };
    let identity = Identity {
        serial: serial.to_owned(),
        limits,
    };
    Ok((identity, digits(axes).unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arms_by_their_axes_with_a_new_firmware_are_driven_and_no_others() {
        for (text, axes, speed) in [
            ("7,7,XI1300,AC1300,v2.1.0", 7, 1.0),
            ("v6,6,a,b,V2.10.3", 6, 1.0),
            ("5,5,a,b,v10.0.0", 5, 1.0),
            ("6,9,a,b,v2.4.105", 6, 0.5),
        ] {
            let (identity, found) = identify(text).expect(text);
            assert_eq!((found, identity.limits.speed), (axes, speed), "{text}");
        }
        for (text, said) in [
            ("7,7,XI1300,AC1300,v1.12.10", "firmware"),
            ("7,7,a,b,v2.0.9", "firmware"),
            ("7,7,a,b,vx", "firmware"),
            ("6,12,a,b,v2.4.0", "xArm5"),
            ("8,8,a,b,v2.4.0", "xArm5"),
            ("7,7,,b,v2.4.0", "serial"),
            ("", "none"),
            ("7", "none"),
        ] {
            let error = identify(text).expect_err(text);
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
