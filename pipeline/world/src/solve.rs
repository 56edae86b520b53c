//! The inverse: speed and angle that bring the object from where it rests to a target (paper, algorithm 1).
//!
//! Range goes as speed squared and the world is nearly isotropic, so scaling the speed by the root of the ratio of
//! distances and turning the angle by the error of bearing reaches a millimetre in about two simulations. Where a box's
//! turning or an effect breaks that symmetry a secant estimate of the Jacobian follows (Broyden), each step damped that
//! brought the object no nearer; NLopt's BOBYQA is the fallback that always ends.
//!
//! A box is struck on a face. The friction of the tip bounds the bearings that it can take: beyond, the tip slips and the
//! bearing no longer follows the angle. The bearing at the face's edge then tells that a target is out of reach, in a few
//! simulations. Strikes on the edge itself are not considered: a degree there turns the object by ten, which no arm repeats.

use std::cell::RefCell;

use nlopt::{Algorithm, Nlopt, Target};
use serde::{Deserialize, Serialize};
use values::{Command, Conditions, Interval, Point};

use crate::{Worker, touch};

/// Less than this much bearing for an angle: the tip slips along the face.
const SLIPPING: f64 = 0.25;
/// Angle per bearing for a step back to where it sticks.
const STICKING: f64 = 1.5;
/// Longest step in the logarithm of the speed, and in rad.
const LONGEST: [f64; 2] = [1.0, 0.7];
/// A row is given up when this many simulations on end do not come to rest.
const MOST_DIVERGED: u32 = 4;
/// How many times the miss of a solved row may be left at the end of reach for the search to go on.
const NEARLY: f64 = 3.0;
/// What the corrections bring within this many tolerances is solved; what is further off at a bound is out of reach.
const SOLVED: f64 = 2.0;

/// How a solve goes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolveSettings {
    /// Miss in m at which a solve ends; one that comes within twice that is solved too.
    pub tolerance: f64,
    /// Speeds in m/s that may be tried.
    pub speed: Interval,
    /// Corrections by scaling and Broyden steps before NLopt takes over.
    pub corrections: u32,
    /// Simulations that NLopt may use.
    pub fallback: u32,
}

impl Default for SolveSettings {
    /// 0.5 mm; 0.05–4 m/s; 12 corrections; 25 simulations.
    fn default() -> Self {
        Self {
            tolerance: 0.5e-3,
            speed: Interval {
                low: 0.05,
                high: 4.0,
            },
            corrections: 12,
            fallback: 25,
        }
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolveStatus {
    /// The miss is within twice the tolerance: less than a millimetre by default.
    Solved,
    /// No command within the speeds allowed, on a face of a box, reaches the target; the nearest found is given.
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
    /// What it misses by: logarithm of the distance, and bearing in rad.
    error: [f64; 2],
    miss: f64,
}

impl Trial {
    /// From another trial to this: logarithm of the speed, and angle in rad.
    fn step_from(&self, other: &Trial) -> [f64; 2] {
        [
            (self.command.speed / other.command.speed).ln(),
            self.command.angle - other.command.angle,
        ]
    }
}

/// How the corrections ended.
#[derive(Clone, Copy, PartialEq)]
enum Ending {
    Solved,
    /// The nearest trial lies at a bound, and the target beyond.
    OutOfReach,
    /// Nothing came to rest.
    Diverged,
    /// Neither solved nor known to be out of reach.
    Open,
}

struct Search<'w, 's> {
    worker: &'w mut Worker<'s>,
    initial: Point,
    path: Point,
    conditions: &'w Conditions,
    settings: &'w SolveSettings,
    /// Angles at which the tip meets a face of a box, around the path's bearing; none for a round object.
    face: Option<Interval>,
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
        let reached = stop - self.initial;
        let trial = Trial {
            command,
            error: [
                (self.path.norm() / reached.norm().max(1e-4)).ln(),
                wrap(self.path.bearing() - reached.bearing()),
            ],
            miss: reached.distance(self.path),
        };
        if self.best.is_none_or(|best| trial.miss < best.miss) {
            self.best = Some(trial);
        }
        Some(trial)
    }

    /// The nearest command that may be tried.
    fn within(&self, command: Command) -> Command {
        Command {
            speed: self.settings.speed.clamp(command.speed),
            angle: self
                .face
                .map_or(command.angle, |face| face.clamp(command.angle)),
        }
    }

    /// Whether the best trial is near enough, though not as near as was tried for.
    fn is_solved(&self) -> bool {
        self.best
            .is_some_and(|best| best.miss < SOLVED * self.settings.tolerance)
    }

    /// How far a trial's bearing leads past the target, in tolerances.
    fn astray(&self, trial: &Trial) -> f64 {
        self.path.norm() * trial.error[1].abs() / self.settings.tolerance
    }

    /// The face's edge towards which a trial's bearing is wrong, where that leads away from the face's middle.
    fn edge(&self, trial: &Trial) -> Option<f64> {
        let face = self.face?;
        let is_left = trial.command.angle > 0.5 * (face.low + face.high);
        let is_short = is_left == (trial.error[1] > 0.0);
        is_short.then_some(if is_left { face.high } else { face.low })
    }

    /// Whether a trial at a bound shows that the target lies beyond it.
    fn is_beyond(&self, trial: &Trial) -> bool {
        if self.astray(trial) > SOLVED {
            return self.edge(trial) == Some(trial.command.angle);
        }
        let Interval { low, high } = self.settings.speed;
        let is_off = trial.miss > SOLVED * self.settings.tolerance;
        let at_bound = trial.command.speed >= high && trial.error[0] > 0.0
            || trial.command.speed <= low && trial.error[0] < 0.0;
        is_off && at_bound
    }
}

impl Worker<'_> {
    /// The command that brings an object seen at `initial` to rest at `target` (m), in the session and at the time of
    /// `conditions`. `guess` is where to start, such as a solved neighbour's command. Never fails: what cannot be reached
    /// is a status.
    pub fn solve(
        &mut self,
        initial: Point,
        target: Point,
        conditions: &Conditions,
        settings: &SolveSettings,
        guess: Option<Command>,
    ) -> Solution {
        let path = target - initial;
        let first = guess.unwrap_or_else(|| self.first_guess(path));
        let mut search = Search {
            face: self.face(path, first),
            worker: self,
            initial,
            path,
            conditions,
            settings,
            evaluations: 0,
            best: None,
        };
        match correct(&mut search, first) {
            Ending::Open if search.is_solved() => {}
            Ending::Open => fall_back(&mut search),
            Ending::OutOfReach => {
                come_near(&mut search);
                // Close to where the face ends a few more simulations decide.
                let limit = NEARLY * SOLVED * settings.tolerance;
                if !search.is_solved() && search.best.is_some_and(|best| best.miss < limit) {
                    fall_back(&mut search);
                }
            }
            Ending::Solved | Ending::Diverged => {}
        }
        let evaluations = search.evaluations;
        match search.best {
            None => Solution {
                command: first,
                miss: f64::INFINITY,
                evaluations,
                status: SolveStatus::Diverged,
            },
            Some(Trial { command, miss, .. }) => Solution {
                command: Command {
                    angle: wrap(command.angle),
                    ..command
                },
                miss,
                evaluations,
                status: if miss < SOLVED * settings.tolerance {
                    SolveStatus::Solved
                } else {
                    SolveStatus::Unreachable
                },
            },
        }
    }

    /// Commanded angles, around the path's bearing, at which the tip meets a face of a box.
    fn face(&self, path: Point, first: Command) -> Option<Interval> {
        let rig = self.simulator.rig();
        let (turned, offset) = self.simulator.aim(first);
        let delivered = path.bearing() + turned;
        let face = touch::face(&rig.object, &rig.striker, offset, delivered)?;
        Some(Interval {
            low: face.low - turned,
            high: face.high - turned,
        })
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
/// starts as the isotropic world's (½, 0; 0, 1) and learns by Broyden's update. Each step starts from the best trial.
fn correct(search: &mut Search<'_, '_>, first: Command) -> Ending {
    // The inverse Jacobian: command changes per error in (ln d, bearing).
    let mut inverse = [[0.5, 0.0], [0.0, 1.0]];
    let mut command = search.within(first);
    let mut last: Option<Trial> = None;
    let mut diverged = 0;
    for _ in 0..search.settings.corrections {
        let Some(trial) = search.try_command(command) else {
            diverged += 1;
            if diverged == MOST_DIVERGED {
                break;
            }
            command = match search.best {
                // Half way back to what came to rest, or half as fast.
                Some(best) => Command {
                    speed: (command.speed * best.command.speed).sqrt(),
                    angle: 0.5 * (command.angle + best.command.angle),
                },
                None => search.within(Command {
                    speed: 0.5 * command.speed,
                    ..command
                }),
            };
            continue;
        };
        diverged = 0;
        if trial.miss <= search.settings.tolerance {
            return Ending::Solved;
        }
        if search.is_beyond(&trial) {
            return Ending::OutOfReach;
        }
        let mut is_slipping = false;
        if let Some(last) = last {
            let step = trial.step_from(&last);
            let change = [0, 1].map(|i| last.error[i] - trial.error[i]);
            is_slipping = search.face.is_some()
                && search.astray(&trial) > 1.0
                && change[1].abs() < SLIPPING * step[1].abs();
            if is_slipping {
                // A slope of nothing would lead anywhere: back to where the tip sticks, with some to spare.
                inverse = [[0.5, 0.0], [0.0, STICKING]];
            } else {
                broyden(&mut inverse, step, change);
            }
        }
        last = Some(trial);
        let is_at_edge = search.edge(&trial) == Some(trial.command.angle);
        if is_at_edge && search.is_solved() {
            return Ending::Solved;
        }
        // While the tip slips, the bearing tells nothing of which trial is the better one.
        let best = search
            .best
            .filter(|_| !is_slipping && !is_at_edge)
            .unwrap_or(trial);
        let mut step = [0, 1].map(|i| {
            let wanted = inverse[i][0] * best.error[0] + inverse[i][1] * best.error[1];
            wanted.clamp(-LONGEST[i], LONGEST[i])
        });
        if best.miss < trial.miss {
            let [faster, turned] = trial.step_from(&best);
            let reach = 0.5 * faster.hypot(turned) / step[0].hypot(step[1]).max(1e-300);
            step = step.map(|component| component * reach.min(1.0));
        }
        command = search.within(Command {
            speed: best.command.speed * step[0].exp(),
            angle: best.command.angle + step[1],
        });
        if is_slipping && let Some(edge) = search.edge(&trial) {
            command.angle = edge;
        }
        if command == best.command {
            return Ending::Open;
        }
    }
    if search.best.is_none() {
        Ending::Diverged
    } else {
        Ending::Open
    }
}

/// One more simulation for a target that is out of reach: as far along the best bearing as comes nearest to it.
fn come_near(search: &mut Search<'_, '_>) {
    if let Some(best) = search.best {
        let ratio = best.error[0].exp() * best.error[1].cos();
        let command = search.within(Command {
            speed: best.command.speed * ratio.max(0.0).sqrt(),
            angle: best.command.angle,
        });
        if command != best.command {
            search.try_command(command);
        }
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
fn fall_back(search: &mut Search<'_, '_>) {
    let Some(Trial { command: start, .. }) = search.best else {
        return;
    };
    let (settings, far) = (*search.settings, 10.0 * search.path.norm() + 10.0);
    let mut angle = Interval {
        low: start.angle - 1.2,
        high: start.angle + 1.2,
    };
    if let Some(face) = search.face {
        angle = Interval {
            low: angle.low.max(face.low),
            high: angle.high.min(face.high),
        };
    }
    let shared = RefCell::new(search);
    let miss = |x: &[f64], _: Option<&mut [f64]>, _: &mut ()| {
        let command = Command {
            speed: x[0],
            angle: x[1],
        };
        shared
            .borrow_mut()
            .try_command(command)
            .map_or(far, |trial| trial.miss)
    };
    let mut optimizer = Nlopt::new(Algorithm::Bobyqa, 2, miss, Target::Minimize, ());
    // A bound that NLopt refuses leaves it unbounded; the speeds tried are then refused by the simulation itself.
    let set = optimizer
        .set_lower_bounds(&[settings.speed.low, angle.low])
        .and_then(|_| optimizer.set_upper_bounds(&[settings.speed.high, angle.high]))
        .and_then(|_| optimizer.set_initial_step(&[0.02 * start.speed, 0.02]))
        .and_then(|_| optimizer.set_stopval(settings.tolerance))
        .and_then(|_| optimizer.set_xtol_rel(1e-6))
        .and_then(|_| optimizer.set_maxeval(settings.fallback));
    if set.is_ok() {
        let mut x = [start.speed, start.angle];
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
