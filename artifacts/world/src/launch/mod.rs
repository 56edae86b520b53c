//! How each strike's object leaves the tip: MuJoCo's impact as commanded and a little beside it, interpolated.
//!
//! A candidate that changes the command, the tip's line or restitution then needs no simulation of contact at all.

use crate::{Impact, Release, releases::Scaled};

pub use around::{launches, launches_about};

mod around;

/// One strike's release around its command: a parabola in each of five directions.
#[derive(Clone, Copy, Debug)]
pub struct Launch {
    about: Impact,
    base: Scaled,
    slope: [Scaled; 5],
    bend: [Scaled; 5],
}

impl Launch {
    fn bends(&mut self, direction: usize, step: f64, after: Scaled, before: Scaled) {
        for i in 0..self.base.len() {
            self.slope[direction][i] = (after[i] - before[i]) / (2.0 * step);
            self.bend[direction][i] =
                (after[i] + before[i] - 2.0 * self.base[i]) / (2.0 * step * step);
        }
    }

    /// The release of this strike for an impact near its command.
    pub fn release(&self, impact: &Impact) -> Release {
        let away = [
            impact.command.speed / self.about.command.speed - 1.0,
            // Onto the face of a box that is turned.
            impact.command.angle - self.about.command.angle - (impact.yaw - self.about.yaw),
            impact.tip_offset - self.about.tip_offset,
            impact.restitution - self.about.restitution,
            impact.tip_friction - self.about.tip_friction,
        ];
        let mut state = self.base;
        for ((away, slope), bend) in away.iter().zip(&self.slope).zip(&self.bend) {
            for i in 0..state.len() {
                state[i] += away * (slope[i] + away * bend[i]);
            }
        }
        Release::of(state, impact.command)
    }
}
