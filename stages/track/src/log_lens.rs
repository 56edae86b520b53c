//! The lens that holds for the images of a log's topic: the rig file's, or the one that the log states.

use std::path::Path;

use values::Rig;

use crate::camera_info::{CameraInfo, MOST_BEND, is_rectified};
use crate::{Lens, TrackError};

/// A rig with the lens that holds for a topic's images.
pub(crate) struct LogLens {
    pub(crate) rig: Rig,
    /// Width and height of the images that it holds for, in px, where that is stated.
    pub(crate) size: Option<[usize; 2]>,
    /// What a person should know of it.
    pub(crate) note: Option<String>,
}

impl LogLens {
    /// The rig file's lens; where it has none, or the images were rectified and its lens is that of the images before, the log's.
    ///
    /// # Errors
    /// The log cannot be read, or what it says of the lens is of no use; the images were rectified, and nothing says to what lens.
    pub(crate) fn of(log: &Path, rig: &Rig, topic: &str) -> Result<Self, TrackError> {
        let size = rig.camera.size;
        let mut found = Self {
            rig: rig.clone(),
            size: size.map(|size| size.map(|pixels| pixels as usize)),
            note: None,
        };
        let Some(matrix) = rig.camera.matrix else {
            if let Some(info) = CameraInfo::of_log(log, topic)? {
                found.take(&info);
            }
            return Ok(found);
        };
        if !is_rectified(topic) {
            return Ok(found);
        }
        let own = Lens {
            matrix,
            distortion: rig.camera.distortion.unwrap_or_default(),
        };
        let info = match CameraInfo::of_log(log, topic) {
            Err(TrackError::CameraInfo { .. }) => None,
            other => other?,
        };
        match info.filter(|info| info.is_before(&own)) {
            Some(info) => {
                found.take(&info);
                let [fx, fy, cx, cy] = info.lens.matrix;
                found.note = Some(format!(
                    "the images of topic {topic} are rectified, and the rig file's lens is that of the images before: the projection of the log's \
                     CameraInfo is used; write matrix = [{fx:.2}, {fy:.2}, {cx:.2}, {cy:.2}] under [camera], without distortion"
                ));
            }
            None if own.bend() > MOST_BEND => {
                return Err(TrackError::Rectified {
                    log: log.display().to_string(),
                    topic: topic.to_owned(),
                    percent: 100.0 * own.bend(),
                });
            }
            None => {}
        }
        Ok(found)
    }

    fn take(&mut self, info: &CameraInfo) {
        self.rig.camera.matrix = Some(info.lens.matrix);
        self.rig.camera.distortion = Some(info.lens.distortion);
        self.size = Some(info.size);
    }
}
