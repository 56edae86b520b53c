//! What smooth dependences run over.

use world::effects::{Family, effect};

/// What a set of bumps does, and over what.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Covariate {
    /// Pushes in both directions, by place on the table.
    Position,
    /// Friction, by place on the table.
    Surface,
    /// Friction, by speed.
    SlidingSpeed,
    /// Friction and a force across the motion, by its direction.
    Heading,
    /// Delivered speed and angle, by the commanded speed, by the commanded angle, and by both together.
    Speed,
    Angle,
    Command,
    /// Delivered speed and angle, by where the object lies.
    Start,
    /// Delivered speed, by the number of strikes before.
    Order,
    /// Delivered angle, by the number of strikes before.
    Turning,
    /// Friction, by the number of strikes before.
    Wear,
}

impl Covariate {
    /// Whether it is one of a strike's launch, or of its friction as a whole.
    pub(crate) fn is_of_whole_strikes(self) -> bool {
        match self {
            Self::Speed
            | Self::Angle
            | Self::Command
            | Self::Start
            | Self::Order
            | Self::Turning
            | Self::Wear => true,
            Self::Position | Self::Surface | Self::SlidingSpeed | Self::Heading => false,
        }
    }
}

/// Over what an effect of another form than the library's would differ from it: what is left of a wrong form lies there.
pub(crate) fn family(name: &str) -> &'static [Covariate] {
    let Ok(spec) = effect(name) else {
        return &[];
    };
    match spec.family {
        Family::FrictionByOrder => &[Covariate::Wear],
        Family::RestitutionByOrder => &[Covariate::Order],
        Family::LaunchAngleByOrder => &[Covariate::Turning],
        Family::FrictionByPlace | Family::FrictionBySlide => &[Covariate::Surface],
        Family::FrictionBySpeed => &[Covariate::SlidingSpeed],
        Family::FrictionByHeading | Family::SeenByHeading => &[Covariate::Heading],
        Family::LaunchByPlace => &[Covariate::Start],
        Family::LaunchSpeed | Family::RestitutionBySpeed => &[Covariate::Speed],
        Family::LaunchAngle => &[Covariate::Angle],
        // Not by commanded speed: bumps over that change the delivered speed too, and would take an arm that saturates.
        Family::LaunchAngleByCommand => &[Covariate::Angle],
        Family::ForceByPlace
        | Family::ForceBySession
        | Family::SeenByPlace
        | Family::SeenBySide => &[Covariate::Position],
    }
}
