//! Restitution by other laws of the speed of impact.

use super::acts::Acts;
use crate::StrikeIndex;
use crate::declare::declare;

/// Speed of impact at which restitution is the rig's own, in m/s.
const REFERENCE: f64 = 0.7;

declare! {
    /// Restitution falls as that of viscoelastic bodies, with the fifth root of speed: a factor
    /// 1 − loss·((v/0.7)^(1/5) − 1).
    ViscoelasticRestitution = "viscoelastic_restitution" {
        /// Fall for each doubling of the fifth root.
        loss: 1.2, "1", Some(0.0);
    }
}

impl Acts for ViscoelasticRestitution {
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
}

impl Acts for YieldingRestitution {
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
}

impl Acts for RestitutionStep {
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
