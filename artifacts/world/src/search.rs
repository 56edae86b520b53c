//! The search for the command that leads along a path, in whichever world answers where a command leads.
//!
//! Range goes as speed squared and the world is nearly isotropic, so scaling the speed by the root of the ratio of
//! distances and turning the angle by the error of bearing comes near in two trials. Where a box's turning or an effect
//! breaks that symmetry a secant estimate of the Jacobian follows (Broyden), each step damped that brought the object no
//! nearer; NLopt's BOBYQA is the fallback that always ends.
//!
//! A box is struck on a face. The friction of the tip bounds the bearings that it can take: beyond, the tip slips and the
//! bearing no longer follows the angle. The bearing at the face's edge then shows that a target is out of reach, in a few
//! trials. Strikes on the edge itself are not considered: a degree there turns the object by ten, which no arm repeats.

use std::cell::RefCell;

use nlopt::{Algorithm, Nlopt, Target};
use values::{Command, Interval, Point};

use crate::solution::{SOLVED, SolveSettings};

/// Change of bearing for a change of angle below which the tip slips along the face.
const SLIPPING: f64 = 0.25;
/// Change of the distance's logarithm for a change of the speed's, below which the arm saturates; twice which a free arm gives.
const SATURATED: f64 = 0.1;
/// Change of angle for a change of bearing in a step back to where the tip sticks.
const STICKING: f64 = 1.5;
/// Step in the logarithm of the speed, for a slope by differences.
const LEAST_STEP: f64 = 1e-3;
/// Longest step in the logarithm of the speed, and in rad.
const LONGEST: [f64; 2] = [1.0, 0.7];
/// A path is given up when this many trials on end do not come to rest.
const MOST_DIVERGED: u32 = 4;

/// Changes of a command, logarithm of the speed and angle in rad, per change of what it leads to, logarithm of the distance
/// and bearing in rad.
pub(crate) type Inverse = [[f64; 2]; 2];
/// The inverse Jacobian of an isotropic world under dry friction.
pub(crate) const ISOTROPIC: Inverse = [[0.5, 0.0], [0.0, 1.0]];

/// One command tried, and where the object stopped.
#[derive(Clone, Copy)]
pub(crate) struct Trial {
    pub(crate) command: Command,
    /// What the path lacks to the target's: logarithm of the distance, and bearing in rad.
    error: [f64; 2],
    pub(crate) miss: f64,
}

impl Trial {
    /// Step of the command from another trial to this one: logarithm of the speed, and angle in rad.
    fn step_from(&self, other: &Trial) -> [f64; 2] {
        [
            (self.command.speed / other.command.speed).ln(),
            self.command.angle - other.command.angle,
        ]
    }
}

#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Ending {
    Solved,
    /// The nearest trial lies at a bound, and the target beyond.
    OutOfReach,
    /// No trial came to rest.
    Diverged,
    /// The search ended with the target neither reached nor known to be out of reach.
    Open,
}

pub(crate) struct Search<'a> {
    /// The path in m that a command leads along; none where the object does not come to rest.
    lead: &'a mut dyn FnMut(Command) -> Option<Point>,
    path: Point,
    settings: SolveSettings,
    /// Angles at which the tip meets a face of a box, around the path's bearing; none for a round object.
    face: Option<Interval>,
    pub(crate) inverse: Inverse,
    pub(crate) evaluations: u32,
    pub(crate) best: Option<Trial>,
}

impl<'a> Search<'a> {
    /// A search for the command that leads along `path` (m).
    pub(crate) fn new(
        lead: &'a mut dyn FnMut(Command) -> Option<Point>,
        path: Point,
        face: Option<Interval>,
        settings: SolveSettings,
        inverse: Inverse,
    ) -> Self {
        Self {
            lead,
            path,
            settings,
            face,
            inverse,
            evaluations: 0,
            best: None,
        }
    }

    /// Polar steps: logarithm of the speed against that of the distance, angle against bearing, with a 2×2 Jacobian that
    /// learns by Broyden's update. Each step starts from the best trial.
    pub(crate) fn correct(&mut self, first: Command) -> Ending {
        let mut command = self.within(first);
        let mut last: Option<Trial> = None;
        let mut diverged = 0;
        for _ in 0..self.settings.corrections {
            let Some(trial) = self.try_command(command) else {
                diverged += 1;
                if diverged == MOST_DIVERGED {
                    break;
                }
                command = match self.best {
                    // Half way back to what came to rest, or half as fast.
                    Some(best) => Command::new(
                        (command.speed * best.command.speed).sqrt(),
                        0.5 * (command.angle + best.command.angle),
                    ),
                    None => self.within(Command {
                        speed: 0.5 * command.speed,
                        ..command
                    }),
                };
                continue;
            };
            diverged = 0;
            if trial.miss <= self.settings.tolerance {
                return Ending::Solved;
            }
            if self.is_beyond(&trial) {
                return Ending::OutOfReach;
            }
            let (mut is_slipping, mut is_saturated) = (false, false);
            if let Some(last) = last {
                let step = trial.step_from(&last);
                let change = [0, 1].map(|i| last.error[i] - trial.error[i]);
                is_slipping = self.face.is_some()
                    && self.astray(&trial) > 1.0
                    && change[1].abs() < SLIPPING * step[1].abs();
                is_saturated =
                    trial.error[0] > 0.0 && step[0] > LEAST_STEP && change[0] < SATURATED * step[0];
                if is_slipping {
                    // A slope of nothing would lead anywhere: back to where the tip sticks, with some to spare.
                    self.inverse = [[0.5, 0.0], [0.0, STICKING]];
                } else {
                    broyden(&mut self.inverse, step, change);
                }
            }
            last = Some(trial);
            let is_at_edge = self.edge(&trial) == Some(trial.command.angle);
            if is_at_edge && self.is_solved() {
                return Ending::Solved;
            }
            // While the tip slips, the bearing does not show which trial is the better one.
            let best = self
                .best
                .filter(|_| !is_slipping && !is_at_edge)
                .unwrap_or(trial);
            let mut step = [0, 1].map(|i| {
                let wanted =
                    self.inverse[i][0] * best.error[0] + self.inverse[i][1] * best.error[1];
                wanted.clamp(-LONGEST[i], LONGEST[i])
            });
            if best.miss < trial.miss {
                let [faster, turned] = trial.step_from(&best);
                let reach = 0.5 * faster.hypot(turned) / step[0].hypot(step[1]).max(1e-300);
                step = step.map(|component| component * reach.min(1.0));
            }
            command = self.within(Command::new(
                best.command.speed * step[0].exp(),
                best.command.angle + step[1],
            ));
            if is_saturated {
                // An arm that delivers no more, whatever it is commanded: its fastest command shows what is out of reach.
                command.speed = self.settings.speed.high;
            }
            if is_slipping && let Some(edge) = self.edge(&trial) {
                command.angle = edge;
            }
            if command == best.command {
                return Ending::Open;
            }
        }
        if self.best.is_none() {
            Ending::Diverged
        } else {
            Ending::Open
        }
    }

    /// One more simulation for a target that is out of reach: as far along the best bearing as comes nearest to it.
    pub(crate) fn come_near(&mut self) {
        if let Some(best) = self.best {
            let ratio = best.error[0].exp() * best.error[1].cos();
            let command = self.within(Command::new(
                best.command.speed * ratio.max(0.0).sqrt(),
                best.command.angle,
            ));
            if command != best.command {
                self.try_command(command);
            }
        }
    }

    /// The paper's Algorithm 1 as a fallback: NLopt's BOBYQA on the miss, from the best command so far. It always ends.
    pub(crate) fn fall_back(&mut self) {
        let Some(Trial { command: start, .. }) = self.best else {
            return;
        };
        // NLopt takes 0 for no limit.
        if self.settings.fallback == 0 {
            return;
        }
        let (settings, far) = (self.settings, 10.0 * self.path.norm() + 10.0);
        let mut angle = Interval::new(start.angle - 1.2, start.angle + 1.2);
        if let Some(face) = self.face {
            angle = Interval::new(angle.low.max(face.low), angle.high.min(face.high));
        }
        let shared = RefCell::new(self);
        let miss = |x: &[f64], _: Option<&mut [f64]>, _: &mut ()| {
            let command = Command::new(x[0], x[1]);
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
            // Success and failure alike leave the best trial in the self.
            let _ = optimizer.optimize(&mut x);
        }
    }

    fn try_command(&mut self, command: Command) -> Option<Trial> {
        self.evaluations += 1;
        let path = (self.lead)(command)?;
        let trial = Trial {
            command,
            error: [
                (self.path.norm() / path.norm().max(1e-4)).ln(),
                wrap(self.path.bearing() - path.bearing()),
            ],
            miss: path.distance(self.path),
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
    pub(crate) fn is_solved(&self) -> bool {
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

/// An angle in (−π, π].
pub(crate) fn wrap(angle: f64) -> f64 {
    let turned = angle.rem_euclid(std::f64::consts::TAU);
    if turned > std::f64::consts::PI {
        turned - std::f64::consts::TAU
    } else {
        turned
    }
}
