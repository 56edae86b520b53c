//! A rig file that is wrong.

use super::levels::{Disturbs, Levels};
use crate::declare::declare;

declare! {
    /// Numbers of the rig file are off by a share of themselves.
    WrongRigFile = "wrong_rig_file" {
        /// The object's sizes.
        object: 0.1, "1", Some(0.0);
        /// The object's mass.
        mass: 0.0, "1", Some(0.0);
        /// The tip's radius.
        tip: 0.0, "1", Some(0.0);
        /// The camera's noise.
        noise: 0.0, "1", Some(0.0);
    }
}

impl Disturbs for WrongRigFile {
    fn add_to(&self, levels: &mut Levels) {
        levels.object_error += self.object;
        levels.mass_error += self.mass;
        levels.tip_error += self.tip;
        levels.camera_noise_error += self.noise;
    }
}
