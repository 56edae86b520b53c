//! What is said of a log's frames: counts, that the camera was pushed, what is not known of its timing.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use values::{Object, Point, StampMark};

use crate::readout::Readout;
use crate::{CameraModel, Reason};

/// What was seen up to now.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    /// The keys of the camera's timing that are not stated, and the readout that the images told.
    unstated: Option<&'static str>,
    readout: Option<Readout>,
    /// Standard deviation of what is not known of when the object was seen, in s.
    unsure: f64,
    /// Frames in which the table is elsewhere, when the first of them was taken (ns), and how far at the most (px).
    moved: u64,
    first: i64,
    farthest: f64,
    /// The fastest that the object was between two frames, in m/s, and the last one's stamp and place.
    fastest: f64,
    last: Option<(i64, Point)>,
    /// How fast it was between the last two frames, in m/s.
    speed: f64,
    /// How far it moved between them, and between those before, in m.
    steps: [f64; 2],
    /// How fast it leaves an impact at the most, in m/s, and how far it moves within an exposure then, in m.
    fastest_start: f64,
    blur: f64,
    /// How large the object's marker was seen in each frame, of what it is.
    scales: Vec<f64>,
    /// The point below the camera, and the place of the object that is farthest from it.
    foot: Point,
    outermost: Option<Point>,
}

/// Frames that are no single one that was misjudged.
const FEWEST_MOVED: u64 = 3;
/// An object that is slower than this, in m/s, is hardly put elsewhere by a camera's timing.
const SLOW: f64 = 0.1;
/// An object that moves by less than so many deviations of its place rests.
const AT_REST: f64 = 4.0;
/// Frames that are farther apart, in s, tell no speed, and an object that is put elsewhere by a hand is none that was struck.
const APART: f64 = 0.1;
const FASTEST: f64 = 3.0;

/// When a row is seen after a stamp whose exposure and readout are not known, in s: up to the 33 ms of an image of most cameras, as likely
/// the one as the other.
const UNKNOWN: f64 = 0.033 * 0.289;

/// The keys of the camera's timing that are not stated, as the subject of a sentence; none where both are.
fn unstated(camera: &CameraModel) -> Option<&'static str> {
    match (camera.exposure, camera.readout) {
        (None, None) => Some("camera.exposure and camera.readout are"),
        (Some(_), None) => Some("camera.readout is"),
        (None, Some(_)) => Some("camera.exposure is"),
        (Some(_), Some(_)) => None,
    }
}

impl Notes {
    /// Nothing seen yet, by a camera whose readout is stated, or was told by the images, or neither; the
    /// object leaves an impact at so many m/s at the most.
    pub(crate) fn of(camera: &CameraModel, readout: Option<Readout>, fastest: f64) -> Self {
        let unstated = match readout {
            None => unstated(camera),
            Some(_) => (camera.exposure.is_none() && camera.stamp != StampMark::Middle)
                .then_some("camera.exposure is"),
        };
        let unsure = unstated.map_or(0.0, |_| UNKNOWN);
        Self {
            unstated,
            readout,
            fastest_start: fastest,
            blur: fastest * camera.exposure.unwrap_or_default(),
            foot: Point::new(camera.position[0], camera.position[1]),
            unsure: unsure.hypot(readout.map_or(0.0, |readout| readout.deviation)),
            ..Self::default()
        }
    }

    /// Adds a frame: its stamp (ns), the object's centre, and how far the table is seen from where it was (px).
    pub(crate) fn add(&mut self, stamp: i64, centre: Option<Point>, [x, y]: [f64; 2]) {
        let far = x.hypot(y);
        if far > 0.0 {
            if self.moved == 0 {
                self.first = stamp;
            }
            self.moved += 1;
            self.farthest = self.farthest.max(far);
        }
        self.speed = 0.0;
        self.steps = [0.0, self.steps[0]];
        let Some(centre) = centre else { return };
        let is_farther = |other: Point| self.foot.distance(centre) > self.foot.distance(other);
        if self.outermost.is_none_or(is_farther) {
            self.outermost = Some(centre);
        }
        if let Some((last, place)) = self.last.replace((stamp, centre)) {
            let seconds = 1e-9 * (stamp - last) as f64;
            let speed = centre.distance(place) / seconds;
            if (0.0..APART).contains(&seconds) && speed < FASTEST {
                self.fastest = self.fastest.max(speed);
                self.speed = speed;
                self.steps[0] = centre.distance(place);
            }
        }
    }

    /// Adds how large the object's marker was seen, of what it is.
    pub(crate) fn add_marker(&mut self, scale: f64) {
        self.scales.push(scale);
    }

    /// The place of the object that is farthest from the point below the camera.
    pub(crate) fn outermost(&self) -> Option<Point> {
        self.outermost
    }

    /// Standard deviation (m) of a coordinate of the last frame's centre for what is not known of the camera's timing: nothing where that is
    /// stated, or the object rests.
    pub(crate) fn late(&self) -> f64 {
        self.unsure * self.speed
    }

    /// Standard deviation (m) of a coordinate of the last frame's centre, itself known to `deviation`, for an impact just before, or within its exposure: what is
    /// seen is the mean place, and not that of its middle. They differ by as much as it has moved, and by an eighth of what it moves in an
    /// exposure at the most.
    pub(crate) fn started(&self, deviation: f64) -> f64 {
        let [step, before] = self.steps;
        let still = AT_REST * deviation;
        if before > still || step < still {
            return 0.0;
        }
        let of_exposure = if step < 0.5 * self.blur {
            0.5 * step.min(0.125 * self.blur)
        } else {
            0.0
        };
        // How fast it is the step before the impact does not tell.
        of_exposure.hypot(0.5 * self.fastest_start * self.unsure)
    }

    /// How large the object's marker is seen, of what it is: the median of the log.
    pub(crate) fn marker(&mut self) -> Option<f64> {
        let middle = self.scales.len() / 2;
        self.scales.sort_unstable_by(f64::total_cmp);
        self.scales.get(middle).copied()
    }

    pub(crate) fn said(&self, camera: &CameraModel) -> Vec<String> {
        let mut said = Vec::new();
        if self.moved >= FEWEST_MOVED {
            let [fx, ..] = camera.lens.matrix;
            let (frames, farthest) = (self.moved, self.farthest);
            let (seconds, mm) = (
                1e-9 * self.first as f64,
                1e3 * farthest * camera.position[2] / fx,
            );
            said.push(format!(
                "the camera was moved: from {seconds:.3} s on the table is seen up to {farthest:.1} px ({mm:.1} mm) from where it was before, in \
                 {frames} frames; their centres are corrected by that, a new pose is better: `carom camera calibrate`"
            ));
        }
        if let (Some(readout), true) = (self.readout, self.fastest > SLOW) {
            let [ms, unsure] = [readout.seconds, readout.deviation].map(|seconds| 1e3 * seconds);
            let speed = self.fastest;
            said.push(format!(
                "camera.readout is not stated: {ms:.1} ms are taken, by how a moving object is sheared in the images. They are known to {unsure:.1} ms, \
                 which at {speed:.1} m/s puts it {:.1} mm off along its way; write camera.readout into the rig file if you know it",
                unsure * speed
            ));
        }
        if let (Some(keys), true) = (self.unstated, self.fastest > SLOW) {
            let speed = self.fastest;
            said.push(format!(
                "{keys} not stated: at {speed:.1} m/s each millisecond of them puts a moving object {speed:.1} mm off along its way; a webcam's \
                 shutter that rolls in 30 ms up to {:.0} mm. Where it rests, it is not put off. Of a global shutter write readout = 0.0",
                30.0 * speed
            ));
        }
        said
    }
}

/// That the object is seen to be of another height (m, with its deviation) than stated, and what that costs (m) at a place.
pub(crate) fn said_of_height(
    [seen, deviation]: [f64; 2],
    object: &Object,
    (place, off): (Point, f64),
) -> String {
    let stated = 2.0 * object.solid.half_height();
    let mend = match object.solid {
        values::Solid::Box {
            half_size: [x, y, _],
        } => {
            format!("half_size = [{x}, {y}, {:.4}]", 0.5 * seen)
        }
        _ => format!("half_height = {:.4}", 0.5 * seen),
    };
    let [seen, deviation, stated, off] = [seen, deviation, stated, off].map(|metres| 1e3 * metres);
    format!(
        "the object is seen to be {seen:.0} mm tall (to {deviation:.0} mm, standard deviation), and the rig file says {stated:.0} mm: at x = {:.2}, y = {:.2} \
         that puts its centre up to {off:.1} mm off. Measure its height; what is seen would be {mend} under [object]",
        place.x, place.y
    )
}

/// A marker is printed and measured to this share.
const LEAST_SCALE: f64 = 0.015;

/// A sentence that the marker is seen larger or smaller than it is stated, and what that costs if its height (m) is wrong.
pub(crate) fn said_of_marker(scale: f64, height: f64, camera: &CameraModel) -> Option<String> {
    let far = camera.position[2] - height;
    let (what, percent) = if scale > 1.0 {
        ("larger", 100.0 * (scale - 1.0))
    } else {
        ("smaller", 100.0 * (1.0 - scale))
    };
    let higher = far * (1.0 - 1.0 / scale);
    ((scale - 1.0).abs() > LEAST_SCALE).then(|| {
        format!(
            "the object's marker is seen {percent:.1} % {what} than object.marker.size says: measure its black square again; if that is right, the \
             object's height or the camera's is off by {:.0} mm, which puts centres 0.3 m from the point below the camera {:.1} mm off",
            1e3 * higher.abs(),
            300.0 * higher.abs() / far,
        )
    })
}

/// What came of a log's images.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrackOutcome {
    /// Images seen.
    pub frames: u64,
    /// Images whose centroid was written.
    pub centroids: u64,
    /// Images whose centroid was written and whose yaw the object's marker told.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub poses: u64,
    /// Images without a centroid, by reason.
    pub reasons: BTreeMap<Reason, u64>,
    /// What a person should know of the log.
    pub notes: Vec<String>,
}

impl TrackOutcome {
    /// How many frames have a centroid, and why the others have none.
    pub fn sentence(&self) -> String {
        let Self {
            frames, centroids, ..
        } = self;
        let reasons = self.reasons.iter();
        let reasons: Vec<_> = reasons
            .map(|(reason, count)| format!("{count} {}", reason.name()))
            .collect();
        let others = if reasons.is_empty() {
            String::new()
        } else {
            format!("; without: {}", reasons.join(", "))
        };
        let poses = match self.poses {
            0 => String::new(),
            poses => format!(", {poses} of them with a yaw"),
        };
        format!("{centroids} of {frames} frames with a centroid{poses}{others}")
    }
}

/// Whether there is nothing to be said.
fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// Topic of what is said of every frame; JSON, see [`FrameReport`].
pub const QUALITY_TOPIC: &str = "/object/centroid/quality";

/// What is said of one frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameReport {
    /// Middle of the exposure of the object's rows, in ns.
    pub stamp: i64,
    /// Centre on the table in m, where it is trusted.
    pub x: Option<f64>,
    /// Its second coordinate.
    pub y: Option<f64>,
    /// Standard deviation of each coordinate in m, where it is trusted; of a moving object also for a timing that is not stated.
    pub deviation: Option<f64>,
    /// The object's yaw in rad, where its marker tells it.
    pub yaw: Option<f64>,
    /// Standard deviation of the yaw in rad.
    pub yaw_deviation: Option<f64>,
    /// How far the table is seen from where it was in the log's other images, in px: the camera was pushed. The centre is corrected by it.
    pub shift: [f64; 2],
    /// Share of outline and inside that agree with the object, 0 to 1.
    pub quality: f64,
    /// Why it is not trusted.
    pub reason: Option<Reason>,
}

pub(crate) const QUALITY_SCHEMA: &str = r#"{"type":"object","properties":{"stamp":{"type":"integer"},"x":{"type":["number","null"]},"y":{"type":["number","null"]},"deviation":{"type":["number","null"]},"yaw":{"type":["number","null"]},"yaw_deviation":{"type":["number","null"]},"shift":{"type":"array","items":{"type":"number"}},"quality":{"type":"number"},"reason":{"type":["string","null"]}}}"#;

#[cfg(test)]
mod tests {
    use values::{Rig, Shape};

    use super::*;

    #[test]
    fn a_moving_object_is_less_sure_where_the_cameras_timing_is_not_stated() {
        let mut rig = Rig::demo(Shape::Cylinder);
        rig.camera.matrix = Some([900.0, 900.0, 640.0, 360.0]);
        rig.camera.position = Some([0.5, 0.1, 1.2]);
        rig.camera.orientation = Some([1.0, 0.0, 0.0, 0.0]);
        (rig.camera.exposure, rig.camera.readout) = (Some(0.004), None);
        let untold = CameraModel::of(&rig).expect("complete");
        rig.camera.readout = Some(0.0);
        let told = CameraModel::of(&rig).expect("complete");
        let seen = Readout {
            seconds: 0.02,
            deviation: 0.003,
        };
        let mut all = [(&untold, None), (&told, None), (&untold, Some(seen))]
            .map(|(camera, readout)| Notes::of(camera, readout, 0.0));
        let mut late = |stamp: i64, x: f64| {
            all.each_mut().map(|notes| {
                notes.add(stamp, Some(Point::new(x, 0.0)), [0.0; 2]);
                notes.late()
            })
        };
        assert_eq!(late(0, 0.4), [0.0; 3], "nothing to compare with");
        // 0.6 m/s.
        let [untold, told, seen] = late(33_333_333, 0.42);
        assert!((untold - 0.6 * UNKNOWN).abs() < 1e-6, "{untold}");
        assert_eq!(told, 0.0);
        assert!((seen - 0.6 * 0.003).abs() < 1e-6, "{seen}");
        assert_eq!(late(66_666_666, 0.42), [0.0; 3], "at rest");
    }

    #[test]
    fn an_impact_within_an_exposure_makes_its_frame_less_sure() {
        let mut notes = Notes {
            blur: 0.016,
            ..Notes::default()
        };
        let mut started = |frame: i64, x: f64| {
            notes.add(33_333_333 * frame, Some(Point::new(x, 0.0)), [0.0; 2]);
            notes.started(0.0001)
        };
        assert_eq!([started(0, 0.4), started(1, 0.4)], [0.0; 2], "at rest");
        assert!(
            (started(2, 0.403) - 0.001).abs() < 1e-9,
            "an eighth of 16 mm"
        );
        assert_eq!(started(3, 0.43), 0.0, "it moves");
        assert_eq!([started(4, 0.43), started(5, 0.43)], [0.0; 2]);
        assert_eq!(started(6, 0.45), 0.0, "the impact was before the exposure");
    }
}
