//! Where to start, with no simulation: under constant deceleration √(D − d(t)) is a straight line.

use std::f64::consts::FRAC_PI_2;

use values::{Rig, Strike};
use world::{World, parameter};

const GRAVITY: f64 = 9.81;
/// Share of the whole distance within which frames are used: noise rules the ends.
const USED: std::ops::Range<f64> = 0.05..0.90;

/// Deceleration (m/s²) and speed of release (m/s) of one strike.
fn line(strike: &Strike) -> Option<(f64, f64)> {
    let path = strike.path();
    let whole = path.norm();
    let points: Vec<(f64, f64)> = (0..strike.track.len())
        .map(|i| {
            (
                strike.track.t[i],
                (strike.track.point(i) - strike.initial).dot(path) / whole,
            )
        })
        .filter(|(_, d)| USED.contains(&(d / whole)))
        .map(|(t, d)| (t, (whole - d).sqrt()))
        .collect();
    let n = points.len() as f64;
    if n < 3.0 {
        return None;
    }
    let (mean_t, mean_s) = (
        points.iter().map(|p| p.0).sum::<f64>() / n,
        points.iter().map(|p| p.1).sum::<f64>() / n,
    );
    let covariance: f64 = points.iter().map(|p| (p.0 - mean_t) * (p.1 - mean_s)).sum();
    let variance: f64 = points.iter().map(|p| (p.0 - mean_t).powi(2)).sum();
    let slope = covariance / variance;
    let deceleration = 2.0 * slope * slope;
    (slope < 0.0).then(|| (deceleration, (2.0 * deceleration * whole).sqrt()))
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Share of the strikes whose bearings must lie within the tip's friction cone, and by how much the cone is wider yet.
const HELD: (f64, f64) = (0.98, 1.1);
/// Shorter paths, in m, have no bearing to speak of.
const SHORT: f64 = 0.05;

/// The world with a tip that holds a box as the strikes show: a tip that slips along a face cannot send it further aside
/// than the arc tangent of its friction, so bearings are a lower bound of that. Only where it was neither freed nor set.
pub(crate) fn hold(rig: &Rig, world: World, strikes: &[&Strike], free: &[String]) -> World {
    const NAME: &str = "tip_friction";
    let is_given = world.parameters.contains_key(NAME) || free.iter().any(|name| name == NAME);
    if rig.object.shape != values::Shape::Box || is_given {
        return world;
    }
    let mut aside: Vec<f64> = strikes
        .iter()
        .map(|strike| strike.path())
        .filter(|path| path.norm() > SHORT)
        .map(|path| {
            // Beside the normal of the face that it leaves behind.
            let quarter = FRAC_PI_2;
            let bearing = path.bearing().rem_euclid(quarter);
            bearing.min(quarter - bearing)
        })
        .collect();
    aside.sort_by(f64::total_cmp);
    let (share, wider) = HELD;
    let last = aside.len().saturating_sub(1) as f64;
    match (aside.get((share * last) as usize), parameter(NAME)) {
        (Some(aside), Ok(spec)) if wider * aside.tan() > spec.nominal => {
            world.with(NAME, (wider * aside.tan()).min(spec.high))
        }
        _ => world,
    }
}

/// The world with friction and restitution from the lines, where they are free and a line can be drawn.
pub(crate) fn start(rig: &Rig, world: &World, strikes: &[&Strike], free: &[String]) -> World {
    let lines: Vec<_> = strikes
        .iter()
        .filter_map(|strike| Some((strike, line(strike)?)))
        .collect();
    let friction = median(
        lines
            .iter()
            .map(|(_, (deceleration, _))| deceleration / GRAVITY)
            .collect(),
    );
    let launch = median(
        lines
            .iter()
            .map(|(strike, (_, release))| release / strike.command.speed - 1.0)
            .collect(),
    );
    let mut world = world.clone();
    for (name, value) in [("friction", friction), ("restitution", launch)] {
        // A ball rolls: its deceleration says nothing of sliding friction.
        let usable = !(name == "friction" && rig.object.shape == values::Shape::Sphere);
        if let (true, Some(value), Ok(spec)) = (
            usable && free.iter().any(|n| n == name),
            value,
            parameter(name),
        ) {
            let margin = 0.02 * (spec.high - spec.low);
            world = world.with(name, value.clamp(spec.low + margin, spec.high - margin));
        }
    }
    world
}
