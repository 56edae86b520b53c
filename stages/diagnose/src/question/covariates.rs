//! What a strike may depend on: what was commanded, where it starts, how long the arm paused before. Never what was realised.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use values::{Command, Point, Strike};

use super::{projection::Basis, table::Row};
use crate::strikes::PreparedStrikes;

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

/// What came before a strike.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Before {
    /// Time, in s, in which no strike was made.
    pub(crate) pause: f64,
    /// The command of the strike before in the same log, where there is one.
    pub(crate) command: Option<Command>,
}

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
    /// Standard deviations of the start, in m.
    spread: [f64; 2],
    strikes: usize,
}

impl Covariates {
    pub(super) fn new(
        prepared: &PreparedStrikes<'_>,
        resting: f64,
        came_before: &[Before],
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
        let pause = DVector::from_iterator(
            strikes.len(),
            came_before.iter().map(|before| before.pause.max(1e-3).ln()),
        );
        let varies = VARIES * speed.mean().abs();
        let before = [
            (&speed, varies, (|c| c.speed) as fn(Command) -> f64),
            (&angle, VARIES, |c| c.angle),
        ];
        let before = before
            .into_iter()
            .flat_map(|(own, least, of)| last(own, least, of, came_before))
            .collect();
        Self {
            speed: scaled(speed, varies),
            angle: scaled(angle, VARIES),
            start: start.map(|values| scaled(values, BEYOND_ERROR * resting)),
            pause: scaled(pause, 0.1),
            bearing,
            reach,
            before,
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
        add("command before", smooth.beside(self.before.iter().cloned()));
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
    before: &[Before],
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
