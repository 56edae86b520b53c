//! The strike table: what the world would need for each strike, with standard errors, and what its track shows on the way.
//!
//! With G the derivatives of a strike's track by its own launch speed, angle, clock, resting place and friction, its needs are
//! θ = C·GᵀR⁻¹r, C = (GᵀR⁻¹G + P⁻¹)⁻¹, where only clock and resting place have a prior P: no scatter of launches or friction is
//! taken on trust. Beside them stands what a strike may depend on: what was commanded, where it starts, how long the arm paused before; never
//! what was realised. What is left on the way are scores of a push along and across the heading, BᵀΣ⁻¹r, by fifths of the way.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, SMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use values::{Command, Point, Strike, median};
use world::GRAVITY;

use super::projection::Basis;
use crate::before::CameBefore;
use crate::fit::Fitted;
use crate::mixed::{ANGLE, FRICTION, NUISANCES, SPEED};
use crate::model;
use crate::strikes::PreparedStrikes;

/// Hats along the way.
pub(super) const HATS: usize = 5;
/// Linear contrast of the hats: a push that grows from the first to the last.
const LINEAR: [f64; HATS] = [-1.0, -0.5, 0.0, 0.5, 1.0];
/// One push all the way.
const CONSTANT: [f64; HATS] = [1.0; HATS];

/// A column of the table: one number a strike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Column {
    /// Launch speed, relative to the world's.
    Launch,
    /// Launch angle, in rad.
    Heading,
    /// Friction, relative.
    Friction,
    /// How far the object slides, relative: twice the launch less the friction, where friction alone slows it to its rest ([`Row::gains`]).
    Stop,
    /// A push along the way that grows from its beginning to its end, in m/s².
    Fade,
    /// A push to the left of the way, in m/s².
    Curve,
}

impl Column {
    /// Whether the contact alone decides it, friction on the table aside.
    pub(super) fn is_of_launch(self) -> bool {
        matches!(self, Self::Launch | Self::Heading | Self::Stop)
    }
}

pub(super) const COLUMNS: [Column; 6] = [
    Column::Launch,
    Column::Heading,
    Column::Friction,
    Column::Stop,
    Column::Fade,
    Column::Curve,
];

/// A number and its standard error.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cell {
    pub(super) value: f64,
    pub(super) error: f64,
}

/// One strike.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// By the order of [`COLUMNS`].
    pub(super) cells: [Cell; COLUMNS.len()],
    /// Covariance of each column with the measured start (x, y) by the camera error that both share, in m times its unit.
    pub(super) shared: [Point; COLUMNS.len()],
    /// Pushes along and across the way by its fifths, in m/s².
    pub(super) along: [Cell; HATS],
    pub(super) across: [Cell; HATS],
    /// Where the object is at the middle of each.
    pub(super) places: [Point; HATS],
    /// How far it slides from its start, in m, and how far one m/s² of fade and of curve takes its stop. Where most strikes do not rest, to the
    /// end of the track.
    pub(super) slide: f64,
    /// By how much of that way more launch speed, and less friction, take its end farther, relative: 2 and 1 where friction alone slows it to
    /// its rest, less where drag does, too, and 1 and 0 where nothing brakes.
    pub(super) gains: [f64; 2],
    pub(super) reach: [f64; 2],
}

/// The strikes about a fitted model.
pub(super) fn table(prepared: &PreparedStrikes<'_>, fitted: &Fitted) -> Vec<Row> {
    (0..prepared.strikes.len())
        .into_par_iter()
        .map(|i| row(prepared, fitted, i))
        .collect()
}

type Own = SMatrix<f64, NUISANCES, NUISANCES>;

fn row(prepared: &PreparedStrikes<'_>, fitted: &Fitted, i: usize) -> Row {
    let components = &fitted.estimated.components;
    let precision = components.camera.powi(-2);
    let whitened = &fitted.linearisation.whitened[i];
    let g = &whitened.nuisances;
    let gram = g.tr_mul(g) * precision;
    let mut information = Own::from_fn(|a, b| gram[(a, b)]);
    for place in 0..NUISANCES {
        if ![SPEED, ANGLE, FRICTION].contains(&place) {
            information[(place, place)] += components.nuisance[place].max(1e-9).powi(-2);
        }
    }
    let covariance = information.try_inverse().unwrap_or_else(Own::zeros);
    let seen = g.tr_mul(&whitened.residual) * precision;
    let theta = covariance * seen.fixed_rows::<NUISANCES>(0);
    let left = &whitened.residual - g * theta;

    let way = Way::new(prepared, fitted, i);
    let pushed = prepared.whitenings[i].columns(&way.columns);
    let shrunk = g.tr_mul(&pushed);
    let weighed = (&pushed - g * (covariance * &shrunk) * precision) * precision;
    let information = pushed.tr_mul(&weighed);
    // What is left of the residual is weighed already: the nuisances' own priors are part of it.
    let score = pushed.tr_mul(&left) * precision;
    let of = |contrast: &[f64], first: usize| {
        let (mut u, mut v) = (0.0, 0.0);
        for (k, a) in contrast.iter().enumerate() {
            u += a * score[first + k];
            for (l, b) in contrast.iter().enumerate() {
                v += a * b * information[(first + k, first + l)];
            }
        }
        cell(u, v)
    };
    let own = |place: usize| Cell {
        value: theta[place],
        error: covariance[(place, place)].max(0.0).sqrt(),
    };
    let [launch, friction] = way.gains;
    let stop = Cell {
        value: launch * theta[SPEED] - friction * theta[FRICTION],
        error: (launch * launch * covariance[(SPEED, SPEED)]
            - 2.0 * launch * friction * covariance[(SPEED, FRICTION)]
            + friction * friction * covariance[(FRICTION, FRICTION)])
            .max(0.0)
            .sqrt(),
    };
    let with_start = |place: usize| Point::new(covariance[(place, 3)], covariance[(place, 4)]);
    let none = Point::default();
    let end = way.columns.nrows() / 2 - 1;
    let moved = |contrast: &[f64], first: usize| {
        let each = contrast.iter().enumerate();
        each.fold(Point::default(), |sum, (k, a)| {
            let column = way.columns.column(first + k);
            sum + Point::new(column[end], column[end + way.columns.nrows() / 2]) * *a
        })
        .norm()
    };
    Row {
        cells: [
            own(SPEED),
            own(ANGLE),
            own(FRICTION),
            stop,
            of(&LINEAR, 0),
            of(&CONSTANT, HATS),
        ],
        shared: [
            with_start(SPEED),
            with_start(ANGLE),
            with_start(FRICTION),
            with_start(SPEED) * launch + with_start(FRICTION) * -friction,
            none,
            none,
        ],
        along: std::array::from_fn(|k| cell(score[k], information[(k, k)])),
        across: std::array::from_fn(|k| cell(score[HATS + k], information[(HATS + k, HATS + k)])),
        places: way.places,
        slide: way.slide,
        gains: way.gains,
        reach: [moved(&LINEAR, 0), moved(&CONSTANT, HATS)],
    }
}

/// A score and its variance as what it estimates; of nothing seen, nothing with a great error.
fn cell(score: f64, variance: f64) -> Cell {
    const UNSEEN: f64 = 1e3;
    if variance < UNSEEN.powi(-2) {
        return Cell {
            value: 0.0,
            error: UNSEEN,
        };
    }
    Cell {
        value: score / variance,
        error: variance.sqrt().recip(),
    }
}

/// What pushes on the way do to a track, to first order: δs(t) = ∬ hat, until rest.
struct Way {
    /// A column for each hat along, then for each across: all x, then all y.
    columns: DMatrix<f64>,
    places: [Point; HATS],
    slide: f64,
    gains: [f64; 2],
}

impl Way {
    fn new(prepared: &PreparedStrikes<'_>, fitted: &Fitted, i: usize) -> Self {
        let (strike, raw) = (prepared.strikes[i], &fitted.linearisation.raw[i]);
        let n = strike.track.len();
        let at = |k: usize| Point::new(raw.simulated[k], raw.simulated[n + k]);
        let mut gone = vec![0.0; n];
        for k in 1..n {
            gone[k] = gone[k - 1] + at(k).distance(at(k - 1));
        }
        let seen = gone[n - 1].max(1e-9);
        // A hat stands at each fifth's middle of the way; together they are one.
        let hat = |h: usize, k: usize| {
            let place = (gone[k] / seen * HATS as f64 - 0.5).clamp(0.0, (HATS - 1) as f64);
            (1.0 - (place - h as f64).abs()).max(0.0)
        };
        let heading = prepared.frames[i].heading;
        let left = Point::new(-heading.y, heading.x);
        let speeds = raw.speeds();
        let mut columns = DMatrix::zeros(2 * n, 2 * HATS);
        for h in 0..HATS {
            let (mut speed, mut shift) = (0.0, 0.0);
            for k in 1..n {
                let step = (strike.track.t[k] - strike.track.t[k - 1]).max(0.0);
                let is_moving = speeds[k] > STILL;
                let mean = 0.5 * (hat(h, k) + hat(h, k - 1));
                if is_moving {
                    shift += speed * step + 0.5 * mean * step * step;
                    speed += mean * step;
                }
                let (ahead, aside) = (heading * shift, left * shift);
                columns[(k, h)] = ahead.x;
                columns[(n + k, h)] = ahead.y;
                columns[(k, HATS + h)] = aside.x;
                columns[(n + k, HATS + h)] = aside.y;
            }
        }
        // Where strikes rest, the way to there counts, as far as the track does not show it: its last frame often comes before.
        let t = &strike.track.t;
        let last = (t[n - 1] - t[n - 2]).max(1e-6);
        let by_friction = GRAVITY * fitted.model.values[model::FRICTION];
        let slowing = (speeds[n - 2] - speeds[n - 1]) / last;
        let left = match Strike::most_rest(prepared.strikes.iter().copied()) {
            true => speeds[n - 1] / slowing.max(0.5 * by_friction).max(1e-9),
            false => 0.0,
        };
        let unseen = 0.5 * speeds[n - 1] * left;
        // The track begins some frames after the impact: the way before it counts, too.
        let slide = strike.initial.distance(at(0)) + seen + unseen;
        let farther = |place: usize| {
            let moved = |k: usize| {
                let column = raw.nuisances.column(place);
                Point::new(column[k], column[n + k]).dot(heading)
            };
            let faster = (moved(n - 1) - moved(n - 2)) / last;
            moved(n - 1) + faster * left
        };
        let gains = [farther(SPEED), unseen - farther(FRICTION)].map(|moved| moved / slide);
        let places = std::array::from_fn(|h| {
            let middle = (h as f64 + 0.5) / HATS as f64 * seen;
            at(gone.partition_point(|gone| *gone < middle).min(n - 1))
        });
        Self {
            columns,
            places,
            slide,
            gains,
        }
    }
}

/// Speed in m/s below which an object lies still.
const STILL: f64 = 1e-3;

/// Values of one column, and their errors.
pub(super) fn column(rows: &[Row], column: Column) -> (DVector<f64>, DVector<f64>) {
    let place = column as usize;
    let of = |pick: &dyn Fn(&Cell) -> f64| {
        DVector::from_iterator(rows.len(), rows.iter().map(|row| pick(&row.cells[place])))
    };
    (of(&|cell| cell.value), of(&|cell| cell.error))
}

/// A covariate takes part where it varies by more than so many standard errors of its measurement.
const BEYOND_ERROR: f64 = 5.0;
/// Commands vary where their standard deviation is more than this: relative speed, or rad.
const VARIES: f64 = 2e-3;
/// Squared correlation by an error that a column shares with the measured start, times the strikes, above which the start is no
/// covariate of it.
const SHARED: f64 = 0.25;
/// Waves over a command, by its rank.
const WAVES: usize = 10;

/// Ripples over a command: periods of which its range holds so many at the most, and steps of that number.
const RIPPLES: f64 = 20.0;
const STEP: f64 = 0.5;
/// Least number of distinct values in each period.
const A_PERIOD: f64 = 4.0;

/// A cosine and a sine.
pub(super) type Wave = [DVector<f64>; 2];

/// A set of functions that a column is asked about together.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) name: &'static str,
    /// A column for each function.
    pub(super) functions: DMatrix<f64>,
}

/// The commands and starts of all strikes, scaled to mean 0 and standard deviation 1; none where a covariate hardly varies.
pub(super) struct Covariates {
    speed: Option<DVector<f64>>,
    angle: Option<DVector<f64>>,
    start: [Option<DVector<f64>>; 2],
    /// Bearing (rad) and distance (m) of the start from the arm's base.
    bearing: DVector<f64>,
    reach: DVector<f64>,
    pause: Option<DVector<f64>>,
    /// The command before, and on which side of it a command lies.
    before: Vec<DVector<f64>>,
    /// Where the object lay before.
    start_before: Vec<DVector<f64>>,
    /// The mean of the commands before.
    commands_before: Vec<DVector<f64>>,
    /// Standard deviations of the start, in m.
    spread: [f64; 2],
    strikes: usize,
}

impl Covariates {
    pub(super) fn new(
        prepared: &PreparedStrikes<'_>,
        resting: f64,
        came_before: &[CameBefore],
    ) -> Self {
        let strikes = &prepared.strikes;
        let of = |value: &dyn Fn(&Strike) -> f64| -> DVector<f64> {
            DVector::from_iterator(strikes.len(), strikes.iter().map(|strike| value(strike)))
        };
        let speed = of(&|s| s.command.speed);
        let angle = of(&|s| s.command.angle);
        let start = [of(&|s| s.initial.x), of(&|s| s.initial.y)];
        let base = prepared.rig.robot.base.unwrap_or_default();
        let from_base = |s: &Strike| s.initial - base;
        let (bearing, reach) = (
            of(&|s| from_base(s).bearing()),
            of(&|s| from_base(s).norm()),
        );
        let spread = [deviation(&start[0]), deviation(&start[1])];
        let logarithm = |before: &CameBefore| Some(before.pause?.max(1e-3).ln());
        let pauses: Vec<f64> = came_before.iter().filter_map(logarithm).collect();
        let usual = median(pauses).unwrap_or(0.0);
        let each = came_before
            .iter()
            .map(|before| logarithm(before).unwrap_or(usual));
        let pause = DVector::from_iterator(strikes.len(), each);
        let varies = VARIES * speed.mean().abs();
        let before = [
            (&speed, varies, (|c| c.speed) as fn(Command) -> f64),
            (&angle, VARIES, |c| c.angle),
        ];
        let before = before
            .into_iter()
            .flat_map(|(own, least, of)| last(own, least, of, came_before))
            .collect();
        let came = |own: &DVector<f64>, least, of: &dyn Fn(&CameBefore) -> Option<f64>| {
            let middle = own.mean();
            let each = came_before
                .iter()
                .map(|before| of(before).unwrap_or(middle));
            scaled(DVector::from_iterator(own.len(), each), least)
        };
        let place = BEYOND_ERROR * resting;
        let start_before = [
            came(&start[0], place, &|before| Some(before.start?.x)),
            came(&start[1], place, &|before| Some(before.start?.y)),
        ];
        let commands_before = [
            came(&speed, varies, &|before| Some(before.mean?[0])),
            came(&angle, VARIES, &|before| Some(before.mean?[1])),
        ];
        Self {
            speed: scaled(speed, varies),
            angle: scaled(angle, VARIES),
            start: start.map(|values| scaled(values, BEYOND_ERROR * resting)),
            pause: scaled(pause, 0.1),
            bearing,
            reach,
            before,
            start_before: start_before.into_iter().flatten().collect(),
            commands_before: commands_before.into_iter().flatten().collect(),
            spread,
            strikes: strikes.len(),
        }
    }

    /// What one column of the table is asked about.
    pub(super) fn groups(&self, rows: &[Row], column: usize, scatter: f64) -> Vec<Group> {
        let start = self.start_of(rows, column, scatter);
        let [x, y] = &start;
        let power = |values: &DVector<f64>, k: i32| values.map(|v| v.powi(k));
        let mut groups = Vec::new();
        let mut add = |name, functions: Vec<DVector<f64>>| {
            if !functions.is_empty() {
                let functions = DMatrix::from_columns(&functions);
                groups.push(Group { name, functions });
            }
        };
        let cubic = |values: &DVector<f64>| (1..=3).map(|k| power(values, k)).collect();
        if let Some(speed) = &self.speed {
            add("speed", cubic(speed));
            add("speed", waves(speed));
        }
        if let Some(angle) = &self.angle {
            add("angle", cubic(angle));
            add("angle", waves(angle));
        }
        let mut quadratic: Vec<DVector<f64>> = Vec::new();
        for place in start.iter().flatten() {
            quadratic.extend([place.clone(), power(place, 2)]);
        }
        quadratic.extend(x.iter().zip(y).map(|(x, y)| x.component_mul(y)));
        let linear: Vec<DVector<f64>> = start.iter().flatten().cloned().collect();
        add("start", linear);
        add("start", quadratic);
        // A joint's gears wave over where it stands.
        if let [Some(_), Some(_)] = start {
            add("start", waves(&self.bearing));
            add("start", waves(&self.reach));
        }
        let all = [&self.speed, &self.angle, x, y];
        add("command", products(all.into_iter().flatten()));
        add("pause", self.pause.iter().cloned().collect());
        let smooth = Basis::new(self.smooth());
        for (name, came) in [
            ("command before", &self.before),
            ("start before", &self.start_before),
            ("commands before", &self.commands_before),
        ] {
            add(name, smooth.beside(came.iter().cloned()));
        }
        groups
    }

    /// Waves of one period over a command, or over where a joint of the arm stands, as a resonance or a gear makes them.
    pub(super) fn ripples(&self) -> Vec<(&'static str, Vec<Wave>)> {
        let [x, y] = &self.start;
        let joints = (x.is_some() && y.is_some()).then_some([&self.bearing, &self.reach]);
        let commands = [("speed", &self.speed), ("angle", &self.angle)].into_iter();
        commands
            .filter_map(|(name, values)| Some((name, values.as_ref()?)))
            .chain(joints.into_iter().flatten().map(|values| ("start", values)))
            .map(|(name, values)| (name, ripples(values)))
            .collect()
    }

    /// The start, where the error that this column shares with its measurement is too small to show.
    fn start_of(&self, rows: &[Row], column: usize, scatter: f64) -> [Option<DVector<f64>>; 2] {
        let n = rows.len() as f64;
        let shared = rows.iter().fold(Point::default(), |sum, row| {
            sum + row.shared[column] * n.recip()
        });
        [(0, shared.x), (1, shared.y)].map(|(axis, shared)| {
            let correlation = shared / (scatter * self.spread[axis]).max(1e-300);
            let is_own = n * correlation * correlation <= SHARED;
            self.start[axis].clone().filter(|_| is_own)
        })
    }

    /// Smooth functions of all commands, as many as these strikes bear, to be taken off where something else is asked.
    pub(super) fn smooth(&self) -> Vec<DVector<f64>> {
        let [x, y] = &self.start;
        let each = [&self.speed, &self.angle, x, y];
        let powers = match self.strikes {
            ..40 => 1,
            40..80 => 2,
            _ => 3,
        };
        each.into_iter()
            .flatten()
            .flat_map(|values| (1..=powers).map(|k| values.map(|v| v.powi(k))))
            .collect()
    }

    /// Products of each two commands.
    pub(super) fn products(&self) -> Vec<DVector<f64>> {
        let [x, y] = &self.start;
        products([&self.speed, &self.angle, x, y].into_iter().flatten())
    }

    /// Commands and their squares times the place in the order, and times each session but the first (`sessions`: of all strikes, then these).
    pub(super) fn by_time(
        &self,
        sessions: &[DVector<f64>],
    ) -> Vec<(&'static str, Vec<DVector<f64>>)> {
        let place = DVector::from_fn(self.strikes, |i, _| i as f64);
        let times = |time: &DVector<f64>| {
            let commands = self.linear().into_iter();
            let both = commands.flat_map(|c| [c.component_mul(&c), c]);
            both.map(|c| c.component_mul(time)).collect::<Vec<_>>()
        };
        let by_order = scaled(place, 0.0).map(|place| ("command and order", times(&place)));
        let by_session = sessions.iter().skip(1).flat_map(times).collect();
        by_order
            .into_iter()
            .chain([("command and session", by_session)])
            .collect()
    }

    /// The commands themselves.
    pub(super) fn linear(&self) -> Vec<DVector<f64>> {
        let [x, y] = &self.start;
        let each = [&self.speed, &self.angle, x, y];
        each.into_iter().flatten().cloned().collect()
    }
}

fn products<'a>(all: impl Iterator<Item = &'a DVector<f64>>) -> Vec<DVector<f64>> {
    let all: Vec<_> = all.collect();
    let pairs = (0..all.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.map(|(i, j)| all[i].component_mul(all[j])).collect()
}

/// Waves of each period that these values can tell.
fn ripples(values: &DVector<f64>) -> Vec<Wave> {
    let (low, high) = (values.min(), values.max());
    let place = values.map(|v| (v - low) / (high - low).max(f64::MIN_POSITIVE));
    let most = RIPPLES.min(distinct(&sorted(values)) as f64 / A_PERIOD);
    let numbers = std::iter::successors(Some(1.0), |turns| Some(turns + STEP));
    numbers
        .take_while(|turns| *turns <= most)
        .map(|turns| [f64::cos, f64::sin].map(|of| place.map(|t| of(TAU * turns * t))))
        .collect()
}

fn sorted(values: &DVector<f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// Number of distinct values among sorted ones.
fn distinct(sorted: &[f64]) -> usize {
    sorted.windows(2).filter(|pair| pair[1] > pair[0]).count() + 1
}

/// Cosines of the rank, beyond those that a cubic holds.
fn waves(values: &DVector<f64>) -> Vec<DVector<f64>> {
    let n = values.len();
    let sorted = sorted(values);
    // Equal values stand at one place.
    let rank = values.map(|v| {
        let (low, high) = (
            sorted.partition_point(|other| *other < v),
            sorted.partition_point(|other| *other <= v),
        );
        0.5 * (low + high) as f64 / n as f64
    });
    let most = WAVES.min(distinct(&sorted) - 1).min(n / 4);
    cosines(&rank, most)
}

/// Cosines over places between 0 and 1.
pub(super) fn cosines(places: &DVector<f64>, count: usize) -> Vec<DVector<f64>> {
    (1..=count)
        .map(|k| places.map(|t| (std::f64::consts::PI * k as f64 * t).cos()))
        .collect()
}

pub(super) fn deviation(values: &DVector<f64>) -> f64 {
    values.variance().sqrt()
}

/// The value of the command before, whether the own one is greater (1) or less (−1), and by how much it is another; a strike without one before
/// stands in the middle. None where commands hardly vary.
fn last(
    own: &DVector<f64>,
    least: f64,
    of: fn(Command) -> f64,
    before: &[CameBefore],
) -> Vec<DVector<f64>> {
    let middle = own.mean();
    let value = DVector::from_iterator(
        own.len(),
        before
            .iter()
            .map(|before| before.command.map_or(middle, of)),
    );
    let side = DVector::from_fn(own.len(), |i, _| {
        let is_same = before[i].command.is_none() || (own[i] - value[i]).abs() < least;
        if is_same {
            0.0
        } else {
            (own[i] - value[i]).signum()
        }
    });
    let far = side.component_mul(&(own - &value));
    let all = [scaled(value, least), scaled(side, 0.0), scaled(far, least)];
    all.into_iter().flatten().collect()
}

/// Values scaled to mean 0 and standard deviation 1; none where their standard deviation is less than `least`.
fn scaled(values: DVector<f64>, least: f64) -> Option<DVector<f64>> {
    let (mean, deviation) = (values.mean(), deviation(&values));
    (deviation > least.max(1e-12)).then(|| values.map(|v| (v - mean) / deviation))
}
