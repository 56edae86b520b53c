//! The model and data of one thread, in which strikes are simulated.

mod release;
mod strike;

use rayon::prelude::*;
use values::{Command, Point};

use crate::{
    Impact, Profile, Simulator, contact_solref, engine::Engine, impact::ContactDuration,
    tip_motion::TipMotion, touch,
};

/// A contact cannot restore less than this by its damper; below, the tip is slowed instead, to the same release speed.
const LEAST_CONTACT_RESTITUTION: f64 = 0.2;

impl Simulator {
    /// A worker: model and data of one thread.
    pub fn worker(&self) -> Worker<'_> {
        Worker {
            simulator: self,
            engine: self.scene.engine(self.table_contact()),
        }
    }

    /// Answers for items, each computed by itself and side by side with a worker a thread; in the order of the items.
    pub fn map<T: Sync, R: Send>(
        &self,
        items: &[T],
        answer: impl Fn(&mut Worker<'_>, &T) -> R + Sync,
    ) -> Vec<R> {
        items
            .par_iter()
            .map_init(|| self.worker(), |worker, item| answer(worker, item))
            .collect()
    }
}

/// One thread's model and data.
pub struct Worker<'a> {
    pub(crate) simulator: &'a Simulator,
    pub(crate) engine: Engine,
}

impl Worker<'_> {
    /// MuJoCo's steps so far, over all strikes: fine ones, and those of slides.
    pub fn steps(&self) -> [u64; 2] {
        self.engine.steps()
    }

    pub(crate) fn place_at_touch(&mut self, origin: Point, impact: Impact) -> Option<TipMotion> {
        let sim = self.simulator;
        let measured = sim
            .contact_duration
            .get_or_init(|| sim.worker().measure_contact_duration());
        self.place(origin, impact, *measured)
    }

    /// Places tip and object, with this taken back of what the contact's duration does.
    fn place(
        &mut self,
        origin: Point,
        impact: Impact,
        duration: ContactDuration,
    ) -> Option<TipMotion> {
        let sim = self.simulator;
        let (delivered, offset) = (impact.command, impact.tip_offset);
        let direction = Point::polar(1.0, delivered.angle);
        let yaw = sim.yaw_of(impact.yaw);
        let onto_face = Point::polar(1.0, delivered.angle - yaw);
        let standoff = touch::standoff(&sim.rig.object, &sim.rig.striker, onto_face, offset)?;
        let restitution = impact.restitution;
        let contact = restitution.clamp(LEAST_CONTACT_RESTITUTION, 0.99);
        let speed = delivered.speed * (1.0 + restitution) / (1.0 + contact);
        let speed = speed * duration.factor(speed, contact);
        let side = Point::new(-direction.y, direction.x) * offset;
        let profile = Profile::plan(
            origin + side,
            Command::new(speed, delivered.angle),
            sim.rig.robot.acceleration,
            standoff,
        );
        self.engine.reset();
        self.engine.place_object(origin, yaw);
        self.engine
            .set_strike_solref(contact_solref(sim.contact_time, contact, sim.steps.contact));
        self.engine.scale_friction(sim.whole_shift().friction.exp());
        Some(TipMotion::begin(profile, sim))
    }
}
