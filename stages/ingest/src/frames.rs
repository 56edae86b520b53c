//! From the frames and the clock of a log to the table's frame and the arm's clock, by what the rig file states of them.

use logs::Sample;
use values::{CommandFrame, Point, Rig};

use crate::arm::State;

/// Transformations of a log's messages into the table's frame and the arm's clock.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LogFrames {
    /// Nanoseconds by which the camera's stamps lie behind the arm's.
    delay: i64,
    mirrored: bool,
    /// Turn of the arm's frame, in rad, and its origin.
    turn: f64,
    origin: Point,
}

impl LogFrames {
    pub(crate) fn of(rig: &Rig) -> Self {
        let of_base = rig.frames.command == CommandFrame::Base;
        let robot = &rig.robot;
        Self {
            delay: (rig.frames.camera_delay * 1e9).round() as i64,
            mirrored: rig.frames.mirrored,
            turn: robot.base_yaw.filter(|_| of_base).unwrap_or(0.0),
            origin: robot.base.filter(|_| of_base).unwrap_or_default(),
        }
    }

    /// A centroid seen by the camera, in the table's frame and on the arm's clock.
    pub(crate) fn centroid(&self, sample: Sample) -> Sample {
        Sample::at(
            sample.stamp.saturating_sub(self.delay),
            Point::new(sample.x, if self.mirrored { -sample.y } else { sample.y }),
        )
    }

    /// A yaw (rad) seen by the camera, in the table's frame.
    pub(crate) fn yaw(&self, yaw: f64) -> f64 {
        if self.mirrored { -yaw } else { yaw }
    }

    /// A command of the arm, turned into the table's frame.
    pub(crate) fn command(&self, sample: Sample) -> Sample {
        if self.turn == 0.0 {
            return sample;
        }
        let turned = Point::new(sample.x, sample.y).rotated(self.turn);
        Sample::at(sample.stamp, turned)
    }

    /// A state of the arm, in the table's frame.
    pub(crate) fn state(&self, state: State) -> State {
        State {
            stamp: state.stamp,
            velocity: state.velocity.rotated(self.turn),
            position: state.position.rotated(self.turn) + self.origin,
        }
    }
}
