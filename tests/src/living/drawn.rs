//! A rig drawn at random, and what happens to its table at noon.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rig::{Hidden, Hide, Noise, Truth};
use serde::{Deserialize, Serialize};
use values::Shape;

/// What happens to a table once its version is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Case {
    Steady,
    /// The table changes once: friction ±12 %, launch −5 %, heading ±1.5°.
    Noon,
    /// A change at noon, and the second strike after it is bad: friction twice as great, that once.
    NoonBad,
    /// No change of the table, and the first strike is bad.
    SteadyBad,
    /// Friction walks by 0.6 % a strike, while the version learns and after.
    Wander,
}

impl Case {
    /// In the page's order.
    pub const ALL: [Self; 5] = [
        Self::Steady,
        Self::Noon,
        Self::NoonBad,
        Self::SteadyBad,
        Self::Wander,
    ];

    pub fn bad(self) -> Option<usize> {
        match self {
            Self::SteadyBad => Some(0),
            Self::NoonBad => Some(1),
            Self::Steady | Self::Noon | Self::Wander => None,
        }
    }
}

/// Phenomena that rigs have; one each.
const HIDDEN: [&[&str]; 4] = [
    &[],
    &["table_tilt"],
    &["viscous_drag"],
    &["speed_weakening_friction"],
];
/// Relative step of friction from strike to strike, of a table that wanders: 6 % over a hundred.
const STEP: f64 = 0.006;

pub struct LivingRig {
    pub number: u64,
    truth: Truth,
    /// Signs of the change of friction and heading.
    signs: [f64; 2],
}

impl LivingRig {
    pub fn draw(number: u64) -> anyhow::Result<Self> {
        let mut random = ChaCha8Rng::seed_from_u64(number);
        let mut truth = Truth::demo(&Truth::demo_rig(Shape::Cylinder), number);
        truth.friction = 0.13 + 0.17 * random.random::<f64>();
        truth.restitution = 0.35 + 0.3 * random.random::<f64>();
        truth.scatter.speed = 0.003 + 0.004 * random.random::<f64>();
        truth.scatter.angle = 0.002 + 0.004 * random.random::<f64>();
        truth.hidden = Hidden::parse(HIDDEN[random.random_range(0..HIDDEN.len())])?;
        let signs = [(); 2].map(|()| if random.random::<bool>() { 1.0 } else { -1.0 });
        Ok(Self {
            number,
            truth,
            signs,
        })
    }

    pub fn before(&self, case: Case) -> anyhow::Result<Truth> {
        let mut truth = self.truth.clone();
        if case == Case::Wander {
            truth.noise = wander()?;
        }
        Ok(truth)
    }

    pub fn after(&self, case: Case) -> anyhow::Result<Truth> {
        let mut truth = self.before(case)?;
        if matches!(case, Case::Noon | Case::NoonBad) {
            truth.friction *= 1.0 + 0.12 * self.signs[0];
            truth.restitution = 0.95 * (1.0 + truth.restitution) - 1.0;
            let heading = 1.5f64.to_radians() * self.signs[1];
            let turned = Hidden::parse(&[format!("striker_angle_bias={heading}")])?;
            truth.hidden.0.extend(turned.0);
        }
        Ok(truth)
    }

    /// The truth without wander: what repeats scatter by.
    pub fn repeating(&self, case: Case) -> anyhow::Result<Truth> {
        match case {
            Case::Wander => Ok(self.truth.clone()),
            _ => self.after(case),
        }
    }

    pub fn bad(&self, case: Case) -> anyhow::Result<Truth> {
        let mut truth = self.after(case)?;
        truth.friction *= 2.0;
        Ok(truth)
    }
}

fn wander() -> anyhow::Result<Noise> {
    Ok(Hide::parse(&[format!("friction_wander={STEP}")])?.noise)
}
