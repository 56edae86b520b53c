//! The slide without contacts: planar motion under friction, integrated in long steps.
//!
//! The same world as MuJoCo's, a hundred times faster: from where the tip lets go the object is one planar body that rubs on
//! an even base ([`Base`]), which MuJoCo's steps approach as well. The effects act
//! through the same functions in both. What is found here is fitted and judged in MuJoCo afterwards.

mod forces;
mod response;
mod sliding;
mod strike;
#[cfg(test)]
mod tests;
mod world;

pub use forces::Rate;
pub use response::{Node, Response, StartChange};
pub use strike::{Deviation, Frames, StrikeInput};
pub use world::{Planar, gyration};

use values::{Conditions, Point};

use crate::{
    Impact, Release, effects,
    launch::Launch,
    planar::{forces::Forces, sliding::Sliding},
};

impl Planar<'_> {
    /// One strike, seen at its own frames; `None` where it does not rest within 20 s. `launch` is that of a command near
    /// the strike's ([`crate::launch::launches`]).
    pub fn strike(
        &self,
        input: &StrikeInput<'_>,
        launch: &Launch,
        deviation: &Deviation,
    ) -> Option<Frames> {
        self.slide(input, self.release(input, launch), deviation)
    }

    /// How the object leaves the tip in this strike, interpolated from `launch`.
    pub fn release(&self, input: &StrikeInput<'_>, launch: &Launch) -> Release {
        let delivered =
            effects::deliver(self.effects, input.command, input.initial, input.conditions);
        let impact = Impact::of(self.effects, self.restitution, delivered, input.conditions);
        launch.release(&impact)
    }

    /// Deceleration by dry friction, and force per unit mass, both in m/s², from effects that are constant during a slide.
    pub fn even(&self, conditions: &Conditions) -> (f64, Point) {
        Forces::new(self, conditions, Point::default(), 0.0).even()
    }

    /// The slide alone, from where the tip lets go of the object.
    pub fn slide(
        &self,
        input: &StrikeInput<'_>,
        release: Release,
        deviation: &Deviation,
    ) -> Option<Frames> {
        Sliding::new(self, input, release, deviation).followed()
    }
}
