//! Where to start, with no simulation: under constant deceleration √(D − d(t)) is a straight line.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{DMatrix, DVector, Vector4};
use values::{Point, Rig, Strike, median};
use world::{GRAVITY, World, parameter};

use crate::fit::{Fitted, IN_SLIP, ROLLS};
use crate::notes::Note;

/// Name of the parameter that decides how far aside a box can be sent.
pub(crate) const HOLDS: &str = "tip_friction";
/// Share of the strikes whose bearings must lie within the tip's friction cone, and by how much the cone is wider yet.
const HELD: (f64, f64) = (0.98, 1.1);
/// Least share of the strikes that a tip which slips holds: its strikes gather at the cone's edge, and noise takes some beyond it.
const HELD_BY_ONE_THAT_SLIPS: f64 = 0.9;
/// Length, in m, below which a path has no bearing to speak of.
const SHORT: f64 = 0.05;
/// Part of the way from which an object's launch direction is read: what bends the way later is not of the impact.
const EARLY: f64 = 0.4;

/// The direction in rad in which an object leaves the tip, from the first part of its way; none where the way is too short.
pub(crate) fn heading(strike: &Strike) -> Option<f64> {
    let early = (EARLY * strike.path().norm()).max(SHORT);
    let mut frames = (0..strike.track.len()).map(|frame| strike.track.point(frame));
    let away = frames.find(|at| at.distance(strike.initial) >= early)?;
    Some((away - strike.initial).bearing())
}

/// The tip's friction that this share of the strikes' bearings needs at least: a tip that slips along a face cannot send a box further aside than the
/// arc tangent of its friction. None for a round object, and where no strike shows it.
fn needed_grip(rig: &Rig, strikes: &[&Strike], share: f64) -> Option<f64> {
    if rig.object.shape() != values::Shape::Box {
        return None;
    }
    let mut aside: Vec<f64> = strikes
        .iter()
        .filter_map(|strike| {
            // Beside the normal of the face that it leaves behind.
            let quarter = FRAC_PI_2;
            let bearing = heading(strike)? - strike.conditions.yaw.unwrap_or(0.0);
            let bearing = bearing.rem_euclid(quarter);
            Some(bearing.min(quarter - bearing))
        })
        .collect();
    aside.sort_by(f64::total_cmp);
    let last = aside.len().saturating_sub(1) as f64;
    aside.get((share * last) as usize).map(|aside| aside.tan())
}

/// The world with a tip that holds a box as the strikes show. Only where its friction was neither freed nor set.
pub(crate) fn hold(rig: &Rig, world: World, strikes: &[&Strike], free: &[String]) -> World {
    let is_given = world.parameters.contains_key(HOLDS) || free.iter().any(|name| name == HOLDS);
    let needed = needed_grip(rig, strikes, HELD.0).map(|needed| HELD.1 * needed);
    match (needed, parameter(HOLDS)) {
        (Some(needed), Ok(spec)) if !is_given && needed > spec.nominal => {
            world.with(HOLDS, needed.min(spec.high))
        }
        _ => world,
    }
}

/// Whether a tip of this friction can send a box as far aside as the strikes show, but for the margin that [`hold`] leaves: bearings are measured,
/// and may all be turned a little. Where strikes went too far aside for it, tracks do not count as evidence that the tip slips.
pub(crate) fn holds(rig: &Rig, strikes: &[&Strike], tip_friction: f64) -> bool {
    needed_grip(rig, strikes, HELD_BY_ONE_THAT_SLIPS)
        .is_none_or(|needed| HELD.1 * tip_friction >= needed)
}

/// That the tip was given more friction; none where it was not.
pub(crate) fn held(before: &World, fitted: &Fitted) -> Option<Note> {
    let (before, after) = (before.value(HOLDS).ok()?, fitted.world.value(HOLDS).ok()?);
    let is_freed = fitted.free.iter().any(|name| name == HOLDS);
    (!is_freed && after > before).then(|| Note::TipHolds {
        name: HOLDS.into(),
        value: after,
    })
}

/// Distance, in m, that a ball has gone `time` s after a launch at this speed (m/s): it slides, turning ever faster, then rolls. Decelerations of
/// both in m/s²; `in_slip`: share of rolling friction that acts while it slides.
fn rolled(time: f64, launch: f64, sliding: f64, rolling: f64, in_slip: f64) -> f64 {
    let slides = launch / (3.5 * (sliding - in_slip * rolling));
    let rolls = launch - sliding * slides;
    let (first, last) = (
        time.min(slides),
        (time - slides).clamp(0.0, rolls / rolling),
    );
    let slid = launch * first - 0.5 * sliding * first * first;
    slid + rolls * last - 0.5 * rolling * last * last
}

/// A ball's world by the tracks of a part of the strikes, each relative to its length, where none or all of rolling friction acts while it
/// slips: the valley between the two is long, and a fit that begins at the one may end there.
pub(crate) fn ball(radius: f64, world: &World, strikes: &[&Strike], in_slip: f64) -> World {
    let some = strikes.iter().step_by(strikes.len().div_ceil(24).max(1));
    let frames: Vec<[f64; 4]> = some
        .flat_map(|strike| {
            let gone = |i| strike.track.point(i).distance(strike.initial);
            let count = strike.track.len();
            let weight = 1.0 / (gone(count - 1).max(SHORT) * (count as f64).sqrt());
            let all = 0..count;
            all.map(move |i| [strike.command.speed, strike.track.t[i], gone(i), weight])
        })
        .collect();
    // Logarithms of friction and of what rolling takes of it, restitution, and by how much clocks are late.
    let off = |at: &Vector4<f64>| -> DVector<f64> {
        let sliding = GRAVITY * at[0].exp();
        let rolling = sliding * at[1].exp();
        let each = frames.iter().map(|[speed, time, gone, weight]| {
            let time = (time + at[3]).max(0.0);
            weight * (gone - rolled(time, speed * (1.0 + at[2]), sliding, rolling, in_slip))
        });
        DVector::from_iterator(frames.len(), each)
    };
    let low = Vector4::new(0.01_f64.ln(), 0.005_f64.ln(), -0.5, -0.02);
    let high = Vector4::new(1.4_f64.ln(), 0.7_f64.ln(), 0.95, 0.03);
    let mut at = Vector4::new(0.2_f64.ln(), 0.3_f64.ln(), 0.5, 0.0);
    let (mut here, mut damping) = (off(&at), 1e-2);
    for _ in 0..40 {
        let slopes = DMatrix::from_columns(&[0, 1, 2, 3].map(|i| {
            let beside = at + Vector4::ith(i, 1e-4);
            (off(&beside) - &here) / 1e-4
        }));
        let mut damped = slopes.tr_mul(&slopes);
        for i in 0..4 {
            damped[(i, i)] = damped[(i, i)] * (1.0 + damping) + 1e-12;
        }
        let Some(step) = damped
            .cholesky()
            .map(|all| all.solve(&slopes.tr_mul(&here)))
        else {
            break;
        };
        let next = (at - Vector4::from_column_slice(step.as_slice()))
            .sup(&low)
            .inf(&high);
        let there = off(&next);
        if there.norm_squared() < here.norm_squared() {
            (at, here, damping) = (next, there, 0.3 * damping);
        } else {
            damping *= 5.0;
        }
    }
    let (friction, share) = (at[0].exp(), at[1].exp());
    world
        .clone()
        .with("friction", friction)
        .with("restitution", at[2])
        .with(ROLLS, (1.4 * radius * friction * share).min(0.02))
        .with(IN_SLIP, in_slip)
}

/// The world with friction and restitution from the lines, where they are free and a line can be drawn.
pub(crate) fn start(rig: &Rig, world: &World, strikes: &[&Strike], free: &[String]) -> World {
    let lines: Vec<_> = strikes
        .iter()
        .filter_map(|strike| Some((strike, strike.release()?)))
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
            .map(|(strike, (_, release))| {
                // Beside what the object had before.
                let moving = strike.conditions.moving.unwrap_or_default();
                let launched = Point::polar(*release, strike.path().bearing()) - moving;
                let along = match strike.conditions.moving {
                    Some(_) => launched.dot(Point::polar(1.0, strike.command.angle)),
                    None => *release,
                };
                along / strike.command.speed - 1.0
            })
            .collect(),
    );
    let mut world = world.clone();
    for (name, value) in [("friction", friction), ("restitution", launch)] {
        // A ball rolls: its deceleration says nothing of sliding friction.
        let usable = !(name == "friction" && rig.object.shape() == values::Shape::Sphere);
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

#[cfg(test)]
mod tests {
    use super::*;
    use values::{Command, Conditions, Point, Shape, Split, Track};

    fn strike(bearing: f64) -> Strike {
        let initial = Point::new(0.3, 0.0);
        let mut track = Track::default();
        for frame in 1..=10 {
            let at = initial + Point::polar(0.02 * f64::from(frame), bearing);
            track.t.push(0.02 * f64::from(frame));
            track.x.push(at.x);
            track.y.push(at.y);
        }
        Strike {
            id: String::new(),
            log: String::new(),
            index: 0,
            t_start: 0.0,
            initial,
            stop: initial + Point::polar(0.2, bearing),
            command: Command {
                speed: 0.7,
                angle: bearing,
            },
            track,
            split: Split::Train,
            conditions: Conditions::default(),
            delivered: None,
        }
    }

    #[test]
    fn a_tip_holds_a_box_as_far_aside_as_it_was_seen_to_go() {
        let found = |shape, furthest: f64| {
            let rig = Rig::demo(shape);
            let strikes: Vec<Strike> = (0..=50)
                .map(|i| strike(furthest * f64::from(i - 25) / 25.0))
                .collect();
            let strikes: Vec<&Strike> = strikes.iter().collect();
            let world = hold(&rig, World::nominal(), &strikes, &[]);
            world.value(HOLDS).expect("known")
        };
        let nominal = parameter(HOLDS).expect("known").nominal;
        assert_eq!(found(Shape::Box, 0.3), nominal);
        assert_eq!(found(Shape::Cylinder, 0.6), nominal);
        assert!((found(Shape::Box, 0.6) - HELD.1 * 0.6f64.tan()).abs() < 1e-9);
    }

    #[test]
    fn a_tip_that_would_slip_before_it_sends_a_box_so_far_aside_does_not_hold() {
        let strikes: Vec<Strike> = (0..=50)
            .map(|i| strike(0.6 * f64::from(i - 25) / 25.0))
            .collect();
        let strikes: Vec<&Strike> = strikes.iter().collect();
        let holds = |shape, friction| holds(&Rig::demo(shape), &strikes, friction);
        let needed = 0.6f64.tan();
        assert!(holds(Shape::Box, needed) && holds(Shape::Box, needed / HELD.1 + 1e-9));
        assert!(!holds(Shape::Box, 0.4));
        assert!(holds(Shape::Cylinder, 0.4));
    }
}
