//! A world compiled for one rig.

use std::sync::{Arc, OnceLock};

use values::{Command, Conditions, Point, Rig, Shape, Solid};

use crate::{
    Base, Delivery, GRAVITY, Impact, Profile, Shift, World, WorldError,
    effects::{self, Effect},
    engine::{Engine, Scene, TableContact},
    impact::ContactDuration,
    planar::{self, Planar},
    releases::Releases,
    scene,
    touch::{self, Nearest},
};

/// Lengths of the integration steps, in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// While tip and object touch or are close.
    pub contact: f64,
    /// While the object slides alone.
    pub slide: f64,
}

impl Default for Steps {
    /// 0.0125 ms and 8 ms: halving both moves no stop by 0.5 mm (tested).
    fn default() -> Self {
        Self {
            contact: 0.0125e-3,
            slide: 8e-3,
        }
    }
}

/// A world compiled for one rig. Shared between threads; each strikes with a [`Worker`] of its own.
pub struct Simulator {
    pub(crate) rig: Rig,
    pub(crate) scene: Arc<Scene>,
    pub(crate) effects: Arc<[Box<dyn Effect>]>,
    /// A learnt correction of what the arm delivers, beside the effects.
    delivery: Option<Arc<dyn Delivery>>,
    /// How the table changed for good since it was identified, and how it differs from that now.
    own: Shift,
    shift: Shift,
    /// Friction between object and table, shifts included.
    pub(crate) friction: f64,
    restitution: f64,
    pub(crate) contact_time: f64,
    pub(crate) tip_friction: f64,
    base: Base,
    rolling_in_slip: f64,
    /// Square of the radius of gyration about the vertical in m².
    pub(crate) gyration: f64,
    pub(crate) releases: Releases,
    /// How much MuJoCo's contact launches faster for its duration; measured by the first worker that strikes.
    pub(crate) contact_duration: OnceLock<ContactDuration>,
    pub(crate) steps: Steps,
}

impl Simulator {
    /// Compiles a world for a rig. Errors name what the world holds that cannot be.
    pub fn new(rig: &Rig, world: &World) -> Result<Self, WorldError> {
        Self::with_steps(rig, world, Steps::default())
    }

    /// Compiles a world for a rig, with other step lengths than the usual ones.
    pub fn with_steps(rig: &Rig, world: &World, steps: Steps) -> Result<Self, WorldError> {
        world.check()?;
        let scene = Scene::compile(&scene::mjcf(rig, world)?, rig.object.mass * GRAVITY)?;
        Ok(Self {
            rig: rig.clone(),
            effects: world
                .effects
                .iter()
                .map(|added| effects::build(added, rig))
                .collect::<Result<_, _>>()?,
            delivery: None,
            own: world.shift,
            shift: Shift::default(),
            friction: world.value("friction")? * world.shift.friction.exp(),
            restitution: world.value("restitution")?,
            contact_time: world.value("contact_time")?,
            tip_friction: world.value("tip_friction")?,
            base: Base::new(rig, world)?,
            rolling_in_slip: world.value("rolling_in_slip")?,
            gyration: planar::gyration(rig) * world.value("inertia_z")?,
            releases: Releases::default(),
            contact_duration: OnceLock::new(),
            scene: Arc::new(scene),
            steps,
        })
    }

    /// This world with a learnt correction of what its arm delivers.
    pub fn with_delivery(self, delivery: Arc<dyn Delivery>) -> Self {
        Self {
            delivery: Some(delivery),
            ..self
        }
    }

    /// This world on a table that differs by `shift` from the world's own, in place of any shift before. What is compiled is shared.
    pub fn shifted(&self, shift: Shift) -> Self {
        self.on(self.own, shift)
    }

    /// This world on the table as it was when the world was identified.
    pub fn as_identified(&self) -> Self {
        self.on(Shift::default(), Shift::default())
    }

    fn on(&self, own: Shift, shift: Shift) -> Self {
        let by = own.and(shift).friction - self.whole_shift().friction;
        Self {
            rig: self.rig.clone(),
            scene: self.scene.clone(),
            effects: self.effects.clone(),
            delivery: self.delivery.clone(),
            own,
            shift,
            friction: self.friction * by.exp(),
            releases: Releases::default(),
            contact_duration: self.contact_duration.clone(),
            ..*self
        }
    }

    /// How the table differs from the world's own, which holds the world's lasting changes already.
    pub fn shift(&self) -> Shift {
        self.shift
    }

    /// Whether the table is as it was identified.
    pub fn is_as_identified(&self) -> bool {
        self.whole_shift().is_none()
    }

    /// How the table differs from the one on which the world was identified: lasting changes, then the present shift.
    pub(crate) fn whole_shift(&self) -> Shift {
        self.own.and(self.shift)
    }

    /// What the arm makes of a command, in m/s and rad, where the object lies at `from` (m): effects, the correction, then how the table
    /// differs.
    pub fn delivered(&self, command: Command, from: Point, conditions: &Conditions) -> Command {
        let by_effects = |command| effects::deliver(&self.effects, command, from, conditions);
        let delivered = match &self.delivery {
            Some(delivery) => delivery.deliver(command, &by_effects),
            None => by_effects(command),
        };
        let shift = self.whole_shift();
        Command::new(
            delivered.speed * shift.gain.exp(),
            delivered.angle + shift.heading,
        )
    }

    /// The compiled model in MuJoCo's binary format (.mjb), for other programs that load the same release's. Its tip and
    /// object have no spring and damper yet, nor does friction follow the slip: a strike sets both ([`Worker::strike`]).
    pub fn to_mjb(&self) -> Vec<u8> {
        self.scene.to_mjb()
    }

    /// The rig that it was compiled for.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Sliding friction and restitution, for a first guess.
    pub(crate) fn coefficients(&self) -> (f64, f64) {
        (self.friction, self.restitution)
    }

    /// How the object touches the table.
    pub(crate) fn table_contact(&self) -> TableContact {
        match self.rig.object.solid {
            Solid::Sphere { radius } => TableContact::Ball(radius, self.rolling_in_slip),
            Solid::Cylinder { .. } | Solid::Box { .. } => {
                TableContact::Flat(self.base, self.gyration)
            }
        }
    }

    /// Where a tip at this position and the object are nearest.
    pub(crate) fn nearest(&self, engine: &Engine, tip: Point) -> Nearest {
        let (object, striker) = (&self.rig.object, &self.rig.striker);
        touch::nearest(object, striker, engine.position(), engine.yaw(), tip)
    }

    /// The yaw (rad) that a simulation takes for this object: 0 for a round one, which rubs and is struck alike however it is turned.
    pub(crate) fn yaw_of(&self, yaw: f64) -> f64 {
        match self.rig.object.shape() {
            Shape::Box => yaw,
            Shape::Cylinder | Shape::Sphere => 0.0,
        }
    }

    /// What the arm makes of a command.
    pub(crate) fn impact(&self, command: Command, from: Point, conditions: &Conditions) -> Impact {
        self.delivered_impact(self.delivered(command, from, conditions), conditions)
    }

    /// The impact of a tip with this speed and angle, as delivered.
    pub(crate) fn delivered_impact(&self, delivered: Command, conditions: &Conditions) -> Impact {
        Impact::of(&self.effects, self.restitution, delivered, conditions)
    }

    /// The world's planar form; none for a ball, which rolls.
    pub(crate) fn planar(&self) -> Option<Planar<'_>> {
        (self.rig.object.shape() != Shape::Sphere).then(|| {
            Planar::of(
                [self.friction, self.restitution],
                self.base,
                self.gyration,
                &self.effects,
            )
        })
    }

    /// Where the camera sees an object that is at `point`.
    pub(crate) fn observe(&self, point: Point) -> Point {
        effects::observe(&self.effects, point)
    }

    /// The tip's motion for a command, as the arm would be sent it: towards the object seen at `initial`, turned as `conditions` say.
    pub fn profile(
        &self,
        initial: Point,
        command: Command,
        conditions: &Conditions,
    ) -> Option<Profile> {
        let yaw = self.yaw_of(conditions.yaw.unwrap_or(0.0));
        let direction = Point::polar(1.0, command.angle - yaw);
        let standoff = touch::standoff(&self.rig.object, &self.rig.striker, direction, 0.0)?;
        Some(Profile::plan(
            initial,
            command,
            self.rig.robot.acceleration,
            standoff,
        ))
    }
}
