//! The inverse: speed and angle that bring the object from where it rests to a target (paper, algorithm 1).
//!
//! Range goes as speed squared and the world is nearly isotropic, so scaling the speed by the root of the ratio of
//! distances and turning the angle by the error of bearing reaches a millimetre in about two simulations. Where effects
//! break that symmetry a secant estimate of the Jacobian follows (Broyden); NLopt's BOBYQA is the fallback that always ends.

use std::cell::RefCell;

use nlopt::{Algorithm, Nlopt, Target};
use serde::{Deserialize, Serialize};
use values::{Command, Conditions, Interval, Point};

use crate::Worker;

/// How a solve goes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolveSettings {
    /// Miss in m at which a solve ends.
    pub tolerance: f64,
    /// Speeds in m/s that may be tried.
    pub speed: Interval,
    /// Corrections by scaling and Broyden steps before NLopt takes over.
    pub corrections: u32,
    /// Simulations that NLopt may use.
    pub fallback: u32,
}

impl Default for SolveSettings {
    /// 0.5 mm; 0.05–4 m/s; 12 corrections; 80 simulations.
    fn default() -> Self {
        Self {
            tolerance: 0.5e-3,
            speed: Interval {
                low: 0.05,
                high: 4.0,
            },
            corrections: 12,
            fallback: 80,
        }
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolveStatus {
    /// The miss is within tolerance.
    Solved,
    /// No command within the speeds allowed reaches the target; the nearest found is given.
    Unreachable,
    /// No simulation of this row came to a finite rest.
    Diverged,
}

impl SolveStatus {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Unreachable => "unreachable",
            Self::Diverged => "diverged",
        }
    }
}

/// What a solve found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Solution {
    /// Speed in m/s and angle in rad.
    pub command: Command,
    /// Distance in m between target and simulated stop; infinite where nothing came to rest.
    pub miss: f64,
    /// Simulations used.
    pub evaluations: u32,
    /// How it ended.
    pub status: SolveStatus,
}

/// One command tried, and where the object stopped.
#[derive(Clone, Copy)]
struct Trial {
    command: Command,
    reached: Point,
    miss: f64,
}

struct Search<'w, 's> {
    worker: &'w mut Worker<'s>,
    initial: Point,
    target: Point,
    conditions: &'w Conditions,
    speed: Interval,
    evaluations: u32,
    best: Option<Trial>,
}

impl Search<'_, '_> {
    fn try_command(&mut self, command: Command) -> Option<Trial> {
        self.evaluations += 1;
        let stop = self
            .worker
            .strike(self.initial, command, self.conditions)
            .ok()?
            .stop;
        let trial = Trial {
            command,
            reached: stop - self.initial,
            miss: stop.distance(self.target),
        };
        if self.best.is_none_or(|best| trial.miss < best.miss) {
            self.best = Some(trial);
        }
        Some(trial)
    }
}

impl Worker<'_> {
    /// The command that brings an object seen at `initial` to rest at `target` (m). `guess` is where to start, such as a
    /// solved neighbour's command. Never fails: what cannot be reached is a status.
    pub fn solve(
        &mut self,
        initial: Point,
        target: Point,
        settings: &SolveSettings,
        guess: Option<Command>,
    ) -> Solution {
        let path = target - initial;
        let first = guess.unwrap_or_else(|| self.first_guess(path));
        let conditions = Conditions::default();
        let mut search = Search {
            worker: self,
            initial,
            target,
            conditions: &conditions,
            speed: settings.speed,
            evaluations: 0,
            best: None,
        };
        correct(&mut search, path, first, settings);
        if search
            .best
            .is_none_or(|best| best.miss > settings.tolerance)
        {
            fall_back(&mut search, path, first, settings);
        }
        let evaluations = search.evaluations;
        match search.best {
            None => Solution {
                command: first,
                miss: f64::INFINITY,
                evaluations,
                status: SolveStatus::Diverged,
            },
            Some(Trial { command, miss, .. }) => {
                let solved = miss <= settings.tolerance;
                let status = if solved {
                    SolveStatus::Solved
                } else {
                    SolveStatus::Unreachable
                };
                Solution {
                    command,
                    miss,
                    evaluations,
                    status,
                }
            }
        }
    }

    /// v = √(2·μ·g·d)/(1 + e), straight at the target.
    fn first_guess(&self, path: Point) -> Command {
        let (friction, restitution) = self.simulator.coefficients();
        let release = (2.0 * friction * 9.81 * path.norm()).sqrt();
        Command {
            speed: release / (1.0 + restitution),
            angle: path.bearing(),
        }
    }
}

/// Polar steps: logarithm of the speed against that of the distance, angle against bearing, with a 2×2 Jacobian that
/// starts as the isotropic world's (½, 0; 0, 1) and learns by Broyden's update.
fn correct(search: &mut Search<'_, '_>, path: Point, first: Command, settings: &SolveSettings) {
    // The inverse Jacobian: command changes per error in (ln d, bearing).
    let mut inverse = [[0.5, 0.0], [0.0, 1.0]];
    let mut command = Command {
        speed: settings.speed.clamp(first.speed),
        angle: first.angle,
    };
    let mut previous: Option<(Command, [f64; 2])> = None;
    let mut stuck_at_bound = 0;
    for _ in 0..settings.corrections {
        let Some(trial) = search.try_command(command) else {
            command.speed *= 0.7;
            previous = None;
            continue;
        };
        if trial.miss <= settings.tolerance {
            return;
        }
        let error = [
            (path.norm() / trial.reached.norm().max(1e-4)).ln(),
            wrap(path.bearing() - trial.reached.bearing()),
        ];
        if let Some((last, last_error)) = previous {
            let step = [
                (command.speed / last.speed).ln(),
                wrap(command.angle - last.angle),
            ];
            let change = [last_error[0] - error[0], last_error[1] - error[1]];
            broyden(&mut inverse, step, change);
        }
        previous = Some((command, error));
        let speed_step = inverse[0][0] * error[0] + inverse[0][1] * error[1];
        let angle_step = inverse[1][0] * error[0] + inverse[1][1] * error[1];
        let wanted = command.speed * speed_step.clamp(-1.0, 1.0).exp();
        let speed = settings.speed.clamp(wanted);
        if speed != wanted {
            stuck_at_bound += 1;
            if stuck_at_bound > 2 {
                return;
            }
        }
        command = Command {
            speed,
            angle: wrap(command.angle + angle_step.clamp(-0.7, 0.7)),
        };
    }
}

/// Broyden's good update of an inverse Jacobian, left out where it would be ill-posed.
fn broyden(inverse: &mut [[f64; 2]; 2], step: [f64; 2], change: [f64; 2]) {
    let predicted = [
        inverse[0][0] * change[0] + inverse[0][1] * change[1],
        inverse[1][0] * change[0] + inverse[1][1] * change[1],
    ];
    let scale = step[0] * predicted[0] + step[1] * predicted[1];
    let size = step[0] * step[0] + step[1] * step[1];
    if scale.abs() < 0.2 * size || size < 1e-14 {
        return;
    }
    let left = [
        step[0] * inverse[0][0] + step[1] * inverse[1][0],
        step[0] * inverse[0][1] + step[1] * inverse[1][1],
    ];
    for row in 0..2 {
        for column in 0..2 {
            inverse[row][column] += (step[row] - predicted[row]) * left[column] / scale;
        }
    }
}

/// The paper's Algorithm 1 as a fallback: NLopt's BOBYQA on the miss, from the best command so far. It always ends.
fn fall_back(search: &mut Search<'_, '_>, path: Point, first: Command, settings: &SolveSettings) {
    let start = search.best.map_or(first, |best| best.command);
    let bounds = search.speed;
    let shared = RefCell::new(search);
    let miss = |x: &[f64], _: Option<&mut [f64]>, _: &mut ()| {
        let command = Command {
            speed: x[0],
            angle: x[1],
        };
        shared
            .borrow_mut()
            .try_command(command)
            .map_or(10.0 * path.norm() + 10.0, |trial| trial.miss)
    };
    let mut optimizer = Nlopt::new(Algorithm::Bobyqa, 2, miss, Target::Minimize, ());
    // A bound that NLopt refuses leaves it unbounded; the speeds tried are then refused by the simulation itself.
    let set = optimizer
        .set_lower_bounds(&[bounds.low, start.angle - 1.2])
        .and_then(|_| optimizer.set_upper_bounds(&[bounds.high, start.angle + 1.2]))
        .and_then(|_| optimizer.set_initial_step(&[0.1 * start.speed, 0.1]))
        .and_then(|_| optimizer.set_stopval(settings.tolerance))
        .and_then(|_| optimizer.set_xtol_rel(1e-6))
        .and_then(|_| optimizer.set_maxeval(settings.fallback));
    if set.is_ok() {
        let mut x = [bounds.clamp(start.speed), start.angle];
        // Success and failure alike leave the best trial in the search.
        let _ = optimizer.optimize(&mut x);
    }
}

/// An angle in (−π, π].
fn wrap(angle: f64) -> f64 {
    let turned = angle.rem_euclid(std::f64::consts::TAU);
    if turned > std::f64::consts::PI {
        turned - std::f64::consts::TAU
    } else {
        turned
    }
}
