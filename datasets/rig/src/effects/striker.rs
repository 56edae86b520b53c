//! Effects of the arm and of the impact.

use values::{Command, Point};

use super::acts::Acts;
use crate::StrikeIndex;
use crate::declare::declare;

declare! {
    /// The arm's speed is not the commanded one: a straight line that bends softly into a cap.
    StrikerSpeedError = "striker_speed_error" {
        /// Speed added, in m/s.
        a: 0.05, "m/s", Some(0.0);
        b: 0.88, "1", Some(1.0);
        /// Speed that is not exceeded, in m/s.
        cap: 0.86, "m/s", Some(1.2);
        /// Width of the bend, in m/s; at 0 a sharp `min(a + b·commanded, cap)`.
        softness: 0.01, "m/s", None;
    }

    fn deliver(&self, command: Command, _from: Point, _when: StrikeIndex) -> Command {
        let line = self.a + self.b * command.speed;
        let speed = soft_min(line, self.cap, self.softness);
        Command::new(speed.max(0.0), command.angle)
    }
}

/// `−s·ln(e^(−a/s) + e^(−b/s))`, without overflow: below both, and their minimum as s → 0.
fn soft_min(a: f64, b: f64, softness: f64) -> f64 {
    let (low, high) = (a.min(b), a.max(b));
    if softness <= 0.0 {
        return low;
    }
    low - softness * (-(high - low) / softness).exp().ln_1p()
}

declare! {
    /// The arm moves at an angle to the commanded one.
    StrikerAngleBias = "striker_angle_bias" {
        /// Delivered less commanded angle, in rad.
        delta: 0.03, "rad", Some(0.0);
    }

    fn deliver(&self, command: Command, _from: Point, _when: StrikeIndex) -> Command {
        command.turned(self.delta)
    }
}

declare! {
    /// Restitution falls with the speed of impact, by the power law of a contact that yields a little.
    SpeedDependentRestitution = "speed_dependent_restitution" {
        /// e ∝ v^(−exponent); Johnson's plastic limit is 1/4.
        exponent: 0.18, "1", Some(0.0);
        /// Speed at which restitution is the rig's own, in m/s.
        reference: 0.7, "m/s", None;
    }

    fn restitution(&self, speed: f64, _when: StrikeIndex) -> f64 {
        (speed / self.reference).powf(-self.exponent)
    }
}

declare! {
    /// The tip's line passes beside the centre.
    OffCentreContact = "off_centre_contact" {
        /// To the left of the line of motion, in m.
        offset: 0.002, "m", Some(0.0);
    }

    fn tip_offset(&self) -> f64 {
        self.offset
    }
}

/// Speed of impact at which restitution is the rig's own, in m/s.
const REFERENCE: f64 = 0.7;

declare! {
    /// Restitution falls as that of viscoelastic bodies, with the fifth root of speed: a factor
    /// 1 − loss·((v/0.7)^(1/5) − 1).
    ViscoelasticRestitution = "viscoelastic_restitution" {
        /// Fall for each doubling of the fifth root.
        loss: 1.2, "1", Some(0.0);
    }

    fn restitution(&self, speed: f64, _when: StrikeIndex) -> f64 {
        (1.0 - self.loss * ((speed / REFERENCE).powf(0.2) - 1.0)).max(0.0)
    }
}

declare! {
    /// Restitution of a tip that yields: it falls with the energy of impact, (1 + loss·0.7²)/(1 + loss·v²).
    YieldingRestitution = "yielding_restitution" {
        /// In s²/m².
        loss: 0.5, "s2/m2", Some(0.0);
    }

    fn restitution(&self, speed: f64, _when: StrikeIndex) -> f64 {
        let at = |v: f64| (1.0 + self.loss * v * v).max(0.05);
        at(REFERENCE) / at(speed)
    }
}

declare! {
    /// The tip or the object was changed for another during the strikes: from one strike on, restitution is another.
    RestitutionStep = "restitution_step" {
        change: 0.2, "1", Some(0.0);
        /// Number of the first strike with it.
        from: 50.0, "1", None;
    }

    fn restitution(&self, _speed: f64, index: StrikeIndex) -> f64 {
        if (index.order as f64) < self.from {
            1.0
        } else {
            (1.0 + self.change).max(0.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delivered_speed_follows_the_line_and_bends_below_the_cap() {
        let error = StrikerSpeedError::default();
        let at = |speed| {
            let command = Command { speed, angle: 0.2 };
            error
                .deliver(command, Point::default(), StrikeIndex::default())
                .speed
        };
        assert!((at(0.5) - (0.05 + 0.88 * 0.5)).abs() < 1e-6);
        assert!(at(1.0) < 0.86 && at(1.0) > 0.84);
        assert_eq!(soft_min(0.4, 0.9, 0.0), 0.4);
    }

    #[test]
    fn restitution_is_the_rigs_at_the_reference_and_falls() {
        let effect = SpeedDependentRestitution::default();
        assert_eq!(effect.restitution(0.7, StrikeIndex::default()), 1.0);
        assert!((effect.restitution(1.4, StrikeIndex::default()) - 2f64.powf(-0.18)).abs() < 1e-12);
    }

    #[test]
    fn restitution_is_the_rigs_at_the_reference_and_falls_beyond() {
        let laws: [&dyn Acts; 2] = [
            &ViscoelasticRestitution::default(),
            &YieldingRestitution::default(),
        ];
        for law in laws {
            assert!((law.restitution(0.7, StrikeIndex::default()) - 1.0).abs() < 1e-12);
            assert!(law.restitution(1.0, StrikeIndex::default()) < 0.95);
            assert!(law.restitution(0.4, StrikeIndex::default()) > 1.05);
        }
        let step = RestitutionStep::default();
        let at = |order| step.restitution(0.7, StrikeIndex { session: 0, order });
        assert_eq!((at(49), at(50)), (1.0, 1.2));
    }
}
