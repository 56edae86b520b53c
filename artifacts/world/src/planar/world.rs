//! A world in planar form.

use values::{Point, Rig, Solid};

use crate::{
    Base, World, WorldError,
    effects::{Acts, Effect},
};

/// A world in planar form.
pub struct Planar<'a> {
    /// Friction between object and table.
    pub friction: f64,
    /// Speed of parting over speed of approach.
    pub restitution: f64,
    /// What rubs on the table.
    pub base: Base,
    /// Square of the radius of gyration, in m².
    pub gyration: f64,
    pub(super) effects: &'a [Box<dyn Effect>],
    /// The effects that are constant during a slide, those that vary over it, and those on what a camera sees.
    pub(super) even: Vec<&'a dyn Effect>,
    pub(super) varying: Vec<&'a dyn Effect>,
    pub(super) seen: Vec<&'a dyn Effect>,
}

/// Square of the radius of gyration about the vertical, in m².
pub fn gyration(rig: &Rig) -> f64 {
    match rig.object.solid {
        Solid::Box {
            half_size: [x, y, _],
        } => (x * x + y * y) / 3.0,
        Solid::Cylinder { radius, .. } | Solid::Sphere { radius } => 0.5 * radius.powi(2),
    }
}

impl<'a> Planar<'a> {
    /// The planar form of a world with these effects in place of its own; of a cylinder or a box, for a ball rolls.
    pub fn new(
        rig: &Rig,
        world: &World,
        effects: &'a [Box<dyn Effect>],
    ) -> Result<Self, WorldError> {
        Ok(Self::of(
            [world.value("friction")?, world.value("restitution")?],
            Base::new(rig, world)?,
            gyration(rig) * world.value("inertia_z")?,
            effects,
        ))
    }

    /// A planar world of friction and restitution, a base, and the square of the radius of gyration in m².
    pub fn of(
        [friction, restitution]: [f64; 2],
        base: Base,
        gyration: f64,
        effects: &'a [Box<dyn Effect>],
    ) -> Self {
        let acting = |place: Acts| {
            let all = effects.iter().map(|effect| effect.as_ref());
            all.filter(|effect| effect.acts() == place).collect()
        };
        Self {
            friction,
            restitution,
            base,
            gyration,
            effects,
            even: acting(Acts::Strike),
            varying: acting(Acts::Slide),
            seen: acting(Acts::Camera),
        }
    }
}

impl Planar<'_> {
    pub(super) fn observe(&self, point: Point) -> Point {
        self.seen
            .iter()
            .fold(point, |seen, effect| effect.observe(seen))
    }
}
