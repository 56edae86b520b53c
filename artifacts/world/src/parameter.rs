//! Parameters and their values: those of the MuJoCo world that identification can free (the paper's list, section 3.3), ranges, estimates.

use serde::{Deserialize, Serialize};

use crate::WorldError;

/// One parameter: what it is and which values make sense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterSpec {
    /// Name in `world.toml`.
    pub name: &'static str,
    /// Value before anything is measured.
    pub nominal: f64,
    /// Least value that identification may try.
    pub low: f64,
    /// Greatest value that identification may try.
    pub high: f64,
    /// Unit; empty where it has none.
    pub unit: &'static str,
    /// What it does.
    pub meaning: &'static str,
}

const fn spec(
    name: &'static str,
    nominal: f64,
    [low, high]: [f64; 2],
    unit: &'static str,
) -> ParameterSpec {
    ParameterSpec {
        name,
        nominal,
        low,
        high,
        unit,
        meaning: "",
    }
}

impl ParameterSpec {
    const fn does(self, meaning: &'static str) -> Self {
        Self { meaning, ..self }
    }
}

/// All parameters. `contact_time` and `restitution` are the strike's `solref` in terms that can be identified. Restitution is the
/// whole launch factor: with one object and one striker, a mass ratio or a constant gain of speed cannot be distinguished from it.
pub const PARAMETERS: &[ParameterSpec] = &[
    spec("friction", 0.30, [0.0, 1.5], "").does("sliding friction between object and table"),
    spec("torsional_friction", 1.0, [0.0, 3.0], "× shape's").does(
        "friction against turning on the spot, relative to that of an even pressure on the \
         base (MuJoCo's friction[1])",
    ),
    spec("rolling_friction", 0.001, [0.0, 0.02], "m")
        .does("rolling friction of a ball: the torque over the load (MuJoCo's friction[2])"),
    spec("rolling_in_slip", 0.0, [0.0, 1.0], "")
        .does("how much of it acts while the ball still slips"),
    spec("restitution", 0.50, [-0.6, 0.99], "").does(
        "separation speed over approach speed of tip and object; below zero: delivered speed \
         falls short",
    ),
    spec("contact_time", 0.0005, [0.0004, 0.005], "s")
        .does("how long tip and object touch (half period of the undamped contact)"),
    spec("tip_friction", 0.50, [0.0, 1.5], "").does("sliding friction between tip and object"),
    spec("solimp_dmin", 0.99, [0.5, 0.999], "")
        .does("least impedance of the contact of tip and object (solimp[0])"),
    spec("solimp_dmax", 0.99, [0.5, 0.999], "")
        .does("greatest impedance of that contact (solimp[1])"),
    spec("solimp_width", 0.001, [0.0001, 0.01], "m")
        .does("penetration over which the impedance rises (solimp[2])"),
    spec("solimp_midpoint", 0.5, [0.1, 0.9], "")
        .does("midpoint of the impedance's rise (solimp[3])"),
    spec("solimp_power", 2.0, [1.0, 5.0], "").does("power of the impedance's rise (solimp[4])"),
    // Air slows a sliding body by some 0.01 per metre, far below what strikes can show, and MuJoCo's angular drag a ball that turns by as
    // much as a hard table does: none unless it is freed.
    spec("fluid_blunt_drag", 0.0, [0.0, 5.0], "")
        .does("blunt drag coefficient in air (fluidcoef[0])"),
    spec("fluid_slender_drag", 0.0, [0.0, 5.0], "")
        .does("slender drag coefficient in air (fluidcoef[1])"),
    spec("fluid_angular_drag", 0.0, [0.0, 10.0], "")
        .does("angular drag coefficient in air (fluidcoef[2])"),
    spec("fluid_kutta_lift", 1.0, [0.0, 5.0], "")
        .does("Kutta lift coefficient in air (fluidcoef[3])"),
    spec("fluid_magnus_lift", 1.0, [0.0, 5.0], "")
        .does("Magnus lift coefficient in air (fluidcoef[4])"),
    spec("inertia_x", 1.0, [0.2, 5.0], "× shape's")
        .does("moment of inertia about x, relative to the uniform shape's"),
    spec("inertia_y", 1.0, [0.2, 5.0], "× shape's")
        .does("moment of inertia about y, relative to the uniform shape's"),
    spec("inertia_z", 1.0, [0.2, 5.0], "× shape's")
        .does("moment of inertia about z, relative to the uniform shape's"),
];

/// The parameter of that name; the error lists the valid ones.
pub fn parameter(name: &str) -> Result<&'static ParameterSpec, WorldError> {
    PARAMETERS
        .iter()
        .find(|spec| spec.name == name)
        .ok_or_else(|| {
            let names: Vec<_> = PARAMETERS.iter().map(|spec| spec.name).collect();
            let nearest = names
                .iter()
                .max_by(|a, b| strsim::jaro(a, name).total_cmp(&strsim::jaro(b, name)))
                .filter(|near| strsim::jaro(near, name) > 0.7);
            WorldError::UnknownParameter {
                name: name.into(),
                hint: nearest
                    .map(|near| format!(", did you mean `{near}`?"))
                    .unwrap_or_default(),
                known: names.join(", "),
            }
        })
}

/// A finite value within its range, or an error that says so.
pub(crate) fn in_range(
    name: &str,
    value: f64,
    low: f64,
    high: f64,
    unit: &'static str,
) -> Result<(), WorldError> {
    if low <= value && value <= high {
        Ok(())
    } else {
        Err(WorldError::OutOfRange {
            name: name.into(),
            value,
            low,
            high,
            unit,
        })
    }
}

/// A value and its 95 % interval; a value that was not identified has none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Lower end of the 95 % interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Upper end of the 95 % interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
}

impl Estimate {
    /// A value that was taken, not measured.
    pub fn fixed(value: f64) -> Self {
        Self {
            value,
            low: None,
            high: None,
        }
    }

    /// A value with its 95 % interval.
    pub fn with_interval(value: f64, low: f64, high: f64) -> Self {
        Self {
            value,
            low: Some(low),
            high: Some(high),
        }
    }
}
