//! What is known of a kind of effect before it is fitted.

use values::Rig;

use super::{
    action::Effect,
    parameters::{EffectParameter, Parameters, Values},
    start::{Experiment, FitStart},
};

/// One kind of effect.
pub struct EffectSpec {
    /// Name in `world.toml`, `diagnosis.json` and on the command line.
    pub name: &'static str,
    /// Its parameters.
    pub parameters: Parameters,
    /// Which quantity the effect makes depend on which.
    pub family: Family,
    /// Which part of the rig it belongs to.
    pub origin: Origin,
    /// Effects that do the same to the centroid tracks of one round object and one striker, or so nearly that strikes
    /// within a robot's limits do not distinguish them: named with it, never instead of it.
    pub equivalent: &'static [&'static str],
    /// Simpler effects that it can take the form of: it is named in the place of one only where the data show what it has
    /// beyond that one.
    pub contains: &'static [&'static str],
    /// When a diagnosis names it.
    pub naming: Naming,
    /// The phenomenon, and the formula's source.
    pub source: &'static str,
    /// Starting points of its fits on these strikes; none where they cannot determine it.
    pub starts: fn(&Experiment<'_>) -> Vec<FitStart>,
    /// Builds the effect from its parameters' values.
    pub build: fn(&Values, &Rig) -> Box<dyn Effect>,
    /// One sentence that states fitted values.
    pub statement: fn(&Values) -> String,
}

impl EffectSpec {
    /// The parameter of that name; where parameters are named by session, every name is one.
    pub fn parameter(&self, name: &str) -> Option<&EffectParameter> {
        self.parameters.get(name)
    }
}

/// When a diagnosis names an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Naming {
    /// Wherever it is the best explanation.
    Ordinary,
    /// Only where no simpler effects explain enough.
    LastResort,
    /// Only in the place of what was found of its kind, where it is likelier than all of that; on its own where tracks differ from all that was
    /// found.
    InPlace,
    /// Never: a foreign body on the table. Where it is likelier than what would be named in its place, nothing is named, and it is stated as the
    /// cause.
    Never,
}

/// Which part of the rig an effect belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The arm: what it delivers of a command. Where its state is logged, this is measured.
    Arm,
    /// Tip and object where they meet.
    Contact,
    /// The table under the object, or the object on it.
    Table,
    /// The camera's picture.
    Camera,
}

/// Which quantity an effect makes depend on which. A smooth dependence of the same kind holds all that a wrong form of the effect leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Friction, by the number of strikes before or the session.
    FrictionByOrder,
    /// Friction, by place on the table.
    FrictionByPlace,
    /// Friction or drag, by sliding speed.
    FrictionBySpeed,
    /// Friction, by how far the object has slid.
    FrictionBySlide,
    /// Friction, by the direction of the slide.
    FrictionByHeading,
    /// Force, by place on the table.
    ForceByPlace,
    /// Force, by session.
    ForceBySession,
    /// Launch speed, by commanded speed.
    LaunchSpeed,
    /// Restitution, by impact speed.
    RestitutionBySpeed,
    /// Restitution, by the number of strikes before.
    RestitutionByOrder,
    /// Launch angle, by commanded angle.
    LaunchAngle,
    /// Launch angle, by commanded speed and angle.
    LaunchAngleByCommand,
    /// Launch angle, by the number of strikes before or the session.
    LaunchAngleByOrder,
    /// Launch speed and angle, by where the object lies.
    LaunchByPlace,
    /// Position seen by the camera, by place on the table.
    SeenByPlace,
    /// Position seen by the camera, by the direction of the slide.
    SeenByHeading,
    /// Position seen by the camera, on either side of a line.
    SeenBySide,
}

impl Family {
    /// Whether it is a dependence on the number of strikes before, or on the session.
    pub fn is_by_order(self) -> bool {
        matches!(
            self,
            Self::FrictionByOrder
                | Self::RestitutionByOrder
                | Self::LaunchAngleByOrder
                | Self::ForceBySession
        )
    }

    /// Whether it is a dependence of restitution.
    pub fn is_of_restitution(self) -> bool {
        matches!(self, Self::RestitutionBySpeed | Self::RestitutionByOrder)
    }
}
