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
    /// A force across the motion, by speed.
    Sideways,
    /// Friction and a force across the motion, by its direction.
    Heading,
    /// Pushes in both directions, by time since the impact.
    Phase,
    /// Delivered speed and angle, by the commanded speed, by the commanded angle, and by both together.
    Speed,
    Angle,
    Command,
    /// Delivered speed and angle, by where the object lies.
    Start,
    /// Delivered speed and angle, by the number of strikes before.
    Order,
    /// Friction, by the number of strikes before.
    Wear,
}

/// Those that are looked at in every diagnosis.
pub(crate) const COVARIATES: [Covariate; 11] = [
    Covariate::Position,
    Covariate::Surface,
    Covariate::SlidingSpeed,
    Covariate::Sideways,
    Covariate::Heading,
    Covariate::Phase,
    Covariate::Speed,
    Covariate::Angle,
    Covariate::Start,
    Covariate::Order,
    Covariate::Wear,
];

impl Covariate {
    /// Whether it is one of a strike's launch, or of its friction as a whole.
    pub(crate) fn is_of_whole_strikes(self) -> bool {
        match self {
            Self::Speed | Self::Angle | Self::Command | Self::Start | Self::Order | Self::Wear => {
                true
            }
            Self::Position
            | Self::Surface
            | Self::SlidingSpeed
            | Self::Sideways
            | Self::Heading
            | Self::Phase => false,
        }
    }

    /// Its name in `diagnosis.json`.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Surface => "surface",
            Self::SlidingSpeed => "sliding_speed",
            Self::Sideways => "sideways",
            Self::Heading => "heading",
            Self::Phase => "phase",
            Self::Speed => "speed",
            Self::Angle => "angle",
            Self::Command => "command",
            Self::Start => "start",
            Self::Order => "order",
            Self::Wear => "wear",
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
        Family::RestitutionByOrder | Family::LaunchAngleByOrder => &[Covariate::Order],
        Family::FrictionByPlace => &[Covariate::Surface],
        Family::FrictionBySpeed => &[Covariate::SlidingSpeed],
        Family::FrictionByHeading | Family::SeenByHeading => &[Covariate::Heading],
        Family::LaunchByPlace => &[Covariate::Start],
        Family::LaunchSpeed | Family::RestitutionBySpeed => &[Covariate::Speed],
        Family::LaunchAngle => &[Covariate::Angle],
        // Not by commanded speed: bumps over that change the delivered speed too, and would take an arm that saturates.
        Family::LaunchAngleByCommand => &[Covariate::Angle],
        Family::ForceByPlace | Family::SeenByPlace => &[Covariate::Position],
    }
}

/// What another form of an effect would leave of launches: friction by speed that brakes by another law takes an object as much farther
/// or less far as a launch that errs by its speed. It stands beside no search, where it would take an arm that saturates.
pub(crate) fn left_of_launches(name: &str) -> &'static [Covariate] {
    match effect(name).map(|spec| spec.family) {
        Ok(Family::FrictionBySpeed) => &[Covariate::Speed],
        _ => &[],
    }
}
