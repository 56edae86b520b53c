//! The strike table: what the world would need for each strike, with standard errors, and what its track shows on the way.
//!
//! With G the derivatives of a strike's track by its own launch speed, angle, clock, resting place and friction, its needs are
//! θ = C·GᵀR⁻¹r, C = (GᵀR⁻¹G + P⁻¹)⁻¹, where only clock and resting place have a prior P: no scatter of launches or friction is
//! taken on trust. What is left on the way are scores of a push along and across the heading, BᵀΣ⁻¹r, by fifths of the way.

use nalgebra::{DMatrix, DVector, SMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use values::{Point, Strike};
use world::GRAVITY;

use crate::{
    fit::Fitted,
    mixed::{ANGLE, FRICTION, NUISANCES, SPEED},
    model,
    strikes::PreparedStrikes,
};

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
