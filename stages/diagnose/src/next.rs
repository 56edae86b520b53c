//! Which strikes to make next: those that would best tell two models apart (T-optimal design, Atkinson and Fedorov 1975).
//!
//! T = min over the rival's parameters of ‖f_A − f_B‖², weighed as the strikes' own evidence. What the rival can still follow is
//! projected off, with all that it has learnt from the strikes at hand; strikes are added one by one, then exchanged.

use nalgebra::{DMatrix, DVector, SVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use values::{Command, Conditions, Point, Rig, Split, Strike, Track};
use world::{World, WorldError, launch::launches};

use crate::{
    Diagnose,
    diagnosis::NextStrike,
    fit::{Field, Fitted, stack},
    mixed::{NUISANCES, posterior},
    model::CLOCK,
};

/// Strikes drawn to choose from.
const POOL: usize = 160;
/// Distance in m that stops keep from the table's edge.
const MARGIN: f64 = 0.03;
/// Frames of a proposed strike.
const FRAMES: usize = 40;

/// How much one strike tells two models apart, and what of it the rival could follow.
struct Tells {
    square: f64,
    slope: DVector<f64>,
    information: DMatrix<f64>,
}

/// Strikes within the robot's limits that best separate `named` from `rival`.
pub(crate) fn next_strikes(
    rig: &Rig,
    world: &World,
    named: &Fitted,
    rival: &Fitted,
    seen: &[&Strike],
    why: &str,
    settings: &Diagnose,
) -> Result<Vec<NextStrike>, WorldError> {
    let pool = pool(rig, seen, settings.seed);
    let commands: Vec<Command> = pool.iter().map(|strike| strike.command).collect();
    let (strikes, launches): (Vec<&Strike>, Vec<_>) = pool
        .iter()
        .zip(launches(rig, world, &commands)?)
        .filter_map(|(strike, launch)| Some((strike, launch?)))
        .unzip();
    let field = Field::new(rig, strikes, launches);
    let forth = tells(&field, named, rival)?;
    let back = tells(&field, rival, named)?;
    let total =
        |chosen: &[usize]| separation(&forth, rival, chosen).min(separation(&back, named, chosen));
    let possible: Vec<usize> = (0..field.strikes.len())
        .filter(|i| forth[*i].is_some() && back[*i].is_some())
        .collect();
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < settings.next_strikes.min(possible.len()) {
        let best = possible
            .par_iter()
            .filter(|i| !chosen.contains(i))
            .map(|i| {
                let mut with = chosen.clone();
                with.push(*i);
                (total(&with), *i)
            })
            .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let Some((_, best)) = best else { break };
        chosen.push(best);
    }
    for place in 0..chosen.len() {
        let now = total(&chosen);
        let better = possible
            .par_iter()
            .filter(|i| !chosen.contains(i))
            .map(|i| {
                let mut with = chosen.clone();
                with[place] = *i;
                (total(&with), *i)
            })
            .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        if let Some((value, other)) = better
            && value > now
        {
            chosen[place] = other;
        }
    }
    Ok(chosen
        .iter()
        .map(|i| {
            let strike = field.strikes[*i];
            NextStrike {
                x0: strike.initial.x,
                y0: strike.initial.y,
                speed: strike.command.speed,
                angle: strike.command.angle,
                why: why.into(),
            }
        })
        .collect())
}

/// Strikes drawn from where the robot has struck before, over all of its speeds and angles; rounded as a person would type.
fn pool(rig: &Rig, seen: &[&Strike], seed: u64) -> Vec<Strike> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut between = |low: f64, high: f64| {
        let value = low + (high - low) * random.random::<f64>();
        (value * 1e3).round() / 1e3
    };
    let range = |value: fn(&Strike) -> f64| {
        seen.iter()
            .map(|s| value(s))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(v), h.max(v))
            })
    };
    let (x, y) = (range(|s| s.initial.x), range(|s| s.initial.y));
    let times: Vec<f64> = (1..=FRAMES).map(|i| i as f64 / rig.camera.rate).collect();
    (0..POOL)
        .map(|i| {
            let initial = Point::new(between(x.0, x.1), between(y.0, y.1));
            let command = Command {
                speed: between(rig.robot.speed.low, rig.robot.speed.high),
                angle: between(rig.robot.angle.low, rig.robot.angle.high),
            };
            Strike {
                id: format!("{i}"),
                log: String::new(),
                index: 0,
                t_start: 0.0,
                initial,
                stop: initial,
                command,
                track: Track {
                    x: vec![0.0; times.len()],
                    y: vec![0.0; times.len()],
                    t: times.clone(),
                },
                split: Split::Train,
                conditions: Conditions {
                    session: String::new(),
                    order: seen.len() as f64,
                },
            }
        })
        .collect()
}

/// For each strike how far the rival's track lies from the named model's; `None` where one leaves the table.
fn tells(
    field: &Field<'_>,
    named: &Fitted,
    rival: &Fitted,
) -> Result<Vec<Option<Tells>>, WorldError> {
    let none = vec![SVector::<f64, NUISANCES>::zeros(); field.strikes.len()];
    let Some(columns) = field.columns(&rival.model, &none)? else {
        return Ok((0..none.len()).map(|_| None).collect());
    };
    let effects = named.model.effects(field.rig, &named.model.values)?;
    let planar = field.planar(&named.model.values, &effects);
    let table = &field.rig.table;
    let is_on = |p: Point| {
        p.x > table.x.low + MARGIN
            && p.x < table.x.high - MARGIN
            && p.y > table.y.low + MARGIN
            && p.y < table.y.high - MARGIN
    };
    let spread = &named.estimated.spread;
    Ok(columns
        .into_par_iter()
        .enumerate()
        .map(|(i, columns)| {
            let frames = field.frames(&planar, i, named.model.values[CLOCK], &none[i])?;
            if !is_on(frames.stop) {
                return None;
            }
            let rivals = field.simulated(i, &columns, &none[i]);
            let apart = stack(&frames.at) - rivals;
            let g = &columns.nuisances;
            let precision = spread.camera.powi(-2);
            let posterior = posterior(g, spread) * precision;
            let weigh = |m: &DMatrix<f64>| m * precision - g * (&posterior * g.tr_mul(m));
            let column = DMatrix::from_column_slice(apart.len(), 1, apart.as_slice());
            let weighed = weigh(&column);
            Some(Tells {
                square: weighed.column(0).dot(&apart),
                slope: columns.values.tr_mul(&weighed).column(0).into_owned(),
                information: columns.values.tr_mul(&weigh(&columns.values)),
            })
        })
        .collect())
}

/// T of a set of strikes, beside all that the rival has learnt.
fn separation(tells: &[Option<Tells>], rival: &Fitted, chosen: &[usize]) -> f64 {
    let mut square = 0.0;
    let mut slope = DVector::zeros(rival.model.free.len());
    let mut information = rival.estimated.information.clone();
    for told in chosen.iter().filter_map(|i| tells[*i].as_ref()) {
        square += told.square;
        slope += &told.slope;
        information += &told.information;
    }
    match information.cholesky() {
        Some(factor) => square - slope.dot(&factor.solve(&slope)),
        None => 0.0,
    }
}
