//! What the first few strikes of a new session say of it.
//!
//! Sessions are draws from a population (a mean and a scatter). A few strikes measure the new one's own value; the estimate
//! is drawn towards the mean the more, the fewer and the noisier they are (shrinkage, as in mixed models: Laird and Ware
//! 1982). Each strike has its own launch, clock, friction and resting place, whose scatter the world knows: the residual
//! r = C·d + G·b + noise, d the session's values, b the strike's own, is solved by Gauss–Newton for the most likely d.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use values::{Conditions, Point, Rig, Strike};

use crate::{
    Estimate, World, WorldError,
    effects::{self, Effect},
    launch::{Launch, launches},
    planar::{Deviation, Frames, Planar, StrikeInput},
};

/// Steps of the differences: relative speed, angle in rad, relative friction.
const STEPS: [f64; 3] = [0.004, 0.004, 0.01];
/// Step of a session's value, as a share of its scale.
const STEP: f64 = 0.1;
/// Gauss–Newton steps: two reach a value that is half of the launch's off, and one more shows it.
const ITERATIONS: usize = 4;
/// Frames by which a clock may be late.
const CLOCK: f64 = 2.0;
/// Independent frames that a resting place is measured by.
const REST: f64 = 10.0;
/// Least camera noise in m: no camera sees a centroid better.
const LEAST_NOISE: f64 = 1e-4;
/// Standard errors within which 95 % lie.
const NINETY_FIVE: f64 = 1.96;

/// What is known of one effect in the session that these strikes begin.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionValue {
    /// The effect.
    pub effect: String,
    /// Its value in this session with its 95 % interval, in the parameter's unit.
    pub estimate: Estimate,
}

/// A strike's own: launch speed, angle, friction, clock, resting place.
const OWN: usize = 6;

struct Columns {
    /// Measured less simulated, as if the strike's own were none.
    residual: DVector<f64>,
    /// By the strike's own, and by the session's values.
    own: DMatrix<f64>,
    session: DMatrix<f64>,
}

/// The values of a world's effects by session, in the session that `strikes` begin; their own session's name counts for
/// nothing. `order`: strikes that were made before them. Without strikes that can be used, the population's.
///
/// # Errors
/// A world that does not compile for the rig.
pub fn recent_session(
    rig: &Rig,
    world: &World,
    strikes: &[Strike],
    order: f64,
) -> Result<Vec<SessionValue>, WorldError> {
    let frame = 1.0 / rig.camera.rate;
    let usable: Vec<Strike> = strikes
        .iter()
        .zip(0_u32..)
        .map(|(strike, i)| Strike {
            conditions: Conditions {
                session: effects::UNKNOWN.into(),
                order: order + f64::from(i),
                yaw: strike.conditions.yaw,
            },
            ..strike.after_impact(frame)
        })
        .filter(|strike| strike.track.len() >= OWN && !strike.track.is_pushed_again())
        .collect();
    let launches = launches(rig, world, usable.iter().map(Strike::commanded))?;
    let struck: Vec<(Strike, Launch)> = usable
        .into_iter()
        .zip(launches)
        .filter_map(|(strike, launch)| Some((strike, launch?)))
        .collect();
    let populations: Vec<_> = world.sessions.iter().collect();
    let count = populations.len();
    let mut values = DVector::from_fn(count, |k, _| populations[k].1.mean);
    let means = values.clone();
    let prior = DVector::from_fn(count, |k, _| populations[k].1.next().max(1e-9).powi(-2));
    let mut precision = DMatrix::from_diagonal(&prior);
    let mut own = vec![DVector::zeros(OWN); struck.len()];
    for _ in 0..ITERATIONS {
        let session = Session::at(rig, world, &values)?;
        let found: Vec<Option<Columns>> = struck
            .par_iter()
            .zip(&own)
            .map(|((strike, launch), own)| session.columns(strike, launch, own))
            .collect();
        precision = DMatrix::from_diagonal(&prior);
        let mut score = (&means - &values).component_mul(&prior);
        for columns in found.iter().flatten() {
            let (information, gradient) = session.information(columns);
            precision += information;
            score += gradient;
        }
        let Some(step) = precision.clone().cholesky().map(|c| c.solve(&score)) else {
            break;
        };
        for (own, columns) in own.iter_mut().zip(&found) {
            if let Some(columns) = columns {
                *own = session.own(columns, &step);
            }
        }
        values += step;
        for (value, (name, _)) in values.iter_mut().zip(&populations) {
            if let Some(p) = effects::effect(name)?.parameter(effects::UNKNOWN) {
                *value = value.clamp(p.low, p.high);
            }
        }
    }
    let covariance = precision.try_inverse().unwrap_or_default();
    Ok(populations
        .iter()
        .enumerate()
        .map(|(k, (name, _))| {
            let by = NINETY_FIVE * covariance.get((k, k)).map_or(0.0, |v| v.max(0.0).sqrt());
            let value = values[k];
            SessionValue {
                effect: (*name).clone(),
                estimate: Estimate::with_interval(value, value - by, value + by),
            }
        })
        .collect())
}

type Effects = Vec<Box<dyn Effect>>;

/// A world at values of the session, and a step before and after each. Differences are central: a session's friction and a
/// strike's own do the same, and the bend of the track would distinguish them.
struct Session {
    world: World,
    frame: f64,
    base: crate::Base,
    gyration: f64,
    here: Effects,
    beside: Vec<([Effects; 2], f64)>,
}

impl Session {
    fn at(rig: &Rig, world: &World, values: &DVector<f64>) -> Result<Self, WorldError> {
        let mut here = world.clone();
        for (name, value) in world.sessions.keys().zip(values.iter()) {
            here = here.with_unknown_sessions(name, *value);
        }
        let built = |world: &World| -> Result<Effects, WorldError> {
            let effects = world.effects.iter();
            effects.map(|added| effects::build(added, rig)).collect()
        };
        let mut beside = Vec::new();
        for (name, value) in world.sessions.keys().zip(values.iter()) {
            let scale = effects::effect(name)?
                .parameter(effects::UNKNOWN)
                .map_or(1.0, |parameter| parameter.scale);
            let step = STEP * scale;
            let moved = |by: f64| built(&here.clone().with_unknown_sessions(name, value + by));
            beside.push(([moved(-step)?, moved(step)?], step));
        }
        Ok(Self {
            here: built(&here)?,
            beside,
            base: crate::Base::new(rig, world)?,
            gyration: crate::planar::gyration(rig) * world.value("inertia_z")?,
            frame: 1.0 / rig.camera.rate,
            world: here,
        })
    }

    fn planar<'e>(&self, effects: &'e [Box<dyn Effect>]) -> Option<Planar<'e>> {
        let world = &self.world;
        let coefficients = [
            world.value("friction").ok()?,
            world.value("restitution").ok()?,
        ];
        Some(Planar::of(coefficients, self.base, self.gyration, effects))
    }

    fn columns(&self, strike: &Strike, launch: &Launch, own: &DVector<f64>) -> Option<Columns> {
        let input = StrikeInput::from(strike);
        let here = self.planar(&self.here)?;
        let frames = |planar: &Planar<'_>, own: &DVector<f64>| -> Option<Frames> {
            let deviation = Deviation {
                speed: own[0],
                angle: own[1],
                friction: own[2],
                delay: 0.5 * self.frame + own[3],
                rest: Point::new(own[4], own[5]),
            };
            planar.strike(&input, launch, &deviation)
        };
        let at = frames(&here, own)?;
        let now = stack(&at.at);
        let n = at.at.len();
        let mut columns = DMatrix::zeros(2 * n, OWN);
        for (place, step) in STEPS.iter().enumerate() {
            let moved = |by: f64| {
                let mut moved = own.clone();
                moved[place] += by;
                Some(stack(&frames(&here, &moved)?.at))
            };
            let column = (moved(*step)? - moved(-step)?) / (2.0 * step);
            columns.set_column(place, &column);
        }
        columns.set_column(3, &stack(&at.rate));
        columns.view_mut((0, 4), (n, 1)).fill(1.0);
        columns.view_mut((n, 5), (n, 1)).fill(1.0);
        let mut session = DMatrix::zeros(2 * n, self.beside.len());
        for (place, ([before, after], step)) in self.beside.iter().enumerate() {
            let seen = |effects| Some(stack(&frames(&self.planar(effects)?, own)?.at));
            let column = (seen(after)? - seen(before)?) / (2.0 * step);
            session.set_column(place, &column);
        }
        let track = &strike.track;
        let measured = DVector::from_iterator(2 * n, track.x.iter().chain(&track.y).copied());
        Some(Columns {
            residual: measured - now + &columns * own,
            own: columns,
            session,
        })
    }

    /// Variances of a strike's own, and of a frame: correlated frames hold as much information as fewer independent ones.
    fn variances(&self) -> (DVector<f64>, f64) {
        let scatter = &self.world.scatter;
        let correlation = scatter.camera_correlation.clamp(0.0, 0.97);
        let camera = scatter.camera.max(LEAST_NOISE).powi(2);
        let inflation = (1.0 + correlation) / (1.0 - correlation);
        let rest = camera * (inflation / REST).min(1.0);
        let own = [
            scatter.speed.powi(2),
            scatter.angle.powi(2),
            scatter.friction.powi(2),
            (CLOCK * self.frame).powi(2),
            rest,
            rest,
        ];
        (DVector::from_row_slice(&own), camera * inflation)
    }

    /// (GᵀG + σ²·P⁻¹)⁻¹·Gᵀ·M, which is what M says of the strike's own.
    fn of_own(&self, columns: &Columns, m: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let (own, camera) = self.variances();
        let mut normal = columns.own.tr_mul(&columns.own);
        for (i, variance) in own.iter().enumerate() {
            normal[(i, i)] += camera / variance.max(1e-18);
        }
        Some(normal.cholesky()?.solve(&columns.own.tr_mul(m)))
    }

    /// CᵀΣ⁻¹C and CᵀΣ⁻¹r of one strike.
    fn information(&self, columns: &Columns) -> (DMatrix<f64>, DVector<f64>) {
        let (_, camera) = self.variances();
        let count = columns.session.ncols();
        let mut both = columns.session.clone().insert_column(count, 0.0);
        both.set_column(count, &columns.residual);
        let Some(own) = self.of_own(columns, &both) else {
            return (DMatrix::zeros(count, count), DVector::zeros(count));
        };
        let left = (&both - &columns.own * own) / camera;
        let products = columns.session.tr_mul(&left);
        (
            products.columns(0, count).into_owned(),
            products.column(count).into_owned(),
        )
    }

    /// The strike's own, once the session's values moved by `step`.
    fn own(&self, columns: &Columns, step: &DVector<f64>) -> DVector<f64> {
        let residual = &columns.residual - &columns.session * step;
        let residual = DMatrix::from_column_slice(residual.len(), 1, residual.as_slice());
        self.of_own(columns, &residual)
            .map_or_else(|| DVector::zeros(OWN), |own| own.column(0).into_owned())
    }
}

/// All x, then all y.
fn stack(points: &[Point]) -> DVector<f64> {
    let x = points.iter().map(|p| p.x);
    DVector::from_iterator(2 * points.len(), x.chain(points.iter().map(|p| p.y)))
}

#[cfg(test)]
mod tests {
    use values::{Command, Shape, Track};

    use super::*;
    use crate::{AddedEffect, Scatter, Simulator};

    fn world() -> World {
        let mut world = World::nominal(&Rig::demo(Shape::Cylinder)).with("friction", 0.22);
        world.scatter = Scatter {
            speed: 0.02,
            angle: 0.008,
            camera: 0.7e-3,
            ..Scatter::default()
        };
        let changes = [("a.mcap", 0.12), ("b.mcap", -0.12)];
        world.effects.push(AddedEffect {
            name: "friction_by_session".into(),
            parameters: changes
                .map(|(name, value)| (name.to_string(), Estimate::fixed(value)))
                .into(),
        });
        world.with_populations()
    }

    /// Strikes in a session of this change of friction, whose launches are off by a few per cent.
    fn strikes(rig: &Rig, change: f64, count: usize) -> Vec<Strike> {
        let there = world().with_unknown_sessions("friction_by_session", change);
        let simulator = Simulator::new(rig, &there).expect("a valid world");
        let mut worker = simulator.worker();
        (0..count)
            .map(|i| {
                let share = i as f64 / count.max(1) as f64;
                let command = Command {
                    speed: 0.6 + 0.3 * share,
                    angle: 0.2 - 0.3 * share,
                };
                let delivered = Command {
                    speed: command.speed * (1.0 + 0.03 * (2.0 + 5.0 * i as f64).sin()),
                    ..command
                };
                let initial = Point::new(0.3, 0.0);
                let simulated = worker
                    .strike(initial, delivered, &Conditions::default())
                    .expect("rests");
                let mut track = Track::default();
                for frame in 1..200 {
                    let t = f64::from(frame) / rig.camera.rate;
                    let at = simulated.at(t);
                    // A little noise that is the same each time.
                    let noise = 0.4e-3 * (f64::from(frame) * 12.9 + i as f64).sin();
                    track.t.push(t);
                    track.x.push(at.x + noise);
                    track.y.push(at.y - noise);
                    if t > simulated.rest_time {
                        break;
                    }
                }
                Strike {
                    id: String::new(),
                    log: "new.mcap".into(),
                    index: i as u32,
                    t_start: 0.0,
                    initial,
                    stop: simulated.stop,
                    command,
                    delivered: None,
                    track,
                    split: values::Split::Train,
                    conditions: Conditions {
                        session: "new.mcap".into(),
                        ..Conditions::default()
                    },
                }
            })
            .collect()
    }

    fn value(rig: &Rig, strikes: &[Strike]) -> (f64, f64) {
        let found = recent_session(rig, &world(), strikes, 0.0).expect("a valid world");
        let [SessionValue { estimate, .. }] = &found[..] else {
            panic!("{found:?}");
        };
        let ends = estimate.high.expect("an end") - estimate.low.expect("an end");
        (estimate.value, ends)
    }

    #[test]
    fn without_strikes_it_is_the_population_and_a_few_find_its_own() {
        let rig = Rig::demo(Shape::Cylinder);
        let (mean, wide) = value(&rig, &[]);
        let next = world().sessions["friction_by_session"].next();
        assert!(mean.abs() < 1e-9 && (wide / (2.0 * NINETY_FIVE * next) - 1.0).abs() < 1e-6);
        let (own, narrow) = value(&rig, &strikes(&rig, -0.1, 4));
        assert!((own + 0.1).abs() < 0.015, "{own}");
        assert!(narrow < 0.2 * wide, "{narrow} {wide}");
    }

    #[test]
    fn one_noisy_strike_is_drawn_to_the_mean() {
        let rig = Rig::demo(Shape::Cylinder);
        let struck = strikes(&rig, -0.1, 1);
        let mut noisy = world();
        noisy.scatter.friction = 0.2;
        let found = recent_session(&rig, &noisy, &struck, 0.0).expect("a valid world");
        let drawn = found[0].estimate.value;
        assert!((-0.07..-0.02).contains(&drawn), "{drawn}");
    }
}
