//! How a table differs today from the one that a world was identified on.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Friction, launch speed and heading beside a world's own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shift {
    /// Logarithm of the factor on friction between object and table, effects on it included.
    pub friction: f64,
    /// Logarithm of the factor on the speed that the arm delivers.
    pub gain: f64,
    /// What is added to the angle that the arm delivers, in rad.
    pub heading: f64,
}

impl Shift {
    /// Names of the fields of [`Shift`], in their order.
    pub const NAMES: [&str; 3] = ["friction", "gain", "heading"];

    /// Whether nothing differs.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// This shift followed by another: the sums of their fields.
    pub fn and(&self, other: Self) -> Self {
        Self {
            friction: self.friction + other.friction,
            gain: self.gain + other.gain,
            heading: self.heading + other.heading,
        }
    }

    /// The values of its fields, in the order of [`Shift::NAMES`].
    pub fn values(&self) -> [f64; 3] {
        [self.friction, self.gain, self.heading]
    }
}

impl From<[f64; 3]> for Shift {
    fn from([friction, gain, heading]: [f64; 3]) -> Self {
        Self {
            friction,
            gain,
            heading,
        }
    }
}

/// As a person reads it: `friction +12.0 %, launch speed −5.0 %, heading +1.50°`.
impl fmt::Display for Shift {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |ln: f64| 100.0 * (ln.exp() - 1.0);
        write!(
            f,
            "friction {:+.1} %, launch speed {:+.1} %, heading {:+.2}°",
            percent(self.friction),
            percent(self.gain),
            self.heading.to_degrees()
        )
    }
}
