//! An air-hockey table: a puck that hardly anything slows, walls all around, a mallet that goes to meet it. Only the camera and the
//! mallet's state are logged.
//!
//! Its own physics, in fixed steps: the puck slides under dry friction and a tilt, turns back at walls, and is pushed by the mallet along
//! the line of their centres, wherever that hits it.

use std::path::Path;

use logs::write::{RecordingWriter, Samples, Stamped, StateSample};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use values::{Point, Rig, Shape, Solid};

use crate::RigSimError;
use crate::effects::GRAVITY;
use crate::random::{Purpose, random};

/// The table as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct AirTable {
    /// Dry friction.
    pub friction: f64,
    /// Slope along x and y, in rad.
    pub tilt: Point,
    /// Speed of parting over speed of approach, of puck and mallet.
    pub restitution: f64,
    /// Restitution of puck and wall.
    pub wall_restitution: f64,
    /// Draws everything random.
    pub seed: u64,
}

const STEP: f64 = 1e-4;
const PUCK: f64 = 0.032;
const MALLET: f64 = 0.040;
/// Corners of the table, in m.
const LOW: Point = Point { x: 0.0, y: -0.5 };
const HIGH: Point = Point { x: 1.9, y: 0.5 };
const HOME: Point = Point { x: 0.2, y: 0.0 };
/// The mallet's acceleration in m/s², and the speed in m/s at which it goes home.
const ACCELERATION: f64 = 25.0;
const HOMEWARD: f64 = 0.5;
/// How often the camera looks and the state is logged, in Hz.
const CAMERA: f64 = 120.0;
const STATE: f64 = 250.0;
/// Standard deviations of what is logged: centroids and places in m, velocities in m/s.
const NOISE: (f64, f64, f64) = (0.0005, 0.0001, 0.005);
const LOST: f64 = 0.01;
const ORIGIN: u64 = 1_700_000_000_000_000_000;

impl AirTable {
    /// What its owner knows of it.
    pub fn rig() -> Rig {
        let mut rig = Rig::demo(Shape::Cylinder);
        rig.object.solid = Solid::Cylinder {
            radius: PUCK,
            half_height: 0.004,
        };
        rig.object.mass = 0.03;
        rig.striker.radius = MALLET;
        rig.table.x = [LOW.x, HIGH.x].into();
        rig.table.y = [LOW.y, HIGH.y].into();
        rig.camera.rate = CAMERA;
        rig.camera.noise = NOISE.0;
        rig.camera.centre = Point::new(0.95, 0.0);
        rig.robot.speed = [0.1, 3.0].into();
        rig.robot.angle = [-1.5, 1.5].into();
        rig.robot.acceleration = ACCELERATION;
        rig
    }

    /// Plays for so long (s), and writes what is logged of it.
    pub fn write(&self, seconds: f64, session: usize, path: &Path) -> Result<(), RigSimError> {
        let samples = self.play(seconds, session);
        let mut writer = RecordingWriter::create(path, &Self::rig().topics)?;
        writer.write(&samples)?;
        writer.finish()?;
        Ok(())
    }

    fn play(&self, seconds: f64, session: usize) -> Samples {
        let mut random = random(self.seed, Purpose::Launch, session);
        let start = ORIGIN + session as u64 * 86_400_000_000_000;
        let mut samples = Samples::default();
        let mut puck = Body {
            at: Point::new(0.7, 0.1),
            velocity: Point::new(-0.4, 0.2),
        };
        let mut mallet = Mallet {
            body: Body {
                at: HOME,
                velocity: Point::default(),
            },
            dash: None,
            free_at: 0.5,
        };
        let steps = (seconds / STEP) as u64;
        let every = |rate: f64| (1.0 / (rate * STEP)).round() as u64;
        for step in 0..steps {
            let t = step as f64 * STEP;
            let stamp = start + (t * 1e9).round() as u64;
            let mut noisy = |value: f64, deviation: f64| {
                let normal: f64 = StandardNormal.sample(&mut random);
                value + deviation * normal
            };
            if step % every(CAMERA) == 0 {
                let (x, y) = (noisy(puck.at.x, NOISE.0), noisy(puck.at.y, NOISE.0));
                if random.random::<f64>() >= LOST {
                    samples.centroids.push(Stamped { stamp, x, y });
                }
            } else if step % every(STATE) == 0 {
                let body = mallet.body;
                samples.states.push(StateSample {
                    stamp,
                    position: [noisy(body.at.x, NOISE.1), noisy(body.at.y, NOISE.1)],
                    velocity: [
                        noisy(body.velocity.x, NOISE.2),
                        noisy(body.velocity.y, NOISE.2),
                    ],
                });
            }
            let part = [0.0; 3].map(|_| random.random::<f64>());
            mallet.decide(&puck, t, part);
            mallet.go(t);
            puck = self.slid(puck);
            self.push(&mut puck, &mallet.body);
        }
        samples
    }

    fn slid(&self, mut puck: Body) -> Body {
        let speed = puck.velocity.norm();
        let slowed = (self.friction * GRAVITY * STEP).min(speed);
        puck.velocity = puck.velocity * (1.0 - slowed / speed.max(1e-12))
            + Point::new(self.tilt.x.sin(), self.tilt.y.sin()) * (GRAVITY * STEP);
        puck.at = puck.at + puck.velocity * STEP;
        let back = |at: f64, velocity: f64, low: f64, high: f64| {
            let outwards = (at < low && velocity < 0.0) || (at > high && velocity > 0.0);
            if outwards {
                -self.wall_restitution * velocity
            } else {
                velocity
            }
        };
        puck.velocity.x = back(puck.at.x, puck.velocity.x, LOW.x + PUCK, HIGH.x - PUCK);
        puck.velocity.y = back(puck.at.y, puck.velocity.y, LOW.y + PUCK, HIGH.y - PUCK);
        puck
    }

    /// The mallet is as heavy as the arm behind it.
    fn push(&self, puck: &mut Body, mallet: &Body) {
        let away = puck.at - mallet.at;
        let normal = away * (1.0 / away.norm().max(1e-12));
        let approach = (mallet.velocity - puck.velocity).dot(normal);
        if away.norm() < PUCK + MALLET && approach > 0.0 {
            puck.velocity = puck.velocity + normal * ((1.0 + self.restitution) * approach);
        }
    }
}

#[derive(Clone, Copy)]
struct Body {
    at: Point,
    velocity: Point,
}

struct Mallet {
    body: Body,
    /// Velocity of a dash, and when it ends.
    dash: Option<(Point, f64)>,
    free_at: f64,
}

impl Mallet {
    /// Where the puck comes near, it dashes to meet it, at a speed, a place and a moment as these parts say.
    fn decide(&mut self, puck: &Body, t: f64, part: [f64; 3]) {
        let is_near = puck.at.x > 0.3 && puck.at.x < 0.8;
        if self.dash.is_some() || t < self.free_at || !is_near || puck.velocity.x > 0.3 {
            return;
        }
        let speed = 0.5 + 1.2 * part[0];
        let mut takes = 0.3;
        for _ in 0..8 {
            takes = (puck.at + puck.velocity * takes - self.body.at).norm() / speed;
        }
        let meet = puck.at + puck.velocity * takes;
        let room = |low: f64, high: f64, x: f64| x > low + 0.1 && x < high - 0.1;
        if !(room(LOW.x, 1.0, meet.x) && room(LOW.y, HIGH.y, meet.y)) || takes > 1.0 {
            return;
        }
        let towards = meet - self.body.at;
        let along = towards * (1.0 / towards.norm().max(1e-12));
        let aside = Point::new(-along.y, along.x) * (0.9 * (part[1] - 0.5) * (PUCK + MALLET));
        let dash = towards + aside;
        self.dash = Some((dash * (speed / dash.norm().max(1e-12)), t + takes + 0.02));
        self.free_at = t + takes + 1.0 + part[2];
    }

    fn go(&mut self, t: f64) {
        if self.dash.is_some_and(|(_, until)| t > until) {
            self.dash = None;
        }
        let home = HOME - self.body.at;
        let homeward = home * (4.0 * HOMEWARD / (4.0 * home.norm()).max(HOMEWARD));
        let wanted = self.dash.map_or(homeward, |(velocity, _)| velocity);
        let change = wanted - self.body.velocity;
        let most = (ACCELERATION * STEP / change.norm().max(1e-12)).min(1.0);
        self.body.velocity = self.body.velocity + change * most;
        self.body.at = self.body.at + self.body.velocity * STEP;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_puck_keeps_its_speed_between_walls_and_is_struck_often() {
        let table = AirTable {
            friction: 0.0,
            tilt: Point::default(),
            restitution: 0.8,
            wall_restitution: 0.9,
            seed: 1,
        };
        let samples = table.play(60.0, 0);
        assert!(samples.commands.is_empty() && samples.states.len() > 10_000);
        let inside = |c: &Stamped| c.x > -0.01 && c.x < 1.91 && c.y.abs() < 0.51;
        assert!(samples.centroids.iter().all(inside));
        // A strike makes it go the other way, and fast.
        let speeds: Vec<f64> = samples
            .centroids
            .windows(6)
            .map(|w| (w[5].x - w[0].x) / ((w[5].stamp - w[0].stamp) as f64 * 1e-9))
            .collect();
        let struck = speeds
            .windows(12)
            .filter(|w| w[0] < 0.2 && w[11] > 0.7)
            .count();
        assert!(struck > 60, "{struck}");
    }
}
