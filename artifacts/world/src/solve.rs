//! The inverse: speed and angle that bring the object from where it rests to a target (paper, algorithm 1).
//!
//! The search ([`crate::search`]) goes through the world's planar form first, which follows MuJoCo's to a few tenths of a
//! millimetre in a few microseconds a trial; its answer is then simulated, and corrected where MuJoCo misses. Only MuJoCo
//! says whether a target is reached.

use values::{Command, Conditions, Interval, Point};

use crate::{
    GRAVITY, Worker,
    planar::{Deviation, StrikeInput},
    search::{Ending, ISOTROPIC, Inverse, Search, Trial, wrap},
    solution::{SOLVED, Solution, SolveSettings, SolveStatus},
    touch,
};

/// Miss at the end of reach, in units of a solved row's, up to which the search goes on.
const NEARLY: f64 = 3.0;
/// Miss in m at which the search in planar form ends, and trials that it may take.
const PLANAR: (f64, u32) = (1e-5, 40);

#[derive(Clone, Copy)]
struct Aim<'a> {
    initial: Point,
    path: Point,
    conditions: &'a Conditions,
    settings: SolveSettings,
    /// Angles at which the tip meets a face of a box, around the path's bearing; none for a round object.
    face: Option<Interval>,
}

impl Worker<'_> {
    /// The command that brings an object seen at `initial` to rest at `target` (m), in the session and at the time of
    /// `conditions`. `guess` is where to start in place of the planar form's answer, such as a solved neighbour's command.
    /// Never fails: what cannot be reached is a status.
    pub fn solve(
        &mut self,
        initial: Point,
        target: Point,
        conditions: &Conditions,
        settings: &SolveSettings,
        guess: Option<Command>,
    ) -> Solution {
        let path = target - initial;
        let straight = guess.unwrap_or_else(|| self.straight(path));
        let aim = Aim {
            initial,
            path,
            conditions,
            settings: *settings,
            face: self.face(initial, path, straight, conditions),
        };
        let planar = match guess {
            Some(_) => None,
            None => self.planar_solution(&aim, straight),
        };
        let mut evaluations = 0;
        if let Some((command, inverse)) = planar {
            let settings = SolveSettings {
                fallback: 0,
                ..*settings
            };
            let found = self.search(&Aim { settings, ..aim }, command, inverse);
            if found.status == SolveStatus::Solved {
                return found;
            }
            // It misled, as where a tip begins to slip between two entries of its table: anew, without it.
            evaluations = found.evaluations;
        }
        let mut found = self.search(&aim, straight, ISOTROPIC);
        found.evaluations += evaluations;
        found
    }

    /// The command that leads along a path in planar form, and the inverse Jacobian there; `None` where none does.
    fn planar_solution(&mut self, aim: &Aim<'_>, straight: Command) -> Option<(Command, Inverse)> {
        let planar = self.simulator.planar()?;
        let mut lead = |command| {
            let input = StrikeInput {
                initial: aim.initial,
                command,
                conditions: aim.conditions,
                times: &[],
                to_rest: true,
            };
            let release = self.likely_release(command, aim.initial, aim.conditions)?;
            Some(planar.slide(&input, release, &Deviation::default())?.stop - aim.initial)
        };
        let (tolerance, corrections) = PLANAR;
        let settings = SolveSettings {
            tolerance,
            corrections,
            ..aim.settings
        };
        let mut search = Search::new(&mut lead, aim.path, aim.face, settings, ISOTROPIC);
        let is_solved = search.correct(straight) == Ending::Solved;
        is_solved.then_some((search.best?.command, search.inverse))
    }

    /// The search in MuJoCo's world.
    fn search(&mut self, aim: &Aim<'_>, first: Command, inverse: Inverse) -> Solution {
        let mut lead = |command| {
            let simulated = self.strike(aim.initial, command, aim.conditions).ok()?;
            Some(simulated.stop - aim.initial)
        };
        let mut search = Search::new(&mut lead, aim.path, aim.face, aim.settings, inverse);
        let tolerance = aim.settings.tolerance;
        match search.correct(first) {
            Ending::Open if search.is_solved() => {}
            Ending::Open => search.fall_back(),
            Ending::OutOfReach => {
                search.come_near();
                // Close to where the face ends a few more simulations decide.
                let limit = NEARLY * SOLVED * tolerance;
                if !search.is_solved() && search.best.is_some_and(|best| best.miss < limit) {
                    search.fall_back();
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
                status: if miss < SOLVED * tolerance {
                    SolveStatus::Solved
                } else {
                    SolveStatus::Unreachable
                },
            },
        }
    }

    /// Commanded angles, around the path's bearing, at which the tip meets a face of a box.
    fn face(
        &self,
        initial: Point,
        path: Point,
        first: Command,
        conditions: &Conditions,
    ) -> Option<Interval> {
        let rig = self.simulator.rig();
        let impact = self.simulator.impact(first, initial, conditions);
        // From a command's angle to that at which its tip comes onto the box's own faces.
        let turned = impact.command.angle - first.angle;
        let onto_face = path.bearing() + turned - impact.yaw;
        let face = touch::face(&rig.object, &rig.striker, impact.tip_offset, onto_face)?;
        Some(Interval::new(
            face.low + impact.yaw - turned,
            face.high + impact.yaw - turned,
        ))
    }

    /// First guess: v = √(2·μ·g·d)/(1 + e), straight at the target.
    fn straight(&self, path: Point) -> Command {
        let (friction, restitution) = self.simulator.coefficients();
        let release = (2.0 * friction * GRAVITY * path.norm()).sqrt();
        Command::new(release / (1.0 + restitution), path.bearing())
    }
}
