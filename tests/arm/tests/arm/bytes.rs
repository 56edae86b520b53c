//! The driver's requests are, byte for byte, those that the maker's SDK (xarm-python-sdk 1.18.4) sends for the same calls, kept in
//! `sdk_frames.txt` by `make arm`.

use std::collections::BTreeMap;

use arm::{Event, Maker};
use durable::hex;
use strike::xarm::{Register, line_payload, request};
use values::Point;

use crate::bench::{in_time, plan, rig, undisturbed};

/// Frames of the SDK by the name of their call, numbered as if each were the first.
fn sdk() -> BTreeMap<&'static str, &'static str> {
    let lines = include_str!("../sdk_frames.txt").lines();
    lines.filter_map(|line| line.split_once(' ')).collect()
}

#[test]
fn a_line_is_sent_as_the_sdk_sends_it() {
    let sdk = sdk();
    let pi = std::f64::consts::PI;
    for (name, x, speed) in [
        ("set_position", 300.0, 200.0),
        ("set_position_back", 600.0, 100.0),
    ] {
        let payload = line_payload([x, 50.0, 80.0, pi, 0.0, 0.0], speed, 2000.0, 0).unwrap();
        assert_eq!(
            hex(&request(1, Register::MoveLine, &payload)),
            sdk[name],
            "{name}"
        );
    }
}

#[test]
fn every_other_request_of_a_strike_and_its_stop_is_one_of_the_sdks() {
    in_time(|| {
        let sdk = sdk();
        let rig = rig();
        let (emulator, outcome) = undisturbed(Maker::XArm, &plan(&rig, Point::new(0.62, 0.0)));
        outcome.unwrap();
        let mut names: Vec<&str> = Vec::new();
        for (_, event) in emulator.events() {
            let Event::Request(sent) = event else {
                continue;
            };
            if sent.register() == Register::MoveLine as u8 {
                assert_eq!(sent.bytes.len(), sdk["set_position"].len() / 2);
                continue;
            }
            // Numbers of the rig's, and those that were put back.
            if matches!(sent.register(), 31 | 32) {
                assert_eq!(sent.bytes.len(), sdk["set_tcp_jerk"].len() / 2);
                continue;
            }
            let frame = hex(&[&[0, 1], &sent.bytes[2..]].concat());
            let name = sdk.iter().find(|(_, bytes)| **bytes == frame);
            names.push(
                name.unwrap_or_else(|| panic!("{frame} is none of the SDK's"))
                    .0,
            );
        }
        for name in [
            "get_version",
            "get_err_warn_code",
            "motion_enable",
            "set_state_again",
            "get_position",
        ] {
            assert!(names.contains(&name), "{name}: {names:?}");
        }
        assert_eq!(
            hex(&request(1, Register::SetState, &[4])),
            sdk["set_state_stop"]
        );
    });
}
