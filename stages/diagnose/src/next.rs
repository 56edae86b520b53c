//! Which strikes to make next: those that would best distinguish two models (T-optimal design, Atkinson and Fedorov 1975).
//!
//! T = min over the rival's parameters of ‖f_A − f_B‖², weighed as the strikes' own evidence. What the rival can still follow is
//! projected off, with all that it has learnt from the strikes at hand; strikes are added one by one, then exchanged.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use values::{Command, Conditions, Point, Rig, Split, Strike, Track};
use world::{World, WorldError, launch::launches};

use crate::{
    Diagnose,
    diagnosis::NextStrike,
    fit::Fitted,
    linearisation::Linearised,
    mixed::posterior,
    model::CLOCK,
    strikes::{Nuisances, PreparedStrikes, stack},
    words::Purpose,
};

/// Speeds, angles and places along each side from which strikes are chosen, the ends of each range among them.
const SPEEDS: usize = 5;
const ANGLES: usize = 7;
const PLACES: usize = 3;
/// Distance in m that stops keep from the table's edge.
const MARGIN: f64 = 0.03;
/// Frames of a proposed strike.
const FRAMES: usize = 40;
/// Value of T from which a pair is separated in 95 of 100 cases: Φ(√T/2).
const ENOUGH: f64 = 10.8;

/// How far one strike separates two models, and how much of that the rival could follow.
struct StrikeInformation {
    square: f64,
    slope: DVector<f64>,
    information: DMatrix<f64>,
}

/// How far each strike of a pool separates a model from a rival.
struct Contrast<'r> {
    rival: &'r Fitted,
    by_strike: Vec<Option<StrikeInformation>>,
}

/// Strikes within the robot's limits that best separate `named` from its rivals, the most informative first.
pub(crate) fn next_strikes(
    seen: &PreparedStrikes<'_>,
    world: &World,
    named: &Fitted,
    rivals: &[&Fitted],
    why: &Purpose,
    settings: &Diagnose,
) -> Result<Vec<NextStrike>, WorldError> {
    let rig = seen.rig;
    let pool = pool(rig, &seen.strikes);
    let commands: Vec<Command> = commands(rig);
    let straight = Conditions::default();
    let launches = launches(rig, world, commands.iter().map(|c| (*c, &straight)))?;
    let launch_of = |command: &Command| {
        let place = commands.iter().position(|c| c == command)?;
        launches[place]
    };
    let (strikes, launches): (Vec<&Strike>, Vec<_>) = pool
        .iter()
        .filter_map(|strike| Some((strike, launch_of(&strike.command)?)))
        .unzip();
    let prepared =
        PreparedStrikes::new(rig, strikes, launches, seen.thresholds).with_noise(seen.noise);
    let pairs = rivals
        .iter()
        .map(|rival| {
            let forth = Contrast::new(&prepared, named, rival)?;
            let back = Contrast::new(&prepared, rival, named)?;
            Ok((forth, back))
        })
        .collect::<Result<Vec<_>, WorldError>>()?;
    // Concave, so that the pair that is separated least counts most; what nothing here can separate adds nothing.
    let value = |sets: &[(SetInformation, SetInformation)]| -> f64 {
        let each = sets.iter().map(|(forth, back)| {
            let apart = forth.separation().min(back.separation());
            (apart.max(0.0) / ENOUGH).ln_1p()
        });
        each.sum()
    };
    let information_of = |chosen: &[usize]| -> Vec<(SetInformation, SetInformation)> {
        let each = pairs.iter();
        each.map(|(forth, back)| (forth.information_of(chosen), back.information_of(chosen)))
            .collect()
    };
    let possible: Vec<usize> = (0..prepared.strikes.len())
        .filter(|i| {
            pairs
                .iter()
                .all(|(forth, back)| forth.by_strike[*i].is_some() && back.by_strike[*i].is_some())
        })
        .collect();
    let best = |chosen: &[usize], from: &[usize], place: Option<usize>| -> Option<(f64, usize)> {
        let mut rest = chosen.to_vec();
        if let Some(place) = place {
            rest.remove(place);
        }
        let so_far = information_of(&rest);
        from.par_iter()
            .filter(|i| !chosen.contains(i))
            .map(|i| {
                let with: Vec<(SetInformation, SetInformation)> = pairs
                    .iter()
                    .zip(&so_far)
                    .map(|((forth, back), (f, b))| (forth.and(f, *i), back.and(b, *i)))
                    .collect();
                (value(&with), *i)
            })
            .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))
    };
    let grow = |from: &[usize]| {
        let mut chosen: Vec<usize> = Vec::new();
        while chosen.len() < settings.next_strikes.min(from.len()) {
            let Some((_, next)) = best(&chosen, from, None) else {
                break;
            };
            chosen.push(next);
        }
        chosen
    };
    let mut chosen = grow(&possible);
    for place in 0..chosen.len() {
        let now = value(&information_of(&chosen));
        if let Some((_, other)) =
            best(&chosen, &possible, Some(place)).filter(|(value, _)| *value > now)
        {
            chosen[place] = other;
        }
    }
    // The most informative first: who makes only some makes the best.
    Ok(grow(&chosen)
        .iter()
        .map(|i| {
            let strike = prepared.strikes[*i];
            NextStrike {
                x0: strike.initial.x,
                y0: strike.initial.y,
                speed: strike.command.speed,
                angle: strike.command.angle,
                why: why.clone().into(),
            }
        })
        .collect())
}

/// Repeats of the most usual command, so that the scatter of repeats is measured; without them, all that no question finds is taken for it.
pub(crate) fn repeats(seen: &[&Strike], settings: &Diagnose) -> Vec<NextStrike> {
    let ranks = |value: fn(&Strike) -> f64| {
        let mut order: Vec<usize> = (0..seen.len()).collect();
        order.sort_by(|a, b| value(seen[*a]).total_cmp(&value(seen[*b])));
        let mut ranks = vec![0.0; seen.len()];
        for (rank, place) in order.into_iter().enumerate() {
            ranks[place] = rank as f64 - (seen.len() as f64 - 1.0) / 2.0;
        }
        ranks
    };
    let all = [
        ranks(|s| s.command.speed),
        ranks(|s| s.command.angle),
        ranks(|s| s.initial.x),
        ranks(|s| s.initial.y),
    ];
    let away = |place: &usize| -> f64 { all.iter().map(|ranks| ranks[*place].powi(2)).sum() };
    let usual = (0..seen.len()).min_by(|a, b| away(a).total_cmp(&away(b)));
    let strike = usual.map(|place| NextStrike {
        x0: seen[place].initial.x,
        y0: seen[place].initial.y,
        speed: seen[place].command.speed,
        angle: seen[place].command.angle,
        why: Purpose::Repeats.into(),
    });
    let again = strike.into_iter().cycle();
    again.take(settings.next_strikes).collect()
}

/// `count` values over a range, its ends among them; rounded as a person would type, the ends inwards.
fn over(low: f64, high: f64, count: usize) -> impl Iterator<Item = f64> {
    const DIGITS: f64 = 1e4;
    let ends = ((low * DIGITS - 1e-6).ceil(), (high * DIGITS + 1e-6).floor());
    (0..count).map(move |i| {
        let value = ends.0 + (ends.1 - ends.0) * i as f64 / (count - 1) as f64;
        value.round() / DIGITS
    })
}

/// Commands over all of the robot's speeds and angles.
fn commands(rig: &Rig) -> Vec<Command> {
    let (speed, angle) = (rig.robot.speed, rig.robot.angle);
    over(speed.low, speed.high, SPEEDS)
        .flat_map(|speed| {
            over(angle.low, angle.high, ANGLES).map(move |angle| Command { speed, angle })
        })
        .collect()
}

/// Every command from places all over where the robot has struck before.
fn pool(rig: &Rig, seen: &[&Strike]) -> Vec<Strike> {
    let range = |value: fn(&Strike) -> f64| {
        seen.iter()
            .map(|s| value(s))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(v), h.max(v))
            })
    };
    let (x, y) = (range(|s| s.initial.x), range(|s| s.initial.y));
    let places: Vec<Point> = over(x.0, x.1, PLACES)
        .flat_map(|x| over(y.0, y.1, PLACES).map(move |y| Point::new(x, y)))
        .collect();
    let times: Vec<f64> = (1..=FRAMES).map(|i| i as f64 / rig.camera.rate).collect();
    // Those of the session and time that strikes made next belong to, with an object that lies straight.
    let last = seen.last().map(|strike| strike.conditions.clone());
    let conditions = Conditions {
        yaw: None,
        ..last.unwrap_or_default()
    };
    commands(rig)
        .into_iter()
        .flat_map(|command| places.iter().map(move |place| (*place, command)))
        .map(|(initial, command)| Strike {
            id: String::new(),
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
                yaw: None,
                end: values::End::Rest,
            },
            split: Split::Train,
            conditions: conditions.clone(),
            delivered: None,
        })
        .collect()
}

/// For each strike how far the rival's track lies from the named model's; `None` where one leaves the table.
fn by_strike(
    prepared: &PreparedStrikes<'_>,
    named: &Fitted,
    rival: &Fitted,
) -> Result<Vec<Option<StrikeInformation>>, WorldError> {
    let none = vec![Nuisances::zeros(); prepared.strikes.len()];
    let Some(columns) = Linearised::all(prepared, &rival.model, &none)? else {
        return Ok((0..none.len()).map(|_| None).collect());
    };
    let effects = named.model.effects(prepared.rig, &named.model.values)?;
    let planar = prepared.planar(&named.model.values, &effects);
    let table = &prepared.rig.table;
    let is_on = |p: Point| {
        p.x > table.x.low + MARGIN
            && p.x < table.x.high - MARGIN
            && p.y > table.y.low + MARGIN
            && p.y < table.y.high - MARGIN
    };
    let components = &named.estimated.components;
    Ok(columns
        .into_par_iter()
        .enumerate()
        .map(|(i, raw)| {
            let frames = prepared.simulate(&planar, i, named.model.values[CLOCK], &none[i])?;
            if !is_on(frames.stop) {
                return None;
            }
            let whitening = &prepared.whitenings[i];
            let apart = whitening.column(&(stack(&frames.at) - &raw.simulated));
            let columns = raw.whitened(whitening);
            let g = &columns.nuisances;
            let precision = components.camera.powi(-2);
            let posterior = posterior(g, components) * precision;
            let weigh = |m: &DMatrix<f64>| m * precision - g * (&posterior * g.tr_mul(m));
            let column = DMatrix::from_column_slice(apart.len(), 1, apart.as_slice());
            let weighed = weigh(&column);
            Some(StrikeInformation {
                square: weighed.column(0).dot(&apart),
                slope: columns.values.tr_mul(&weighed).column(0).into_owned(),
                information: columns.values.tr_mul(&weigh(&columns.values)),
            })
        })
        .collect())
}

impl<'r> Contrast<'r> {
    fn new(
        prepared: &PreparedStrikes<'_>,
        model: &Fitted,
        rival: &'r Fitted,
    ) -> Result<Self, WorldError> {
        Ok(Self {
            rival,
            by_strike: by_strike(prepared, model, rival)?,
        })
    }

    /// What a set of strikes says between model and rival, on top of all that the rival has learnt.
    fn information_of(&self, chosen: &[usize]) -> SetInformation {
        let nothing = SetInformation {
            square: 0.0,
            slope: DVector::zeros(self.rival.model.free.len()),
            information: self.rival.estimated.information.clone(),
        };
        chosen.iter().fold(nothing, |sum, i| self.and(&sum, *i))
    }

    /// What a set says with strike `i` added.
    fn and(&self, set: &SetInformation, i: usize) -> SetInformation {
        let mut more = set.clone();
        if let Some(strike) = &self.by_strike[i] {
            more.square += strike.square;
            more.slope += &strike.slope;
            more.information += &strike.information;
        }
        more
    }
}

/// What a set of strikes says between a model and its rival.
#[derive(Clone)]
struct SetInformation {
    square: f64,
    slope: DVector<f64>,
    information: DMatrix<f64>,
}

impl SetInformation {
    /// T: how far the rival is from explaining them.
    fn separation(&self) -> f64 {
        match self.information.clone().cholesky() {
            Some(factor) => self.square - self.slope.dot(&factor.solve(&self.slope)),
            None => 0.0,
        }
    }
}
