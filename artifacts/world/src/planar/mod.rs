//! The slide without contacts: planar motion under friction, integrated in long steps.
//!
//! The same world as MuJoCo's, a hundred times faster: from where the tip lets go the object is one planar body that rubs on
//! an even base ([`Base`]), which MuJoCo's steps approach as well. The effects act
//! through the same functions in both. What is found here is fitted and judged in MuJoCo afterwards.

mod forces;
mod sliding;
mod strike;
#[cfg(test)]
mod tests;
mod world;

pub use strike::{Deviation, Frames, StrikeInput};
pub use world::{Planar, Push, gyration};

use values::{Conditions, Point};

use crate::{
    Impact, Release, effects,
    launch::Launch,
    planar::{
        forces::Forces,
        sliding::{ABREAST, Sliding, to_rest},
    },
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

    /// How the object leaves the tip.
    pub fn release(&self, input: &StrikeInput<'_>, launch: &Launch) -> Release {
        let delivered =
            effects::deliver(self.effects, input.command, input.initial, input.conditions);
        let impact = Impact::of(self.effects, self.restitution, delivered, input.conditions);
        launch.release(&impact)
    }

    /// What is the same all through one slide: deceleration by dry friction, and force per unit mass, both in m/s².
    pub fn even(&self, conditions: &Conditions) -> (f64, Point) {
        Forces::new(self, conditions, 0.0).even()
    }

    /// The slide alone, from where the tip lets go of the object.
    pub fn slide(
        &self,
        input: &StrikeInput<'_>,
        release: Release,
        deviation: &Deviation,
    ) -> Option<Frames> {
        let mut alone = [Sliding::new(self, input, release, deviation)];
        to_rest(&mut alone);
        let [object] = alone;
        object.ended()
    }
}

/// A strike to simulate.
#[derive(Clone, Copy)]
pub struct Job<'j> {
    /// The world.
    pub planar: &'j Planar<'j>,
    /// The strike.
    pub input: StrikeInput<'j>,
    /// How its object leaves the tip.
    pub launch: &'j Launch,
    /// What differs.
    pub deviation: Deviation,
}

/// As [`Planar::strike`], several at once: each waits for its own square roots, and so they take little longer than one.
pub fn strikes(jobs: &[Job<'_>]) -> Vec<Option<Frames>> {
    jobs.chunks(ABREAST)
        .flat_map(|jobs| {
            let mut objects: Vec<Sliding<'_>> = jobs
                .iter()
                .map(|job| {
                    let release = job.planar.release(&job.input, job.launch);
                    Sliding::new(job.planar, &job.input, release, &job.deviation)
                })
                .collect();
            to_rest(&mut objects);
            objects.into_iter().map(Sliding::ended)
        })
        .collect()
}
