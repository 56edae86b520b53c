//! What a contact of finite duration does to the launch, to be taken back.
//!
//! Restitution is that of an impact without duration: it launches at (1 + e) times the tip's speed, at once and from where the object
//! rested. MuJoCo's contact lasts half a millisecond: the object leaves as much later and farther on, friction brakes it less along
//! that way than it would have, and MuJoCo's impedance is not quite one. Together up to 0.1 % of the launch speed, most for a slow tip
//! on a rough table: as much as the standard error from a hundred strikes.

/// Tip speeds in m/s and restitutions at which it is measured.
pub(crate) const SPEEDS: [f64; 2] = [0.4, 1.0];
pub(crate) const RESTITUTIONS: [f64; 2] = [0.35, 0.65];

/// By how much MuJoCo's contact launches faster than an impact without duration: `constant + by_inverse_speed / speed` of the launch
/// speed, at each restitution, and linear between.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ContactDuration([Excess; 2]);

#[derive(Clone, Copy, Debug, Default)]
struct Excess {
    constant: f64,
    /// In m/s.
    by_inverse_speed: f64,
}

impl Excess {
    fn at(self, speed: f64) -> f64 {
        self.constant + self.by_inverse_speed / speed.max(SPEEDS[0] / 2.0)
    }
}

impl ContactDuration {
    /// Of launch speeds over those of an impact without duration, less one: at each restitution, at each speed.
    pub(crate) fn of(measured: [[f64; 2]; 2]) -> Self {
        Self(measured.map(|[slow, fast]| {
            let by_inverse_speed = (slow - fast) / (1.0 / SPEEDS[0] - 1.0 / SPEEDS[1]);
            Excess {
                constant: fast - by_inverse_speed / SPEEDS[1],
                by_inverse_speed,
            }
        }))
    }

    /// What a tip speed (m/s) is multiplied by for the launch of an impact without duration.
    pub(crate) fn factor(self, speed: f64, restitution: f64) -> f64 {
        let [low, high] = RESTITUTIONS;
        let share = (restitution - low) / (high - low);
        let [at_low, at_high] = self.0.map(|excess| excess.at(speed));
        1.0 / (1.0 + at_low + share * (at_high - at_low))
    }
}
