//! Strikes as linear functions of a model's values and of each strike's nuisances, about a point.

use std::{ops::Deref, sync::Arc};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use values::Point;
use world::{
    Release, WorldError,
    effects::{Acts, Effect},
    planar::{Node, Planar, Rate, StartChange},
};

use crate::{
    mixed::{ANGLE, FRICTION, NUISANCES, Products, SPEED},
    model::{self, CLOCK, Model},
    noise::{FrameNoise, Whitening},
    strikes::{Nuisances, PreparedStrikes, measured, stack},
    wander::Path,
};

/// A strike's columns: coordinates in m, all x, then all y.
#[derive(Clone, Debug)]
pub(crate) struct Derivatives {
    /// Derivatives by the strike's nuisances, a column each.
    pub(crate) nuisances: DMatrix<f64>,
    /// Derivatives by the model's values, a column each.
    pub(crate) values: DMatrix<f64>,
}

/// One strike, linearised about a model.
#[derive(Clone, Debug)]
pub(crate) struct Linearised {
    derivatives: Arc<Derivatives>,
    /// Simulated coordinates of its frames, in m: all x, then all y.
    pub(crate) simulated: DVector<f64>,
    /// Measured less simulated coordinates, in m, were the nuisances zero.
    pub(crate) residual: DVector<f64>,
}

/// One strike, linearised about a model and scaled so that its errors are independent: see [`Whitening`].
#[derive(Clone, Debug)]
pub(crate) struct Whitened {
    derivatives: Arc<Derivatives>,
    pub(crate) residual: DVector<f64>,
}

impl Deref for Linearised {
    type Target = Derivatives;

    fn deref(&self) -> &Derivatives {
        &self.derivatives
    }
}

impl Deref for Whitened {
    type Target = Derivatives;

    fn deref(&self) -> &Derivatives {
        &self.derivatives
    }
}

/// All strikes, linearised about a model.
#[derive(Clone, Debug, Default)]
pub(crate) struct Linearisation {
    /// Each strike as simulated, before whitening; shared by linearisations that differ in noise alone.
    pub(crate) raw: Arc<Vec<Linearised>>,
    pub(crate) whitened: Vec<Whitened>,
    pub(crate) products: Vec<Products>,
}

impl Linearisation {
    /// Whitens linearised strikes by their noise, and sums up their products.
    pub(crate) fn new(prepared: &PreparedStrikes<'_>, raw: Arc<Vec<Linearised>>) -> Self {
        let (whitened, products) = raw
            .par_iter()
            .zip(&prepared.whitenings)
            .zip(&prepared.paths)
            .map(|((raw, whitening), path)| {
                let whitened = raw.whitened(whitening);
                let products = whitened.products(whitening, path);
                (whitened, products)
            })
            .unzip();
        Self {
            raw,
            whitened,
            products,
        }
    }

    /// The linearisation of a model at moved values: strikes are simulated there, derivatives kept from here. `None` where a strike does not come to
    /// rest.
    pub(crate) fn moved(
        &self,
        prepared: &PreparedStrikes<'_>,
        model: &Model,
        nuisances: &[Nuisances],
    ) -> Result<Option<Self>, WorldError> {
        let effects = model.effects(prepared.rig, &model.values)?;
        let planar = prepared.planar(&model.values, &effects);
        let clock = model.values[CLOCK];
        let of_strike = |i: usize| {
            let (b, from) = (&nuisances[i], &self.raw[i]);
            let simulated = stack(&prepared.simulate(&planar, i, clock, b)?.at);
            let raw = Linearised {
                residual: measured(prepared.strikes[i]) - &simulated + &from.nuisances * b,
                derivatives: Arc::clone(&from.derivatives),
                simulated,
            };
            let whitened = Whitened {
                derivatives: Arc::clone(&self.whitened[i].derivatives),
                residual: prepared.whitenings[i].column(&raw.residual),
            };
            let (g, x) = (&whitened.nuisances, &whitened.values);
            let products = self.products[i].beside(g, x, &[], &whitened.residual);
            Some((raw, whitened, products))
        };
        let strikes = (0..prepared.strikes.len()).into_par_iter();
        let found: Option<Vec<_>> = strikes.map(of_strike).collect();
        Ok(found.map(|found| {
            let mut moved = Self::default();
            let mut all = Vec::with_capacity(found.len());
            for (raw, whitened, products) in found {
                all.push(raw);
                moved.whitened.push(whitened);
                moved.products.push(products);
            }
            moved.raw = all.into();
            moved
        }))
    }

    /// The linearisation of some of the strikes, not whitened yet.
    pub(crate) fn only(&self, places: &[usize]) -> Self {
        let raw: Vec<_> = places.iter().map(|i| self.raw[*i].clone()).collect();
        Self {
            raw: Arc::new(raw),
            ..Self::default()
        }
    }
}

/// Products of all strikes under other noise.
pub(crate) fn products_under(
    prepared: &PreparedStrikes<'_>,
    raw: &[Linearised],
    noise: FrameNoise,
) -> Vec<Products> {
    raw.par_iter()
        .zip(&prepared.frames)
        .zip(&prepared.paths)
        .map(|((raw, frames), path)| {
            let whitening = Whitening::new(frames, noise);
            raw.whitened(&whitening).products(&whitening, path)
        })
        .collect()
}

/// A model's effects, and its effects with each of its values a step away.
struct Effects {
    here: Vec<Box<dyn Effect>>,
    beside: Vec<Stepped>,
}

/// A model's values, one of them a step away, and its effects there.
struct Stepped {
    values: Vec<f64>,
    effects: Vec<Box<dyn Effect>>,
    step: f64,
}

impl Effects {
    fn of(prepared: &PreparedStrikes<'_>, model: &Model) -> Result<Self, WorldError> {
        let beside = model.free.iter().enumerate().map(|(place, free)| {
            let mut values = model.values.clone();
            let step = if values[place] + free.step > free.high {
                -free.step
            } else {
                free.step
            };
            values[place] += step;
            Ok(Stepped {
                effects: model.effects(prepared.rig, &values)?,
                values,
                step,
            })
        });
        Ok(Self {
            beside: beside.collect::<Result<_, WorldError>>()?,
            here: model.effects(prepared.rig, &model.values)?,
        })
    }
}

/// How the derivative of a track by one of a model's values is computed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Source {
    /// By the velocity at each frame.
    Clock,
    /// By the change of the launch, times the track's derivatives by the launch.
    Launch,
    /// By the change of a friction that is constant during a slide, times the track's derivative by it; by a second slide where a force is constant.
    Even,
    /// By the difference to a second simulated slide.
    Slide,
}

/// A model's world, and the worlds with each of its values a step away.
struct Worlds<'w, 'a> {
    prepared: &'w PreparedStrikes<'a>,
    here: Planar<'w>,
    beside: Vec<(Planar<'w>, Source, f64)>,
    clock: f64,
}

impl<'w, 'a> Worlds<'w, 'a> {
    fn new(prepared: &'w PreparedStrikes<'a>, model: &Model, effects: &'w Effects) -> Self {
        let source = |place: usize| match (&model.free[place].of, place) {
            (_, CLOCK) => Source::Clock,
            (None, model::FRICTION) => Source::Even,
            (None, model::LOAD_SHIFT) => Source::Slide,
            (None, _) => Source::Launch,
            (Some((part, _)), _) => match effects.here[*part].acts() {
                Acts::Launch => Source::Launch,
                Acts::Strike => Source::Even,
                Acts::Slide | Acts::Camera => Source::Slide,
            },
        };
        let beside = effects.beside.iter().enumerate();
        Self {
            prepared,
            here: prepared.planar(&model.values, &effects.here),
            beside: beside
                .map(|(place, at)| {
                    (
                        prepared.planar(&at.values, &at.effects),
                        source(place),
                        at.step,
                    )
                })
                .collect(),
            clock: model.values[CLOCK],
        }
    }

    /// One strike; `None` where it does not come to rest.
    fn linearised(&self, i: usize, b: &Nuisances) -> Option<Linearised> {
        let prepared = self.prepared;
        let (input, launch) = (prepared.strikes[i].into(), &prepared.launches[i]);
        let conditions = &prepared.strikes[i].conditions;
        let (dry, force) = self.here.even(conditions);
        let release = self.here.release(&input, launch);
        let sources: Vec<Beside> = self
            .beside
            .iter()
            .map(|(planar, source, step)| match source {
                Source::Clock => Beside::Clock,
                Source::Launch => Beside::Launch(Launched::between(
                    &release,
                    &planar.release(&input, launch),
                    *step,
                )),
                Source::Even => match planar.even(conditions) {
                    // No share of no friction is some.
                    (other, same) if same == force && dry > 0.0 => {
                        Beside::Friction((other / dry).ln() / step)
                    }
                    _ => Beside::Slide,
                },
                Source::Slide => Beside::Slide,
            })
            .collect();
        let response = prepared.response(&self.here, i, release, self.clock, b, f64::INFINITY)?;
        let simulated = stack(&response.frames.at);
        let rate = stack(&response.frames.rate);
        let n = response.frames.at.len();
        let started = |start: StartChange, column: &mut [f64]| {
            response.answer(start, &|_| Rate::default(), column);
        };
        let mut nuisances = DMatrix::zeros(2 * n, NUISANCES);
        started(
            response.faster(),
            nuisances.column_mut(SPEED).as_mut_slice(),
        );
        started(
            response.turned(),
            nuisances.column_mut(ANGLE).as_mut_slice(),
        );
        let mut by_friction = nuisances.column_mut(FRICTION);
        response.answer(
            StartChange::default(),
            &Node::friction,
            by_friction.as_mut_slice(),
        );
        nuisances.set_column(2, &rate);
        nuisances.view_mut((0, 3), (n, 1)).fill(1.0);
        nuisances.view_mut((n, 4), (n, 1)).fill(1.0);
        let is_spun = |source: &Beside| matches!(source, Beside::Launch(l) if l.spin != 0.0);
        let mut spin = DVector::zeros(2 * n);
        if sources.iter().any(is_spun) {
            started(response.spun(), spin.as_mut_slice());
        }
        let mut values = DMatrix::zeros(2 * n, sources.len());
        for (place, (source, (planar, _, step))) in sources.iter().zip(&self.beside).enumerate() {
            let mut column = values.column_mut(place);
            match source {
                Beside::Clock => column.copy_from(&rate),
                Beside::Friction(share) => {
                    column.axpy(*share, &nuisances.column(FRICTION), 0.0);
                }
                Beside::Launch(launched) => {
                    column.axpy(launched.speed, &nuisances.column(SPEED), 0.0);
                    column.axpy(launched.angle, &nuisances.column(ANGLE), 1.0);
                    column.axpy(-launched.time, &rate, 1.0);
                    column.axpy(launched.spin, &spin, 1.0);
                    column.rows_mut(0, n).add_scalar_mut(launched.position.x);
                    column.rows_mut(n, n).add_scalar_mut(launched.position.y);
                }
                Beside::Slide => {
                    prepared.answer_of(&response, planar, i, self.clock, b, column.as_mut_slice());
                    column /= *step;
                }
            }
        }
        let derivatives = Arc::new(Derivatives { nuisances, values });
        Some(Linearised {
            residual: measured(prepared.strikes[i]) - &simulated + &derivatives.nuisances * b,
            derivatives,
            simulated,
        })
    }
}

/// How one strike's derivative by one of the model's values is computed.
enum Beside {
    Clock,
    Launch(Launched),
    /// Change of the logarithm of its friction.
    Friction(f64),
    Slide,
}

/// Derivative of how the object leaves the tip by one of a model's values.
struct Launched {
    /// Derivatives of the logarithm of the launch speed, and of the launch angle (rad).
    speed: f64,
    angle: f64,
    /// Derivatives of time (s), position (m) and spin (rad/s) that the change of speed and angle does not explain.
    time: f64,
    position: Point,
    spin: f64,
}

impl Launched {
    fn between(from: &Release, to: &Release, step: f64) -> Self {
        let (a, b) = (from.velocity, to.velocity);
        let faster = b.norm() / a.norm();
        let angle = (a.x * b.y - a.y * b.x).atan2(a.dot(b));
        Self {
            speed: faster.ln() / step,
            angle: angle / step,
            time: (to.time - from.time) / step,
            position: (to.position - from.position.rotated(angle)) * step.recip(),
            spin: (to.spin - from.spin * faster) / step,
        }
    }
}

impl Linearised {
    /// Every strike about a model; `None` where one does not come to rest.
    pub(crate) fn all(
        prepared: &PreparedStrikes<'_>,
        model: &Model,
        nuisances: &[Nuisances],
    ) -> Result<Option<Vec<Self>>, WorldError> {
        let effects = Effects::of(prepared, model)?;
        let worlds = Worlds::new(prepared, model, &effects);
        Ok((0..prepared.strikes.len())
            .into_par_iter()
            .map(|i| worlds.linearised(i, &nuisances[i]))
            .collect())
    }

    /// Speed of the simulated object at each frame, in m/s.
    pub(crate) fn speeds(&self) -> Vec<f64> {
        // The clock's column is the frames' rate of change.
        let n = self.simulated.len() / 2;
        let rate = self.values.column(CLOCK);
        (0..n).map(|k| rate[k].hypot(rate[n + k])).collect()
    }

    /// This strike scaled so that its errors are independent.
    pub(crate) fn whitened(&self, whitening: &Whitening) -> Whitened {
        Whitened {
            derivatives: Arc::new(Derivatives {
                nuisances: whitening.columns(&self.nuisances),
                values: whitening.columns(&self.values),
            }),
            residual: whitening.column(&self.residual),
        }
    }
}

impl Whitened {
    /// All that a fit needs of a strike.
    pub(crate) fn products(&self, whitening: &Whitening, path: &Path) -> Products {
        Products::new(
            &self.nuisances,
            &self.values,
            &self.residual,
            whitening,
            path,
        )
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use values::{Command, Conditions, End, Rig, Shape, Split, Strike, Track};
    use world::{
        World,
        launch::{Launch, launches},
    };

    use super::*;
    use crate::{Thresholds, model::Part};

    fn strike(i: u32) -> Strike {
        let times: Vec<f64> = (1..=60).map(|k| f64::from(k) / 60.0).collect();
        Strike {
            id: i.to_string(),
            log: "a.mcap".into(),
            index: 0,
            t_start: 0.0,
            initial: Point::new(0.3, 0.02 * f64::from(i)),
            stop: Point::new(0.9, 0.1),
            command: Command {
                speed: 0.6 + 0.1 * f64::from(i),
                angle: 0.05 * f64::from(i),
            },
            track: Track {
                x: vec![0.0; times.len()],
                y: vec![0.0; times.len()],
                t: times,
                yaw: None,
                end: End::Rest,
            },
            split: Split::Train,
            conditions: Conditions {
                order: f64::from(i),
                ..Conditions::default()
            },
            delivered: None,
        }
    }

    fn part(name: &'static str, parameters: &[(&str, f64)], free: &[&str]) -> Part {
        let parameters = parameters.iter();
        Part {
            name,
            parameters: parameters.map(|(n, v)| (n.to_string(), *v)).collect(),
            free: free.iter().map(|name| name.to_string()).collect(),
            strengths: Vec::new(),
            within: BTreeMap::new(),
            shrinks_to: None,
        }
    }

    fn launched(rig: &Rig, world: &World, strikes: &[Strike]) -> Vec<Launch> {
        launches(rig, world, strikes.iter().map(Strike::commanded))
            .expect("a world")
            .into_iter()
            .map(|launch| launch.expect("it leaves the tip"))
            .collect()
    }

    #[test]
    fn derivatives_are_those_of_whole_slides() {
        for shape in [Shape::Cylinder, Shape::Box] {
            let rig = Rig::demo(shape);
            let world = World::nominal();
            let strikes: Vec<Strike> = (0..4).map(strike).collect();
            let launches = launched(&rig, &world, &strikes);
            let thresholds = Thresholds::default();
            let prepared =
                PreparedStrikes::new(&rig, strikes.iter().collect(), launches, &thresholds);
            let model = Model::plain(0.25, 0.5, &rig, &thresholds)
                .with(part("striker_speed_error", &[("slope", 1.1)], &["slope"]))
                .with(part(
                    "off_centre_contact",
                    &[("offset", 0.002)],
                    &["offset"],
                ))
                .with(part("friction_drift", &[("rate", 0.01)], &["rate"]))
                .with(part(
                    "table_tilt",
                    &[("tilt_x", 0.004)],
                    &["tilt_x", "tilt_y"],
                ))
                .with(part("viscous_drag", &[("rate", 0.2)], &["rate"]));
            let none = vec![Nuisances::zeros(); strikes.len()];
            let all = Linearised::all(&prepared, &model, &none)
                .expect("a model")
                .expect("objects come to rest");
            let track = |values: &[f64], i: usize| {
                let effects = model.effects(&rig, values).expect("effects");
                let planar = prepared.planar(values, &effects);
                let frames = prepared.simulate(&planar, i, values[CLOCK], &none[i]);
                stack(&frames.expect("it comes to rest").at)
            };
            for (i, linearised) in all.iter().enumerate() {
                for (place, free) in model.free.iter().enumerate() {
                    let at = |step: f64| {
                        let mut values = model.values.clone();
                        values[place] += step;
                        track(&values, i)
                    };
                    let step = 0.2 * free.step;
                    let whole = (at(step) - at(-step)) / (2.0 * step);
                    let found = linearised.values.column(place);
                    let off = (found - &whole).norm() / whole.norm().max(1e-3);
                    assert!(off < 0.03, "{shape:?} {:?} of strike {i}: {off}", free.of);
                }
            }
        }
    }

    #[test]
    fn a_table_without_friction_has_derivatives() {
        let rig = Rig::demo(Shape::Cylinder);
        let world = World::nominal().with("friction", 0.0);
        let met = |i| {
            let mut strike = strike(i);
            strike.track.end = End::Contact;
            strike
        };
        let strikes: Vec<Strike> = (0..3).map(met).collect();
        let launches = launched(&rig, &world, &strikes);
        let thresholds = Thresholds::default();
        let prepared = PreparedStrikes::new(&rig, strikes.iter().collect(), launches, &thresholds);
        let model = Model::plain(0.0, 0.5, &rig, &thresholds);
        let none = vec![Nuisances::zeros(); strikes.len()];
        let all = Linearised::all(&prepared, &model, &none)
            .expect("a model")
            .expect("tracks that end need no rest");
        for linearised in &all {
            assert!(linearised.values.iter().all(|value| value.is_finite()));
            let by_friction = linearised.values.column(model::FRICTION);
            assert!(by_friction.norm() > 1.0, "{by_friction}");
        }
    }
}
