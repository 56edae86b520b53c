//! The gap: stop errors in MuJoCo's world before and after, on strikes that took no part.

use values::{Point, Rig, Split, Strike};
use world::{Simulator, World, WorldError};

use crate::{
    diagnosis::{Gap, StopResidual},
    heldout,
    question::Variation,
};

/// Greatest stop error that a single strike counts with, in units of the strikes' scatter: one normal error in eight thousand is longer, and a strike
/// that went astray does not speak for the others.
pub(crate) const LONGEST: f64 = 3.0;

/// Measured less simulated stops, in m; `None` where a strike does not rest, or not in that world. Where most do not rest, the ends of tracks.
pub(crate) fn stop_residuals(
    rig: &Rig,
    world: &World,
    strikes: &[&Strike],
) -> Result<Vec<Option<Point>>, WorldError> {
    let by_stops = Strike::most_rest(strikes.iter().copied());
    Ok(Simulator::new(rig, world)?.map(strikes, |worker, strike| {
        let (initial, command, conditions) = (strike.initial, strike.command, &strike.conditions);
        let last = match strike.ends() {
            None => worker.strike(initial, command, conditions).ok()?.stop,
            Some(ends) if !by_stops => {
                let simulated = worker.strike_until(initial, command, conditions, ends);
                simulated.ok()?.at(ends)
            }
            Some(_) => return None,
        };
        Some(strike.stop - last)
    }))
}

/// Root mean square, in m.
pub(crate) fn rms(residuals: impl Iterator<Item = Point>) -> f64 {
    let (mut sum, mut count) = (0.0, 0usize);
    for r in residuals {
        sum += r.dot(r);
        count += 1;
    }
    (sum / count.max(1) as f64).sqrt()
}

/// Root mean square distance between two models' ends of the same strikes, in m, over those of which both have one.
pub(crate) fn rms_between(ends: &[Option<Point>], others: &[Option<Point>]) -> f64 {
    let apart = ends.iter().zip(others).map(|(a, b)| Some((*a)? - (*b)?));
    rms(apart.flatten())
}

/// Root mean square, in m, with each error shortened to `longest` (m), so that a few strikes that went astray hardly move it.
pub(crate) fn clipped_rms(residuals: impl Iterator<Item = Point>, longest: f64) -> f64 {
    rms(residuals.map(|r| r * (longest / r.norm().max(longest))))
}

/// The strikes that rest in both worlds.
fn paired<'r>(
    before: &'r [Option<Point>],
    after: &'r [Option<Point>],
) -> impl Iterator<Item = (Point, Point)> + 'r {
    let both = before.iter().zip(after);
    both.filter_map(|(before, after)| Some(((*before)?, (*after)?)))
}

/// The gap over the held-out strikes.
pub(crate) fn gap(before: &[Option<Point>], after: &[Option<Point>], variation: Variation) -> Gap {
    let both: Vec<(Point, Point)> = paired(before, after).collect();
    let (before, after) = (
        rms(both.iter().map(|(b, _)| *b)),
        rms(both.iter().map(|(_, a)| *a)),
    );
    Gap {
        heldout_strikes: both.len(),
        before,
        after,
        change: if before > 0.0 {
            after / before - 1.0
        } else {
            0.0
        },
        change_half_95: change_half_95(&both),
        noise_floor: variation.repeats.value,
        noise_floor_95: variation.repeats.ninety_five(),
        wander: variation.wander.value,
        wander_95: variation.wander.ninety_five(),
        sessions: variation.sessions.value,
        sessions_95: variation.sessions.ninety_five(),
        unit: "m".into(),
        measure: "rms stop error".into(),
    }
}

/// Half of the 95 % interval of after/before, where both are root mean squares over the same strikes: the ratio of the mean squares,
/// linearised (Cochran 1977, section 2.11). None of fewer than two strikes.
fn change_half_95(both: &[(Point, Point)]) -> Option<f64> {
    let squares = both.iter().map(|(b, a)| (b.dot(*b), a.dot(*a)));
    let (before, after): (f64, f64) =
        squares.clone().fold((0.0, 0.0), |(b, a), (before, after)| {
            (b + before, a + after)
        });
    if before == 0.0 || after == 0.0 {
        return None;
    }
    let ratio = after / before;
    let away: Vec<f64> = squares
        .map(|(before, after)| after - ratio * before)
        .collect();
    let (_, error) = heldout::total(&away);
    let t = heldout::quantile(both.len(), 0.975)?;
    Some(t * error / before / (2.0 * ratio.sqrt()))
}

/// The residuals of the strikes that judge, or of the others.
pub(crate) fn of_part(
    strikes: &[&Strike],
    residuals: &[Option<Point>],
    judges: bool,
) -> Vec<Option<Point>> {
    let each = strikes.iter().zip(residuals);
    each.filter(|(strike, _)| (strike.split == Split::Test) == judges)
        .map(|(_, residual)| *residual)
        .collect()
}

/// Each strike's residual along and across its path.
pub(crate) fn residuals(
    strikes: &[&Strike],
    before: &[Option<Point>],
    after: &[Option<Point>],
) -> Vec<StopResidual> {
    strikes
        .iter()
        .zip(before.iter().zip(after))
        .filter_map(|(strike, (before, after))| {
            let path = strike.path();
            let ahead = path * (1.0 / path.norm().max(1e-9));
            let split = |r: Point| [r.dot(ahead), r.y * ahead.x - r.x * ahead.y];
            Some(StopResidual {
                strike_id: strike.id.clone(),
                is_heldout: strike.split == Split::Test,
                before: split((*before)?),
                after: split((*after)?),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    #[test]
    fn the_interval_of_a_change_holds_the_true_change() {
        // Scatter of 1 mm and an error of 1 mm that is taken away: √2 before, 1 after.
        let truth = 0.5f64.sqrt() - 1.0;
        let cases = 500;
        let held = (0..cases).filter(|seed| {
            let mut random = ChaCha8Rng::seed_from_u64(*seed);
            let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
            let after: Vec<Option<Point>> = (0..40)
                .map(|_| Some(Point::new(1e-3 * normal(), 0.0)))
                .collect();
            let off = |after: &Option<Point>| Some((*after)? + Point::new(0.0, 1e-3 * normal()));
            let before: Vec<Option<Point>> = after.iter().map(off).collect();
            let gap = gap(&before, &after, Variation::default());
            let half = gap.change_half_95.expect("40 strikes");
            (gap.change - truth).abs() < half
        });
        let share = held.count() as f64 / cases as f64;
        assert!((0.90..0.99).contains(&share), "{share}");
    }

    #[test]
    fn one_strike_shows_no_change_and_the_same_world_none() {
        let one = [Some(Point::new(1e-3, 0.0))];
        assert_eq!(
            gap(&one, &[Some(Point::default())], Variation::default()).change_half_95,
            None
        );
        let two = [one[0], Some(Point::new(0.0, 2e-3))];
        let same = gap(&two, &two, Variation::default());
        assert_eq!((same.change, same.change_half_95), (0.0, Some(0.0)));
        assert_eq!(gap(&[], &[], Variation::default()).change, 0.0);
    }

    #[test]
    fn an_error_that_went_astray_counts_as_the_longest() {
        let errors = || [Point::new(3e-3, 4e-3), Point::new(-0.3, 0.4)].into_iter();
        assert!((clipped_rms(errors(), 0.010) - 62.5e-6f64.sqrt()).abs() < 1e-9);
        assert_eq!(clipped_rms(errors(), 1.0), rms(errors()));
    }
}
