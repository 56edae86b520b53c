//! What viewers show of a tracked log: the images with the outline and the centre drawn in, and the object's pose.
//!
//! The topics are `sensor_msgs/msg/CompressedImage` and `geometry_msgs/msg/PoseStamped`, which Foxglove, Rerun and rviz draw as they are.

use std::io::BufWriter;

use durable::Output;
use logs::write::{CopyWriter, Stamped, WriteError};

use crate::frame::TrackedFrame;

/// Topic of the images with what was found drawn in.
const IMAGE_TOPIC: &str = "/carom/track/image";
/// Topic of the object's poses.
const POSE_TOPIC: &str = "/carom/track/object";

/// A file that gets its name when it is whole.
pub(crate) type LogFile<'a> = &'a mut BufWriter<Output>;

pub(crate) struct View<'a> {
    writer: CopyWriter<LogFile<'a>>,
}

impl<'a> View<'a> {
    pub(crate) fn new(file: LogFile<'a>) -> Result<Self, WriteError> {
        let writer = CopyWriter::new(file)?;
        Ok(Self { writer })
    }

    /// Adds a frame as it was tracked by itself; frames that are later rejected within the sequence are in it as well.
    pub(crate) fn add(&mut self, log_time: u64, tracked: &TrackedFrame) -> Result<(), WriteError> {
        let Ok(stamp) = u64::try_from(tracked.stamp) else {
            return Ok(());
        };
        if let Some(jpeg) = &tracked.drawn {
            self.writer.jpeg(IMAGE_TOPIC, log_time, stamp, jpeg)?;
        }
        if let Ok(centre) = tracked.observation.centre {
            let (x, y) = (centre.x, centre.y);
            let at = Stamped { stamp, x, y };
            let yaw = tracked.observation.yaw;
            self.writer.pose(POSE_TOPIC, log_time, &at, yaw)?;
        }
        Ok(())
    }

    pub(crate) fn finish(self) -> Result<(), WriteError> {
        self.writer.finish().map(drop)
    }
}
