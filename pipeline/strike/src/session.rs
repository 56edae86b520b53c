//! Uncertainty of a session: by how much plans miss in one that was not measured.

use values::{Command, Conditions, Point, Rig};
use world::{SessionValue, Simulator, World, WorldError};

/// Mean of the size of a normal variable over its standard deviation, √(2/π).
const MEAN_SIZE: f64 = 0.797_884_560_802_865_4;
/// Standard errors within which 95 % lie.
const NINETY_FIVE: f64 = 1.96;

/// Worlds one standard deviation of the session's uncertainty beside the one that plans; none for a session that is known.
#[derive(Default)]
pub(crate) struct OpenSession {
    here: Option<Simulator>,
    beside: Vec<Simulator>,
}

impl OpenSession {
    /// Of a session that is not known: by the scatter between the world's sessions.
    pub(crate) fn unknown(rig: &Rig, world: &World) -> Result<Self, WorldError> {
        let moved = world
            .sessions
            .iter()
            .map(|(effect, p)| (effect.as_str(), p.mean + p.next()));
        Self::beside(rig, world, moved)
    }

    /// Of a session that was estimated from a few strikes: the uncertainty that these leave.
    pub(crate) fn estimated(
        rig: &Rig,
        world: &World,
        values: &[SessionValue],
    ) -> Result<Self, WorldError> {
        let moved = values.iter().map(|value| {
            let to_high =
                value.estimate.high.unwrap_or(value.estimate.value) - value.estimate.value;
            let beside = value.estimate.value + to_high / NINETY_FIVE;
            (value.effect.as_str(), beside)
        });
        Self::beside(rig, world, moved)
    }

    fn beside<'v>(
        rig: &Rig,
        world: &World,
        moved: impl Iterator<Item = (&'v str, f64)>,
    ) -> Result<Self, WorldError> {
        let beside = moved
            .map(|(effect, value)| {
                let world = world.clone().with_unknown_sessions(effect, value);
                Simulator::new(rig, &world)
            })
            .collect::<Result<Vec<_>, _>>()?;
        let here = match beside[..] {
            [] => None,
            _ => Some(Simulator::new(rig, world)?),
        };
        Ok(Self { here, beside })
    }

    /// A mean miss (m) on strikes of known sessions, combined with the miss that the session's uncertainty adds to this strike: they
    /// are independent, so their squares add.
    pub(crate) fn expected_miss(
        &self,
        known: f64,
        from: Point,
        command: Command,
        conditions: &Conditions,
    ) -> f64 {
        let stop = |simulator: &Simulator| {
            let simulated = simulator.worker().strike(from, command, conditions);
            simulated.ok().map(|simulated| simulated.stop)
        };
        let Some(here) = self.here.as_ref().and_then(stop) else {
            return known;
        };
        let squares = self.beside.iter().filter_map(|beside| {
            let shift = MEAN_SIZE * stop(beside)?.distance(here);
            Some(shift * shift)
        });
        (known * known + squares.sum::<f64>()).sqrt()
    }
}
