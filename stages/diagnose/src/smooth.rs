//! Where: smooth dependences of the gap on each covariate, with no physics assumed.
//!
//! Each is a set of small bumps (over the table, over speed, over strikes …) whose heights are Gaussian with one common
//! standard deviation; the gain in marginal likelihood says how much of the gap goes with that covariate, and what the same
//! heights gain under noise says whether it is real. What is left here after the best effects is what no candidate explains.
//! What is told of a dependence is net of what the model's own values (friction, restitution …) make up for.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use values::{Point, Strike};
use world::{GRAVITY, WorldError, effects::Experiment, planar::Push};

use crate::{
    fit::{Field, Fitted},
    mixed::NUISANCES,
    model::FRICTION,
    score::{Asked, Told},
};

/// What a set of bumps does, and over what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Covariate {
    /// Pushes in both directions, by place on the table.
    Position,
    /// Friction, by place on the table.
    Surface,
    /// Friction, by speed.
    SlidingSpeed,
    /// Pushes in both directions, by time since the blow.
    Phase,
    /// Delivered speed or angle, by what was commanded.
    Speed,
    Angle,
    /// Friction, by the number of strikes before.
    Order,
}

pub(crate) const COVARIATES: [Covariate; 7] = [
    Covariate::Position,
    Covariate::Surface,
    Covariate::SlidingSpeed,
    Covariate::Phase,
    Covariate::Speed,
    Covariate::Angle,
    Covariate::Order,
];

/// What a covariate has to do with the gap.
#[derive(Clone, Debug)]
pub(crate) struct Dependence {
    pub(crate) covariate: Covariate,
    /// Gain in marginal likelihood.
    pub(crate) gain: f64,
    /// Probability of as much by chance.
    pub(crate) p_value: f64,
    /// Where it is strongest (in the covariate's unit; on the table x and y, in m), and how strong there: m/s², relative
    /// friction, relative speed, or rad.
    pub(crate) at: Point,
    pub(crate) peak: Point,
}

/// Distance of bumps on the table in m; their width is the same share of it as for all bumps.
const SPACING: f64 = 0.09;
const WIDTH: f64 = 0.7;
/// Frames within a cell from which a bump stands there.
const FRAMES: usize = 8;
/// Bumps along a line.
const BUMPS: usize = 7;
/// Push in m/s² of the finite differences.
const PUSH: f64 = 0.02;
/// Draws from which chance is known, and common heights tried, relative to each covariate's scale.
const DRAWS: usize = 2000;
const HEIGHTS: [f64; 7] = [0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0];

/// A bump that these strikes see less than this share of the best seen is not spoken of.
const SEEN: f64 = 0.1;

fn bump(distance: f64, spacing: f64) -> f64 {
    (-0.5 * (distance / (WIDTH * spacing)).powi(2)).exp()
}

/// Middles of bumps over a range, and their distance.
fn line(values: impl Iterator<Item = f64>) -> (Vec<f64>, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    let spacing = ((high - low) / (BUMPS - 1) as f64).max(1e-9);
    (
        (0..BUMPS).map(|i| low + spacing * i as f64).collect(),
        spacing,
    )
}

/// Every covariate's dependence at a fitted model.
pub(crate) fn dependences(
    field: &Field<'_>,
    fitted: &Fitted,
    seed: u64,
) -> Result<Vec<Dependence>, WorldError> {
    let Some(asked) = Asked::new(field, fitted, 0, seed) else {
        return Ok(Vec::new());
    };
    let mut found = Vec::new();
    for covariate in COVARIATES {
        let sets = Sets {
            field,
            fitted,
            asked: &asked,
        };
        if let Some((told, places, scale)) = sets.columns(covariate)? {
            let weighed = weigh(covariate, &told, scale, seed);
            let (at, peak) = sets.strongest(covariate, &told, &places, &weighed.heights);
            found.push(Dependence {
                covariate,
                gain: weighed.gain,
                p_value: weighed.p_value,
                at,
                peak,
            });
        }
    }
    Ok(found)
}

struct Sets<'s, 'f, 'a> {
    field: &'f Field<'a>,
    fitted: &'f Fitted,
    asked: &'s Asked<'f, 'a>,
}

/// A bump's place, and the direction in which it pushes.
type Place = (Point, Point);

impl Sets<'_, '_, '_> {
    fn columns(&self, covariate: Covariate) -> Result<Option<(Told, Vec<Place>, f64)>, WorldError> {
        let strikes = &self.field.strikes;
        let (ahead, left) = (Point::new(1.0, 0.0), Point::new(0.0, 1.0));
        let on_line = |(centres, _): &(Vec<f64>, f64), directions: &[Point]| -> Vec<Place> {
            centres
                .iter()
                .flat_map(|c| directions.iter().map(|d| (Point::new(*c, 0.0), *d)))
                .collect()
        };
        Ok(match covariate {
            Covariate::Position | Covariate::Surface => {
                let directions: &[Point] = match covariate {
                    Covariate::Position => &[ahead, left],
                    _ => &[ahead],
                };
                let experiment = Experiment {
                    rig: self.field.rig,
                    strikes,
                };
                let places: Vec<Place> = experiment
                    .cells(SPACING, FRAMES)
                    .into_iter()
                    .flat_map(|c| directions.iter().map(move |d| (c, *d)))
                    .collect();
                let is_surface = covariate == Covariate::Surface;
                let told = self.pushed(&places, &|(centre, direction), _, at, v| {
                    let height = bump(at.distance(centre), SPACING);
                    push(is_surface, direction, v) * height
                })?;
                told.map(|told| (told, places, 0.1))
            }
            Covariate::SlidingSpeed => {
                let speeds = line(
                    [
                        0.0,
                        1.5 * strikes.iter().map(|s| s.command.speed).fold(0.0, f64::max),
                    ]
                    .into_iter(),
                );
                let places = on_line(&speeds, &[ahead]);
                let told = self.pushed(&places, &|(centre, direction), _, _, v| {
                    push(true, direction, v) * bump(v.norm() - centre.x, speeds.1)
                })?;
                told.map(|told| (told, places, 0.1))
            }
            Covariate::Phase => {
                let times = line(strikes.iter().flat_map(|s| s.track.t.iter().copied()));
                let places = on_line(&times, &[ahead, left]);
                let told = self.pushed(&places, &|(centre, direction), t, _, _| {
                    direction * bump(t - centre.x, times.1)
                })?;
                told.map(|told| (told, places, 0.1))
            }
            Covariate::Order => {
                let orders = line(strikes.iter().map(|s| s.conditions.order));
                Some(
                    self.launched(&on_line(&orders, &[ahead, left]), &|i, place: &Place| {
                        bump(strikes[i].conditions.order - place.0.x, orders.1)
                    }),
                )
            }
            Covariate::Speed => {
                let speeds = line(strikes.iter().map(|s| s.command.speed));
                Some(
                    self.launched(&on_line(&speeds, &[ahead, left]), &|i, place: &Place| {
                        bump(strikes[i].command.speed - place.0.x, speeds.1)
                    }),
                )
            }
            Covariate::Angle => {
                let angles = line(strikes.iter().map(|s| s.command.angle));
                Some(
                    self.launched(&on_line(&angles, &[ahead, left]), &|i, place: &Place| {
                        bump(strikes[i].command.angle - place.0.x, angles.1)
                    }),
                )
            }
        })
    }

    /// Columns of pushes: `acceleration(place, time, position, velocity)` at unit height.
    fn pushed(
        &self,
        places: &[Place],
        acceleration: &(dyn Fn(Place, f64, Point, Point) -> Point + Sync),
    ) -> Result<Option<Told>, WorldError> {
        let model = &self.fitted.model;
        let effects = model.effects(self.field.rig, &model.values)?;
        let pushes: Vec<Box<Push<'_>>> = places
            .iter()
            .map(|place| {
                let place = *place;
                Box::new(move |t: f64, at: Point, v: Point| acceleration(place, t, at, v) * PUSH)
                    as Box<Push<'_>>
            })
            .collect();
        let worlds: Vec<_> = pushes
            .iter()
            .map(|push| {
                let mut planar = self.field.planar(&model.values, &effects);
                planar.push = Some(push.as_ref());
                (planar, PUSH)
            })
            .collect();
        let moved = self.asked.moved(&worlds, &|_, _| true);
        Ok(moved.map(|moved| self.asked.tell(places.len(), &moved)))
    }

    /// Columns of launches: speed for a place that points ahead, angle for one that points left.
    fn launched(
        &self,
        places: &[Place],
        height: &(dyn Fn(usize, &Place) -> f64 + Sync),
    ) -> (Told, Vec<Place>, f64) {
        let moved = self.asked.launches(&|i| {
            DMatrix::from_fn(NUISANCES, places.len(), |nuisance, k| {
                let place = &places[k];
                let share = match nuisance {
                    0 => place.1.x,
                    1 => place.1.y,
                    _ => 0.0,
                };
                share * height(i, place)
            })
        });
        let told = self.asked.tell(places.len(), &moved);
        (told, places.to_vec(), 0.01)
    }
}

impl Sets<'_, '_, '_> {
    /// Where a covariate's bumps act most strongly, and how strongly there, net of what the model's own values make up for.
    fn strongest(
        &self,
        covariate: Covariate,
        told: &Told,
        places: &[Place],
        heights: &DVector<f64>,
    ) -> (Point, Point) {
        let change = -told.made_up.tr_mul(heights);
        let spacing = places
            .iter()
            .map(|place| place.0.distance(places[0].0))
            .filter(|distance| *distance > 1e-9)
            .fold(f64::INFINITY, f64::min);
        // Bumps overlap: what acts at the middle of one is a sum over its neighbours.
        let bumps = |at: Point| {
            let each = places.iter().zip(heights.iter());
            each.fold(Point::default(), |sum, (place, height)| {
                sum + place.1 * (*height * bump(at.distance(place.0), spacing))
            })
        };
        let strikes = &self.field.strikes;
        let launched = |of: &dyn Fn(&Strike) -> f64| {
            let made_up = self.asked.as_launches(&change);
            let by_strike: Vec<(f64, Point)> = strikes
                .iter()
                .zip(made_up)
                .map(|(strike, made_up)| {
                    let at = of(strike);
                    (at, bumps(Point::new(at, 0.0)) + made_up)
                })
                .collect();
            move |at: Point| {
                let near = by_strike
                    .iter()
                    .map(|(x, net)| (bump(x - at.x, spacing), *net));
                let (weights, sum) = near.fold((0.0, Point::default()), |(w, s), (weight, net)| {
                    (w + weight, s + net * weight)
                });
                sum * (1.0 / f64::max(weights, 1e-9))
            }
        };
        let slower = GRAVITY * change[FRICTION];
        let ahead = strikes
            .iter()
            .map(|strike| strike.path())
            .map(|path| path * (1.0 / path.norm().max(1e-9)))
            .fold(Point::default(), |sum, p| {
                sum + p * (1.0 / strikes.len() as f64)
            });
        let net: Box<dyn Fn(Point) -> Point> = match covariate {
            Covariate::Position | Covariate::Phase => Box::new(|at| bumps(at) + ahead * -slower),
            Covariate::Surface | Covariate::SlidingSpeed => {
                Box::new(|at| bumps(at) + Point::new(slower, 0.0))
            }
            Covariate::Order => Box::new(launched(&|strike| strike.conditions.order)),
            Covariate::Speed => Box::new(launched(&|strike| strike.command.speed)),
            Covariate::Angle => Box::new(launched(&|strike| strike.command.angle)),
        };
        let seen = told.alone.iter().copied().fold(0.0, f64::max);
        places
            .iter()
            .zip(&told.alone)
            .filter(|(_, alone)| **alone > SEEN * seen)
            .map(|(place, _)| (place.0, net(place.0)))
            .max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()))
            .unwrap_or_default()
    }
}

/// Ahead or to the left on the table; or against the motion.
fn push(is_friction: bool, direction: Point, velocity: Point) -> Point {
    if is_friction {
        velocity * (-1.0 / velocity.norm().max(1e-6))
    } else {
        direction
    }
}

/// What a covariate's bumps gain together.
struct Weighed {
    gain: f64,
    p_value: f64,
    heights: DVector<f64>,
}

/// The best common height, its gain, and what chance would gain.
fn weigh(covariate: Covariate, told: &Told, scale: f64, seed: u64) -> Weighed {
    let SymmetricEigen {
        eigenvalues,
        eigenvectors,
    } = SymmetricEigen::new(told.information.clone());
    let projected = eigenvectors.tr_mul(&told.scores.column(0));
    // In the eigenbasis the scores are independent, of variance λ under noise.
    let modes: Vec<(f64, f64, usize)> = eigenvalues
        .iter()
        .zip(projected.iter())
        .enumerate()
        .filter(|(_, (l, _))| **l > 1e-9)
        .map(|(i, (l, u))| (*l, *u, i))
        .collect();
    let gain = |square: &dyn Fn(usize) -> f64| {
        HEIGHTS
            .iter()
            .map(|height| {
                let variance = (height * scale).powi(2);
                let sum: f64 = modes
                    .iter()
                    .enumerate()
                    .map(|(k, (l, _, _))| {
                        let ratio = l * variance;
                        0.5 * (square(k) * ratio / (1.0 + ratio) - ratio.ln_1p())
                    })
                    .sum();
                (sum, variance)
            })
            .fold(
                (0.0, 0.0),
                |best, tried| {
                    if tried.0 > best.0 { tried } else { best }
                },
            )
    };
    let (best, variance) = gain(&|k| modes[k].1 * modes[k].1 / modes[k].0);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(1_000_000 + covariate as u64);
    let more = (0..DRAWS)
        .filter(|_| {
            let squares: Vec<f64> = modes
                .iter()
                .map(|_| {
                    let z: f64 = StandardNormal.sample(&mut random);
                    z * z
                })
                .collect();
            gain(&|k| squares[k]).0 >= best
        })
        .count();
    let mut heights = DVector::zeros(told.alone.len());
    for (l, u, i) in &modes {
        let share = u * variance / (1.0 + l * variance);
        heights += eigenvectors.column(*i) * share;
    }
    Weighed {
        gain: best,
        p_value: (1.0 + more as f64) / (1.0 + DRAWS as f64),
        heights,
    }
}
