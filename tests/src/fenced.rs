//! What tracks say that a fence cuts in mid-slide, beside the same strikes on an open table, and what they could say at the best.
//!
//! The best is the Cramér–Rao bound: no estimate without bias has a smaller standard error. It is computed here from the truth, by a point that slides
//! on a slope and by differences of its ways; nothing that the library computes goes into it.

use std::fmt::Write;
use std::path::Path;

use nalgebra::{Matrix4, Matrix5, RowVector4, RowVector5, SMatrix};
use rayon::prelude::*;
use rig::{FenceTruth, Hidden, PlannedStrike, Truth, demo};
use values::{Point, Shape, median};
use world::World;

/// What is estimated.
const NAMES: [&str; 4] = ["friction", "restitution", "tilt_x", "tilt_y"];
const STRIKES: usize = 120;
const GRAVITY: f64 = 9.81;
/// Seconds of rest that a camera sees, before and after.
const RESTS: f64 = 0.25;

/// One rig, with the fence and without.
struct Compared {
    open: Identified,
    fenced: Identified,
    /// By how much the fence widens what no estimate can better.
    bound: [f64; 4],
}

struct Identified {
    /// Whether the 95 % interval holds the truth, and its width.
    holds: [bool; 4],
    widths: [f64; 4],
    /// Whether the tilt and nothing else is named.
    is_named: bool,
    /// Tracks that do not end at rest.
    cut: usize,
}

/// The page's part: so many rigs, from this seed on.
pub fn page(rigs: usize, first: u64) -> anyhow::Result<String> {
    let rigs: Vec<Compared> = (0..rigs as u64)
        .into_par_iter()
        .map(|number| compared(first + number))
        .collect::<anyhow::Result<_>>()?;
    let of = rigs.len();
    let count = |is_so: &dyn Fn(&Compared) -> bool| rigs.iter().filter(|rig| is_so(rig)).count();
    let middle = |value: &dyn Fn(&Compared) -> f64| {
        median(rigs.iter().map(value).collect()).unwrap_or(f64::NAN)
    };
    let mut page = format!(
        "\n## A fence in mid-slide\n\n\
         {STRIKES} strikes of a disc on a tilted table, of {of} rigs, each once on an open table and once with a fence that nobody stated, which cuts {:.0} of the tracks (the median of the\n\
         rigs). The tilt, and nothing else, is named on {} of {of} open tables and on {} of {of} with the fence.\n\n\
         | | 95 % intervals that hold the truth, open | with the fence | width with the fence, in widths on the open table | the same by the Cramér–Rao bound |\n\
         |---|---|---|---|---|\n",
        middle(&|rig| rig.fenced.cut as f64),
        count(&|rig| rig.open.is_named),
        count(&|rig| rig.fenced.is_named),
    );
    for (i, name) in NAMES.iter().enumerate() {
        let _ = writeln!(
            page,
            "| `{name}` | {} of {of} | {} of {of} | {:.2} | {:.2} |",
            count(&|rig| rig.open.holds[i]),
            count(&|rig| rig.fenced.holds[i]),
            middle(&|rig| rig.fenced.widths[i] / rig.open.widths[i]),
            middle(&|rig| rig.bound[i]),
        );
    }
    page += "\nWidths are medians over the rigs, as are bounds. The bound is that of the strikes up to the fence's touch, with each strike's launch, heading, start and clock unknown as they are in the truth:\n\
             it is computed by the harness from ways of a sliding point, and says how much of what an open table's tracks tell lies behind the fence. A stop tells friction best, for it is seen at rest\n\
             in many frames; a track that is cut before has none. What an interval is wider by than the bound is the library's own; less than that no method can reach from these tracks.\n";
    Ok(page)
}

fn compared(seed: u64) -> anyhow::Result<Compared> {
    let number = seed as f64;
    let part = |k: f64| (number * k).fract();
    let tilt = Point::polar(
        0.008 + 0.008 * part(0.618),
        std::f64::consts::TAU * part(0.414),
    );
    let hidden = Hidden::parse(&[format!("table_tilt={},{}", tilt.x, tilt.y).as_str()])?;
    let mut settings = demo::Settings::new(Shape::Cylinder, STRIKES, seed, Some(hidden));
    settings.truth.friction = 0.15 + 0.1 * part(0.732);
    let folder = tempfile::tempdir()?;
    let open = folder.path().join("open");
    let strikes = Truth::load(&demo::write(&settings, &open)?.truth)?.strikes;
    let plan = strikes.iter().map(|strike| PlannedStrike {
        x0: strike.initial.x,
        y0: strike.initial.y,
        speed: strike.command.speed,
        angle: strike.command.angle,
    });
    settings.plan = Some(plan.collect());
    let fence = FenceTruth {
        from: Point::new(0.55, -0.8),
        to: Point::new(0.65, 0.8),
        restitution: 0.5,
    };
    settings.truth.fences = vec![fence];
    let fenced = folder.path().join("fenced");
    demo::write(&settings, &fenced)?;
    let truth = &settings.truth;
    let all = [truth.friction, truth.restitution, tilt.x, tilt.y];
    let best = |fence| bound(truth, &strikes, all, fence);
    let (bound_open, bound_fenced) = (best(None)?, best(Some(&fence))?);
    Ok(Compared {
        open: identified(&open, all)?,
        fenced: identified(&fenced, all)?,
        bound: std::array::from_fn(|i| bound_fenced[i] / bound_open[i]),
    })
}

/// What the library makes of logs.
fn identified(folder: &Path, truth: [f64; 4]) -> anyhow::Result<Identified> {
    let dir = folder.display();
    crate::carom(&format!(
        "ingest {dir}/logs --rig {dir}/rig.toml --out {dir}/run"
    ))?;
    let cut = tables::read_strikes(&folder.join("run"))?;
    let cut = cut.iter().filter(|strike| !strike.has_stop()).count();
    crate::carom(&format!("diagnose --out {dir}/run"))?;
    let world = World::load(&folder.join("run/world.toml"))?;
    let of_tilt = world.effects.first().map(|effect| &effect.parameters);
    let estimates: [Option<(f64, f64)>; 4] = std::array::from_fn(|i| {
        let found = match i {
            0 | 1 => world.parameters.get(NAMES[i]),
            _ => of_tilt.and_then(|parameters| parameters.get(NAMES[i])),
        }?;
        Some((found.low?, found.high?))
    });
    let named: Vec<&str> = world.effects.iter().map(|e| e.name.as_str()).collect();
    Ok(Identified {
        holds: std::array::from_fn(|i| {
            estimates[i].is_some_and(|(low, high)| (low..=high).contains(&truth[i]))
        }),
        widths: estimates.map(|ends| ends.map_or(f64::INFINITY, |(low, high)| high - low)),
        is_named: named == ["table_tilt"],
        cut,
    })
}

/// Standard errors of [`NAMES`] that no estimate without bias can better.
fn bound(
    truth: &Truth,
    strikes: &[rig::StrikeTruth],
    all: [f64; 4],
    fence: Option<&FenceTruth>,
) -> anyhow::Result<[f64; 4]> {
    let reach = truth.rig.object.solid.reach();
    let (rate, noise) = (truth.rig.camera.rate, truth.rig.camera.noise);
    let still = noise / (RESTS * rate).sqrt();
    // Launch, heading, both coordinates of the start, clock: what is known of them beforehand.
    let known = [
        truth.scatter.speed,
        truth.scatter.angle,
        still,
        still,
        (1.0 / 12.0_f64).sqrt() / rate,
    ];
    let prior = Matrix5::from_diagonal(&known.map(|sd| 1.0 / (sd * sd)).into());
    let steps = ([1e-4, 1e-4, 1e-5, 1e-5], [1e-3, 1e-3, 1e-4, 1e-4, 1e-4]);
    let mut information = Matrix4::zeros();
    for strike in strikes {
        let way = |all: [f64; 4], own: [f64; 5]| {
            let start = strike.initial + Point::new(own[2], own[3]);
            let speed = (1.0 + all[1]) * strike.command.speed * (1.0 + own[0]);
            let launch = Point::polar(speed, strike.command.angle + own[1]);
            (Way::of(start, launch, all), own[4])
        };
        let at = |(way, clock): &(Way, f64), time: f64| way.at(time + clock);
        let usual = way(all, [0.0; 5]);
        let changed = |i: usize, by: f64| {
            let (mut all, mut own) = (all, [0.0; 5]);
            if i < 4 {
                all[i] += by * steps.0[i];
            } else {
                own[i - 4] += by * steps.1[i - 4];
            }
            way(all, own)
        };
        let ways: Vec<_> = (0..9)
            .map(|i| (changed(i, 1.0), changed(i, -1.0)))
            .collect();
        let by = |i: usize, time: f64| {
            let step = if i < 4 { steps.0[i] } else { steps.1[i - 4] };
            (at(&ways[i].0, time) - at(&ways[i].1, time)) * (0.5 / step)
        };
        let frames = ((usual.0.rest() + RESTS) * rate) as usize;
        let (mut cc, mut cn, mut nn) = (Matrix4::zeros(), SMatrix::<f64, 4, 5>::zeros(), prior);
        for frame in 0..frames {
            let time = (frame as f64 + 0.5) / rate;
            let touches = |fence: &&FenceTruth| gap(fence, at(&usual, time)) < reach;
            if fence.as_ref().is_some_and(touches) {
                break;
            }
            let rates: [Point; 9] = std::array::from_fn(|i| by(i, time));
            for coordinate in [|p: &Point| p.x, |p: &Point| p.y] {
                let c = RowVector4::from_fn(|_, i| coordinate(&rates[i]) / noise);
                let n = RowVector5::from_fn(|_, i| coordinate(&rates[4 + i]) / noise);
                cc += c.transpose() * c;
                cn += c.transpose() * n;
                nn += n.transpose() * n;
            }
        }
        let own = nn
            .try_inverse()
            .ok_or_else(|| anyhow::anyhow!("a strike's own"))?;
        information += cc - cn * own * cn.transpose();
    }
    let covariance = information
        .try_inverse()
        .ok_or_else(|| anyhow::anyhow!("these strikes do not tell all four"))?;
    Ok(std::array::from_fn(|i| covariance[(i, i)].sqrt()))
}

/// How far a point lies from a fence, in m.
fn gap(fence: &FenceTruth, at: Point) -> f64 {
    let along = fence.to - fence.from;
    let share = ((at - fence.from).dot(along) / along.dot(along)).clamp(0.0, 1.0);
    at.distance(fence.from + along * share)
}

/// How a point slides on a slope: place and velocity at each step.
struct Way(Vec<(Point, Point)>);

impl Way {
    const STEP: f64 = 0.001;

    /// By the rule of the middle, until friction would turn it round within a step.
    fn of(start: Point, launch: Point, [friction, _, tilt_x, tilt_y]: [f64; 4]) -> Self {
        let brakes = |velocity: Point| {
            velocity * (-friction * GRAVITY / velocity.norm())
                + Point::new(tilt_x, tilt_y) * GRAVITY
        };
        let (mut place, mut velocity) = (start, launch);
        let mut way = vec![(place, velocity)];
        while velocity.norm() > 1.5 * Self::STEP * friction * GRAVITY {
            let middle = velocity + brakes(velocity) * (0.5 * Self::STEP);
            place = place + middle * Self::STEP;
            velocity = velocity + brakes(middle) * Self::STEP;
            way.push((place, velocity));
        }
        let left = velocity * (0.5 * velocity.norm() / (friction * GRAVITY));
        way.push((place + left, Point::default()));
        Self(way)
    }

    /// When it rests, in s after the launch.
    fn rest(&self) -> f64 {
        self.0.len() as f64 * Self::STEP
    }

    fn at(&self, time: f64) -> Point {
        let step = (time.max(0.0) / Self::STEP) as usize;
        let Some([one, other]) = self.0.get(step..step + 2) else {
            return self.0[self.0.len() - 1].0;
        };
        one.0 + (other.0 - one.0) * (time.max(0.0) / Self::STEP - step as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_stops_where_the_closed_form_says() {
        let way = Way::of(
            Point::default(),
            Point::new(1.2, 0.0),
            [0.2, 0.5, 0.01, 0.0],
        );
        let braking = (0.2 - 0.01) * GRAVITY;
        assert!((way.at(9.0).x - 0.72 / braking).abs() < 1e-5);
        let time = 0.3;
        let there = 1.2 * time - 0.5 * braking * time * time;
        assert!((way.at(time).x - there).abs() < 1e-5);
    }

    #[test]
    fn what_a_fence_hides_widens_the_bound_and_less_noise_narrows_it() {
        let mut truth = Truth::demo(&Truth::demo_rig(Shape::Cylinder), 1);
        let strikes: Vec<rig::StrikeTruth> = (0..40)
            .map(|order| rig::StrikeTruth {
                session: 0,
                order,
                initial: Point::new(0.3, 0.01 * order as f64 - 0.2),
                command: values::Command::new(0.5 + 0.01 * order as f64, 0.02 * order as f64 - 0.4),
                delivered: values::Command::new(0.5, 0.0),
                impact: 0,
                rest_time: 0.0,
                stop: Point::default(),
                friction: None,
                yaw: None,
            })
            .collect();
        let all = [0.18, 0.5, 0.01, 0.005];
        let fence = FenceTruth {
            from: Point::new(0.5, -0.8),
            to: Point::new(0.5, 0.8),
            restitution: 0.5,
        };
        let open = bound(&truth, &strikes, all, None).expect("a bound");
        let fenced = bound(&truth, &strikes, all, Some(&fence)).expect("a bound");
        assert!((0..4).all(|i| fenced[i] > open[i]), "{open:?} {fenced:?}");
        truth.rig.camera.noise *= 0.5;
        let sharper = bound(&truth, &strikes, all, None).expect("a bound");
        assert!((0..4).all(|i| sharper[i] < open[i]), "{open:?} {sharper:?}");
    }
}
