//! What dry friction does to a flat base that slides and turns at once.
//!
//! Under an even pressure every element of the base rubs against its own velocity, v + ω×r, with the same force (Goyal, Ruina and
//! Papadopoulos 1991). MuJoCo's ellipsoid (Howe and Cutkosky 1996) comes near, but off by per cents where it does both. So
//! force and torque are integrated over the base, once for a disc and once for a square, of the latter as a mean over the
//! directions in which it may slide while it turns.

use std::{f64::consts::TAU, sync::LazyLock};

use values::{Object, Point, Rig, Solid};

use crate::{World, WorldError};

/// The base of an object.
#[derive(Clone, Copy, Debug)]
pub struct Base {
    /// Mean distance of its elements from the centre in m, times the world's torsional friction: a base that turns on the
    /// spot feels a torque of μ·weight·arm.
    pub(crate) arm: f64,
    unit: Option<&'static UnitForces>,
}

impl Base {
    /// The base of the rig's object in a world.
    pub fn new(rig: &Rig, world: &World) -> Result<Self, WorldError> {
        let torsional = world.value("torsional_friction")?;
        let Self { arm, unit } = Self::of(&rig.object);
        Ok(Self {
            arm: arm * torsional,
            unit,
        })
    }

    /// The base of an object that presses evenly.
    pub fn of(object: &Object) -> Self {
        match object.solid {
            Solid::Cylinder { radius, .. } => Self {
                arm: DISC.arm * radius,
                unit: Some(&DISC),
            },
            // An oblong is taken as the square of the same diagonal.
            Solid::Box {
                half_size: [x, y, _],
            } => Self {
                arm: SQUARE.arm * x.hypot(y) / std::f64::consts::SQRT_2,
                unit: Some(&SQUARE),
            },
            // A ball touches the table at a point; a small patch keeps it from spinning for ever.
            Solid::Sphere { radius } => Self {
                arm: 0.05 * radius,
                unit: None,
            },
        }
    }

    /// Mean distance of its elements from the centre in m, times the world's torsional friction.
    pub fn arm(&self) -> f64 {
        self.arm
    }

    /// Friction's pull in units of μ times the weight: force over the speed v, and torque over w and the arm, both in s/m; w is the spin times the
    /// arm. Both speeds are given as their squares, in m²/s².
    #[inline]
    pub(crate) fn pull(&self, v_square: f64, w_square: f64) -> [f64; 2] {
        let sum = (v_square + w_square).max(1e-18);
        let of_ellipsoid = 1.0 / sum.sqrt();
        match self.unit {
            None => [of_ellipsoid; 2],
            Some(unit) => unit.at(w_square / sum).map(|share| share * of_ellipsoid),
        }
    }
}

/// Entries of a table, less one.
const ENTRIES: usize = 128;

/// Force and torque of a base whose half size is 1, relative to the ellipsoid's, by the share of turning in the slip's square.
#[derive(Debug)]
struct UnitForces {
    /// Mean distance of the elements from the centre.
    arm: f64,
    shares: [[f64; 2]; ENTRIES + 1],
}

static DISC: LazyLock<UnitForces> = LazyLock::new(|| {
    // Rings of equal area; on a disc all directions are alike.
    let (rings, spokes) = (16, 32);
    let elements = (0..rings * spokes).map(|i| {
        let (ring, spoke) = (f64::from(i / spokes), f64::from(i % spokes));
        let turn = (spoke + 0.5) / f64::from(spokes);
        Point::polar(((ring + 0.5) / f64::from(rings)).sqrt(), TAU * turn)
    });
    UnitForces::of(&elements.collect::<Vec<_>>(), &[0.0])
});

static SQUARE: LazyLock<UnitForces> = LazyLock::new(|| {
    let cells = 16;
    let at = |i: i32| f64::from(2 * i + 1) / f64::from(cells) - 1.0;
    let elements = (0..cells * cells).map(|i| Point::new(at(i % cells), at(i / cells)));
    // By symmetry an eighth of the circle holds all.
    let directions = [0.5, 1.5, 2.5, 3.5].map(|i| i * TAU / 32.0);
    UnitForces::of(&elements.collect::<Vec<_>>(), &directions)
});

impl UnitForces {
    fn of(elements: &[Point], directions: &[f64]) -> Self {
        let count = elements.len() as f64;
        let arm = elements.iter().map(|r| r.norm()).sum::<f64>() / count;
        let mut shares = [[0.0; 2]; ENTRIES + 1];
        for (i, shares) in shares.iter_mut().enumerate() {
            // At the very ends one of both is zero over zero.
            let turning = (i as f64 / ENTRIES as f64).clamp(1e-6, 1.0 - 1e-6);
            let (v, w) = ((1.0 - turning).sqrt(), turning.sqrt());
            let [mut force, mut torque] = [0.0; 2];
            for direction in directions {
                let along = Point::polar(1.0, *direction);
                for r in elements {
                    let slip = along * v + Point::new(-r.y, r.x) * (w / arm);
                    let size = slip.norm().max(1e-12);
                    force += slip.dot(along) / size;
                    torque += (r.x * slip.y - r.y * slip.x) / size;
                }
            }
            let all = count * directions.len() as f64;
            *shares = [force / (all * v), torque / (all * arm * w)];
        }
        Self { arm, shares }
    }

    /// Force and torque, linear between entries.
    fn at(&self, turning: f64) -> [f64; 2] {
        let place = turning.clamp(0.0, 1.0) * ENTRIES as f64;
        let entry = (place as usize).min(ENTRIES - 1);
        let share = place - entry as f64;
        let (a, b) = (self.shares[entry], self.shares[entry + 1]);
        [0, 1].map(|i| a[i] + (b[i] - a[i]) * share)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use values::Shape;

    use super::*;

    #[test]
    fn it_rubs_as_theory_has_it_where_sliding_or_turning_prevails() {
        for (shape, arm, square, inverse) in [
            (Shape::Cylinder, 2.0 / 3.0, 0.5, 2.0),
            // Means of r, r² and 1/r over a square of half size 1.
            (Shape::Box, 0.765_196, 2.0 / 3.0, 1.762_747),
        ] {
            let rig = Rig::demo(shape);
            let half = rig.object.solid.narrowest();
            let base = Base::of(&rig.object);
            assert!((base.arm / (half * arm) - 1.0).abs() < 2e-3, "{}", base.arm);
            // H = v + ω²⟨r²⟩/4v, and H = ω⟨r⟩ + v²⟨1/r⟩/4ω; force and torque are its slopes.
            let w = 0.1;
            let [pull, turning] = base.pull(1.0, w * w);
            let share = w * w * square / (4.0 * arm * arm);
            assert!((1.0 - pull - share).abs() < 3e-4, "{shape:?}: {pull}");
            assert!(
                (turning * w / (2.0 * share / w) - 1.0).abs() < 0.02,
                "{shape:?}: {turning}"
            );
            let [pull, turning] = base.pull(w * w, 1.0);
            let share = w * w * inverse * arm / 4.0;
            assert!((1.0 - turning - share).abs() < 2e-3, "{shape:?}: {turning}");
            assert!(
                (pull * w / (2.0 * share / w) - 1.0).abs() < 0.1,
                "{shape:?}: {pull}"
            );
        }
    }

    #[test]
    fn it_takes_no_more_than_sliding_and_turning_apart() {
        let base = Base::of(&Rig::demo(Shape::Box).object);
        for i in 0..=40 {
            let (w, v) = (FRAC_PI_2 * f64::from(i) / 40.0).sin_cos();
            let [pull, turning] = base.pull(v * v, w * w);
            let taken = pull * v * v + turning * w * w;
            assert!(taken <= v + w + 1e-6 && taken >= v.max(w) - 2e-3, "{taken}");
            assert!(pull * v <= 1.0 + 1e-6 && turning * w <= 1.0 + 2e-3);
        }
        let [pull, turning] = base.pull(0.0, 0.0);
        assert!(pull.is_finite() && turning.is_finite());
    }
}
