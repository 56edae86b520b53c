//! Checks of the keys that images need: lens, pose and timing of the camera, the object's colour, the topic.

use std::f64::consts::TAU;

use super::super::{Camera, ImageTopic, Object, RigError, Shape};
use super::number::{finite, interval, value};
use crate::Interval;

/// Largest focal length or image coordinate in px.
const LARGEST_PIXEL: f64 = 100_000.0;
/// Largest coefficient of distortion: beyond it a lens folds the image over.
const LARGEST_DISTORTION: f64 = 100.0;
/// Farthest camera from the robot's base, in m.
const FARTHEST: f64 = 20.0;
/// What exposure and read-out may be longer than a frame's interval: rates are rounded.
const INTERVAL_SHARE: f64 = 0.01;
/// A quaternion's length may be off 1 by this much: what four decimals leave.
const UNIT: f64 = 1e-3;

/// Checks the camera's keys of this module.
pub(super) fn check_camera(camera: &Camera) -> Result<(), RigError> {
    let within = |key: &str, number: f64, low: f64, high: f64, unit: &str| {
        finite(key, number)?;
        if (low..=high).contains(&number) {
            Ok(())
        } else {
            Err(value(
                key,
                number,
                &format!("must lie within {low} and {high} {unit}"),
            ))
        }
    };
    if let Some([fx, fy, cx, cy]) = camera.matrix {
        for focal in [fx, fy] {
            within("camera.matrix", focal, 1.0, LARGEST_PIXEL, "px")?;
        }
        for centre in [cx, cy] {
            within("camera.matrix", centre, -LARGEST_PIXEL, LARGEST_PIXEL, "px")?;
        }
    }
    for pixels in camera.size.into_iter().flatten() {
        within("camera.size", pixels.into(), 1.0, LARGEST_PIXEL, "px")?;
    }
    for coefficient in camera.distortion.unwrap_or_default() {
        let most = LARGEST_DISTORTION;
        within("camera.distortion", coefficient, -most, most, "")?;
    }
    for coordinate in camera.position.unwrap_or_default() {
        within("camera.position", coordinate, -FARTHEST, FARTHEST, "m")?;
    }
    if let Some(position) = camera.position
        && position[2] <= 0.0
    {
        let why = "must be above 0 m: a camera looks at the table from above";
        return Err(value("camera.position", position[2], why));
    }
    if let Some(orientation) = camera.orientation {
        let length = orientation.iter().map(|part| part * part).sum::<f64>();
        let off = (length.sqrt() - 1.0).abs();
        if off.is_nan() || off > UNIT {
            let why = "must be a quaternion [x, y, z, w] of length 1";
            return Err(value("camera.orientation", length.sqrt(), why));
        }
    }
    let interval = 1.0 / camera.rate;
    for (key, time) in [
        ("camera.exposure", camera.exposure),
        ("camera.readout", camera.readout),
    ] {
        let time = time.unwrap_or(0.0);
        finite(key, time)?;
        if !(0.0..=(1.0 + INTERVAL_SHARE) * interval).contains(&time) {
            let why = format!(
                "must lie within 0 and {interval:.4} s, the interval of camera.rate = {} (seconds, not milliseconds?)",
                camera.rate
            );
            return Err(value(key, time, &why));
        }
    }
    Ok(())
}

/// Checks the object's colour.
pub(super) fn check_colour(object: &Object) -> Result<(), RigError> {
    let Some(colour) = &object.colour else {
        return Ok(());
    };
    for degrees in [colour.hue.low, colour.hue.high] {
        finite("object.colour.hue", degrees)?;
        if !(0.0..=360.0).contains(&degrees) {
            let why = "must lie within 0 and 360 degrees";
            return Err(value("object.colour.hue", degrees, why));
        }
    }
    let shares: [(&str, Interval); 2] = [
        ("object.colour.saturation", colour.saturation),
        ("object.colour.value", colour.value),
    ];
    for (key, share) in shares {
        interval(key, share)?;
        for end in [share.low, share.high] {
            if !(0.0..=1.0).contains(&end) {
                return Err(value(key, end, "must lie within 0 and 1"));
            }
        }
    }
    Ok(())
}

/// Checks the marker on the object's upper face.
pub(super) fn check_marker(object: &Object) -> Result<(), RigError> {
    let Some(marker) = &object.marker else {
        return Ok(());
    };
    if object.shape() == Shape::Sphere {
        return Err(RigError::Value {
            key: "object.marker.dictionary".into(),
            value: format!("{:?}", marker.dictionary),
            why: "a sphere has no face on which a marker lies; take the marker out".into(),
        });
    }
    let (size, across) = (marker.size, 2.0 * object.solid.reach());
    finite("object.marker.size", size)?;
    if size <= 0.0 || size > across {
        let why = format!("must be above 0 m and at most {across:.3} m, the object's own width");
        return Err(value("object.marker.size", size, &why));
    }
    let far = marker.offset.norm();
    if !marker.offset.is_finite() || far > object.solid.reach() {
        let why = "must lie on the object, in m from its centre";
        return Err(value("object.marker.offset", far, why));
    }
    finite("object.marker.yaw", marker.yaw)?;
    if marker.yaw.abs() > TAU {
        let why = "must lie within ±6.2832 rad (radians, not degrees?)";
        return Err(value("object.marker.yaw", marker.yaw, why));
    }
    Ok(())
}

pub(super) fn check_topic(topic: Option<&ImageTopic>) -> Result<(), RigError> {
    let Some(topic) = topic else { return Ok(()) };
    let refused = |key: &str, text: &str, why: &str| {
        Err(RigError::Value {
            key: key.into(),
            value: format!("{text:?}"),
            why: why.into(),
        })
    };
    if topic.name.trim().is_empty() {
        return refused("topics.image.name", &topic.name, "must not be empty");
    }
    if !ImageTopic::STAMPS.contains(&topic.stamp.as_str()) {
        let why = "must be \"header.stamp\" (ROS) or \"timestamp\" (Foxglove): images have no other stamp that is read";
        return refused("topics.image.stamp", &topic.stamp, why);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::rig::tests::{refusal, refused};
    use crate::{Rig, Shape};

    const SEEING: &str = "matrix = [900.0, 900.0, 639.5, 359.5]\ndistortion = [-0.1, 0.02, 0.0, 0.0, 0.0]\n\
        position = [0.45, 0.0, 1.2]\norientation = [0.7071, -0.7071, 0.0, 0.0]\nexposure = 0.005\nreadout = 0.01\nstamp = \"start\"\n";

    fn with(camera: &str, object: &str) -> String {
        let text = Rig::template().replacen("[camera]\n", &format!("[camera]\n{camera}"), 1);
        text.replacen("[object]\n", &format!("[object]\n{object}"), 1)
    }

    #[test]
    fn a_camera_with_lens_and_pose_survives_a_round_trip() {
        let colour = "colour = { hue = [340, 20], saturation = [0.4, 1.0], value = [0.2, 1.0] }\n\
            marker = { dictionary = \"DICT_APRILTAG_36h11\", id = 7, size = 0.03, offset = [0.002, 0] }\n";
        let text = with(SEEING, colour) + "\n[topics.image]\nname = \"/camera/image\"\n";
        let rig = Rig::parse(&text).expect("parses");
        assert_eq!(
            rig.topics.image.as_ref().map(|topic| topic.stamp.as_str()),
            Some("header.stamp")
        );
        assert_eq!(Rig::parse(&rig.to_toml()).expect("parses"), rig);
    }

    #[test]
    fn a_rig_without_a_camera_of_images_is_written_as_before() {
        let text = Rig::demo(Shape::Cylinder).to_toml();
        for key in [
            "matrix",
            "exposure",
            "stamp = \"middle\"",
            "colour",
            "image",
        ] {
            assert!(!text.contains(key), "{key}: {text}");
        }
    }

    #[test]
    fn values_that_make_no_sense_are_refused() {
        refused(
            refusal,
            r#"
[camera] → [camera]\nmatrix = [0, 900, 1, 1] ⇒ camera.matrix
[camera] → [camera]\nsize = [0, 720] ⇒ camera.size
[camera] → [camera]\nsize = [640, 480, 3] ⇒ 2 numbers
[camera] → [camera]\nposition = [0, 0, -1] ⇒ from above
[camera] → [camera]\nposition = [0, 0, 1, 0] ⇒ 3 numbers
[camera] → [camera]\ndistortion = [0, 0, 0, 0, 0, 0.1, 0, 0] ⇒ 5 numbers
[camera] → [camera]\ndistortion = [0, 0, 0, 0] ⇒ 5 numbers
[camera] → [camera]\norientation = [0, 0, 0, 2] ⇒ length 1
[camera] → [camera]\nexposure = 0.02 ⇒ 0.0167 s, the interval
[camera] → [camera]\nreadout = 0.03 ⇒ camera.readout
[camera] → [camera]\nreadout = nan ⇒ finite
[camera] → [camera]\nfocal = 3 ⇒ camera.focal
[object] → [object]\ncolour = { hue = [0, 400], saturation = [0, 1], value = [0, 1] } ⇒ 360
[object] → [object]\ncolour = { hue = [0, 40], saturation = [1, 0], value = [0, 1] } ⇒ reversed
[object] → [object]\ncolour = { hue = [0, 40] } ⇒ object.colour.
[object] → [object]\nmarker = { dictionary = "DICT_4X4_50", id = 0 } ⇒ object.marker.size
[object] → [object]\nmarker = { dictionary = "DICT_4X4_50", id = 0, size = 36 } ⇒ the object's own width
[object] → [object]\nmarker = { dictionary = "DICT_4X4_50", id = 0, size = 0.03, offset = [3, 0] } ⇒ must lie on the object
[object] → [object]\nmarker = { dictionary = "DICT_4X4_50", id = 0, size = 0.03, yaw = 90 } ⇒ not degrees
[object] → [object]\nmarker = { dictionary = "DICT_4X4_50", number = 0, size = 0.03 } ⇒ object.marker.number
"#,
        );
    }

    #[test]
    fn an_images_stamp_is_one_that_images_have() {
        let with_stamp = |stamp: &str| {
            let topic = format!("\n[topics.image]\nname = \"/image\"\nstamp = \"{stamp}\"\n");
            Rig::parse(&(with("", "") + &topic))
        };
        for stamp in ["header.stamp", "timestamp"] {
            assert!(with_stamp(stamp).is_ok(), "{stamp}");
        }
        for stamp in ["", "header.stmp", "log_time"] {
            let error = with_stamp(stamp).expect_err("refused").to_string();
            assert!(error.contains("header.stamp"), "{stamp}: {error}");
        }
    }
}
