//! What smooth dependences run over.

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
    /// Pushes in both directions, by time since the impact.
    Phase,
    /// Delivered speed and angle, by the commanded speed, by the commanded angle, and by both together.
    Speed,
    Angle,
    Command,
    /// Delivered speed and angle, by the number of strikes before.
    Order,
    /// Friction, by the number of strikes before.
    Wear,
}

/// Those that are looked at in every diagnosis.
pub(crate) const COVARIATES: [Covariate; 9] = [
    Covariate::Position,
    Covariate::Surface,
    Covariate::SlidingSpeed,
    Covariate::Heading,
    Covariate::Phase,
    Covariate::Speed,
    Covariate::Angle,
    Covariate::Order,
    Covariate::Wear,
];

impl Covariate {
    /// Its name in `diagnosis.json`.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Surface => "surface",
            Self::SlidingSpeed => "sliding_speed",
            Self::Heading => "heading",
            Self::Phase => "phase",
            Self::Speed => "speed",
            Self::Angle => "angle",
            Self::Command => "command",
            Self::Order => "order",
            Self::Wear => "wear",
        }
    }
}

/// Over what an effect of another form than the library's would differ from it: what is left of a wrong form lies there.
pub(crate) fn family(effect: &str) -> &'static [Covariate] {
    match effect {
        "friction_drift" | "friction_by_session" => &[Covariate::Wear],
        "restitution_drift" | "striker_angle_by_session" => &[Covariate::Order],
        "friction_patch" | "friction_gradient" | "friction_step" | "friction_map" => {
            &[Covariate::Surface]
        }
        "viscous_drag" | "quadratic_drag" | "speed_weakening_friction" => {
            &[Covariate::SlidingSpeed]
        }
        "anisotropic_friction" => &[Covariate::Heading],
        "striker_speed_error" | "speed_dependent_restitution" => &[Covariate::Speed],
        "striker_angle_error" => &[Covariate::Angle, Covariate::Speed],
        "striker_angle_bias" | "off_centre_contact" | "camera_rotation" => &[Covariate::Angle],
        "table_tilt" | "table_bowl" | "camera_distortion" | "camera_lean" => &[Covariate::Position],
        _ => &[],
    }
}
