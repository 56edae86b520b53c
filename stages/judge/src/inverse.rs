//! Where a model says that a strike stops: in a world, forwards; with networks, on the path for which solve + residual would have sent the
//! command.
//!
//! A robot that follows the model solves the world for (v_sim, θ_sim) and sends v = v_sim + Δv(path, v_sim, θ_sim),
//! θ likewise. What path did it mean, if it sent (v, θ)? Each candidate (v_sim, θ_sim) has one path, its simulated
//! one, so this is one equation in two unknowns each. Near a simulated command, paths follow from it without another
//! simulation (distance as speed squared, bearing as angle); on that stand-in the equation is solved by Newton's method
//! and the solution simulated, until stand-in and simulation agree: two or three simulations.

use store::Networks;
use values::{Command, Conditions, Point, wrap_angle};
use world::Worker;

use crate::held_out::last_place;
use crate::{HeldOut, Predicted, PredictionStatus};

/// Greatest number of simulations; a residual worth its name takes two or three.
const SIMULATIONS: u32 = 8;
/// Distance up to which a stand-in is trusted from its simulation, in m: its error is a tenth of that or less.
const TRUSTED: f64 = 1e-3;
/// Newton's method ends when the command is met to this share of itself.
const MET: f64 = 1e-7;
/// Steps of Newton's method; halvings of one step.
const STEPS: u32 = 40;
const HALVINGS: u32 = 10;
/// Differences for its Jacobian, in m/s and rad.
const DIFFERENCE: f64 = 1e-4;
/// Determinant below which the residual undoes what the solve does, and a Newton step leads far away.
const LEAST_DETERMINANT: f64 = 0.05;
/// Speeds in m/s that a simulation is given; the solve's own bounds.
const SPEED: (f64, f64) = (0.05, 4.0);

/// The stop, or the place at the track's end, that a model predicts for the command that was sent: the worker's world alone, in
/// which a launch map already acts, or with networks.
pub fn predict(
    worker: &mut Worker<'_>,
    networks: Option<&Networks>,
    strike: &HeldOut,
) -> Predicted {
    let HeldOut {
        initial,
        command,
        conditions,
        ends,
        ..
    } = strike;
    // Networks know of stops alone.
    if let (Some(networks), None) = (networks, ends) {
        return meant_by(worker, networks, *initial, *command, conditions);
    }
    let place = last_place(worker, strike, *command);
    let status = match place {
        Ok(_) => PredictionStatus::Simulated,
        Err(_) => PredictionStatus::Diverged,
    };
    Predicted {
        stop: place.ok(),
        evaluations: 1,
        status,
    }
}

/// Finds the path for which solve + residual would have sent `wanted` to an object at `initial` under the same
/// conditions. Never fails: what cannot be met is a status, with the nearest path found.
fn meant_by(
    worker: &mut Worker<'_>,
    networks: &Networks,
    initial: Point,
    wanted: Command,
    conditions: &Conditions,
) -> Predicted {
    let mut evaluations = 0;
    let mut simulate = |command: Command| {
        evaluations += 1;
        let stop = worker.strike(initial, command, conditions).ok()?.stop;
        let path = stop - initial;
        Some((evaluations, Anchor { command, path }))
    };
    let Some((mut evaluations, mut near)) = simulate(wanted) else {
        return Predicted {
            stop: None,
            evaluations: 1,
            status: PredictionStatus::Diverged,
        };
    };
    loop {
        let (command, is_met) = near.solve(networks, wanted);
        let path = near.path_of(command);
        let is_near = path.distance(near.path) < TRUSTED;
        if !is_near
            && evaluations < SIMULATIONS
            && let Some(next) = simulate(command)
        {
            (evaluations, near) = next;
            continue;
        }
        let status = if is_near && is_met {
            PredictionStatus::Converged
        } else {
            PredictionStatus::NotConverged
        };
        return Predicted {
            stop: Some(initial + path),
            evaluations,
            status,
        };
    }
}

/// A simulated command and its path, from which near ones follow.
struct Anchor {
    command: Command,
    path: Point,
}

impl Anchor {
    /// The path of another command, without a simulation.
    fn path_of(&self, command: Command) -> Point {
        let ratio = command.speed / self.command.speed;
        (self.path * (ratio * ratio)).rotated(command.angle - self.command.angle)
    }

    /// What would be sent beyond `wanted`, if `command` were the world's answer: in m/s and rad.
    fn excess(&self, networks: &Networks, command: Command, wanted: Command) -> [f64; 2] {
        let path = self.path_of(command);
        let [d_speed, d_angle] = networks.predict([path.x, path.y, command.speed, command.angle]);
        [
            command.speed + d_speed - wanted.speed,
            wrap_angle(command.angle + d_angle - wanted.angle),
        ]
    }

    /// The world's answer to which the residual adds up to `wanted`, and whether it does; by damped Newton steps from
    /// the anchor.
    fn solve(&self, networks: &Networks, wanted: Command) -> (Command, bool) {
        // Relative to the speed, so that both components weigh as the displacement they cause.
        let size = |excess: [f64; 2]| (2.0 * excess[0] / wanted.speed).hypot(excess[1]);
        let mut command = self.command;
        let mut excess = self.excess(networks, command, wanted);
        for _ in 0..STEPS {
            if size(excess) < MET {
                return (command, true);
            }
            let step = self.newton_step(networks, command, excess, wanted);
            let better = (0..HALVINGS).find_map(|halvings| {
                let share = 0.5f64.powi(halvings as i32);
                let next = Command::new(
                    (command.speed + share * step[0]).clamp(SPEED.0, SPEED.1),
                    command.angle + share * step[1],
                );
                let left = self.excess(networks, next, wanted);
                (size(left) < size(excess)).then_some((next, left))
            });
            let Some(next) = better else { break };
            (command, excess) = next;
        }
        (command, size(excess) < MET)
    }

    /// −J⁻¹·excess, or −excess (a residual changes little, so J is near one) where J has no sound inverse.
    fn newton_step(
        &self,
        networks: &Networks,
        at: Command,
        excess: [f64; 2],
        wanted: Command,
    ) -> [f64; 2] {
        let faster = Command {
            speed: at.speed + DIFFERENCE,
            ..at
        };
        let turned = Command {
            angle: at.angle + DIFFERENCE,
            ..at
        };
        let column = |moved| {
            let there = self.excess(networks, moved, wanted);
            [
                (there[0] - excess[0]) / DIFFERENCE,
                (there[1] - excess[1]) / DIFFERENCE,
            ]
        };
        let (a, b) = (column(faster), column(turned));
        let determinant = a[0] * b[1] - b[0] * a[1];
        if determinant < LEAST_DETERMINANT {
            return [-excess[0], -excess[1]];
        }
        [
            (b[0] * excess[1] - b[1] * excess[0]) / determinant,
            (a[1] * excess[0] - a[0] * excess[1]) / determinant,
        ]
    }
}
