//! What is said of a log's frames.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::Reason;

/// What came of a log's images.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrackOutcome {
    /// Images seen.
    pub frames: u64,
    /// Images whose centroid was written.
    pub centroids: u64,
    /// Of these, those whose yaw the object's marker told.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub poses: u64,
    /// The others, by reason.
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

/// Its JSON schema.
pub(crate) const QUALITY_SCHEMA: &str = r#"{"type":"object","properties":{"stamp":{"type":"integer"},"x":{"type":["number","null"]},"y":{"type":["number","null"]},"deviation":{"type":["number","null"]},"yaw":{"type":["number","null"]},"yaw_deviation":{"type":["number","null"]},"shift":{"type":"array","items":{"type":"number"}},"quality":{"type":"number"},"reason":{"type":["string","null"]}}}"#;
