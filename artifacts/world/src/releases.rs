//! How the object leaves the tip in one world: a table that fills where it is asked.
//!
//! In one world a release depends on the delivered speed alone and, for a box, on the angle. Relative to that speed it
//! changes little, so MuJoCo's blow at a few speeds and angles serves all strikes, by cubic interpolation. An entry depends
//! on its place only: which strike asked first, and on which thread, changes no bit.

use std::{
    collections::BTreeMap,
    sync::{PoisonError, RwLock},
};

use values::{Command, Conditions, Interval, Shape};

use crate::{Release, Worker, release::Scaled, touch};

/// Steps of the table: logarithm of the speed, and rad.
const STEPS: [f64; 2] = [0.3, 0.04];

/// Releases by their place in the table.
#[derive(Default)]
pub(crate) struct Releases(RwLock<BTreeMap<[i64; 2], Option<Scaled>>>);

impl Worker<'_> {
    /// The release that follows a command, interpolated. `None` where tip and object do not part, or miss, at an entry beside.
    ///
    /// The table is that of conditions of no session, before all strikes. What differs in others, restitution at the most,
    /// scales the speeds: exact for a blow through the centre, and near enough for where a search begins.
    pub(crate) fn likely_release(
        &mut self,
        command: Command,
        conditions: &Conditions,
    ) -> Option<Release> {
        let rig = self.simulator.rig();
        let blow = self.simulator.blow(command, conditions);
        let of_table = self
            .simulator
            .struck(blow.command, &Conditions::default())
            .restitution;
        let Command { speed, angle } = blow.command;
        if speed.is_nan() || speed <= 0.0 {
            return None;
        }
        let anywhere = Interval {
            low: f64::NEG_INFINITY,
            high: f64::INFINITY,
        };
        let speeds = cubic(speed.ln(), anywhere, STEPS[0])?;
        let angles = match rig.object.shape {
            // A round object is struck alike from everywhere.
            Shape::Cylinder | Shape::Sphere => vec![(0, 1.0)],
            Shape::Box => {
                let face = touch::face(&rig.object, &rig.striker, blow.tip_offset, angle)?;
                cubic(angle, face, STEPS[1])?.to_vec()
            }
        };
        let mut release = [0.0; 6];
        for (i, by_speed) in speeds {
            for (j, by_angle) in &angles {
                let entry = self.entry([i, *j])?;
                for (sum, value) in release.iter_mut().zip(entry) {
                    *sum += by_speed * by_angle * value;
                }
            }
        }
        let [_, _, _, velocity_x, velocity_y, spin] = &mut release;
        for scaled in [velocity_x, velocity_y, spin] {
            *scaled *= (1.0 + blow.restitution) / (1.0 + of_table);
        }
        Some(Release::of(release, blow.command))
    }

    /// An entry, simulated when it is first asked for.
    fn entry(&mut self, place: [i64; 2]) -> Option<Scaled> {
        let table = &self.simulator.releases.0;
        let read = table.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(entry) = read.get(&place) {
            return *entry;
        }
        drop(read);
        let speed = (place[0] as f64 * STEPS[0]).exp();
        let angle = place[1] as f64 * STEPS[1];
        let blow = self
            .simulator
            .struck(Command { speed, angle }, &Conditions::default());
        let entry = self.release(blow).map(|release| release.scaled(speed));
        let mut write = table.write().unwrap_or_else(PoisonError::into_inner);
        write.insert(place, entry);
        entry
    }
}

/// Places of four entries within `range` and their weights, of the cubic through them; `None` where the range holds fewer.
fn cubic(at: f64, range: Interval, step: f64) -> Option<[(i64, f64); 4]> {
    let at = at / step;
    // A cast of what is infinite saturates.
    let (least, most) = (
        (range.low / step).ceil() as i64,
        (range.high / step).floor() as i64,
    );
    let last_first = most.saturating_sub(3);
    if last_first < least {
        return None;
    }
    let first = (at.floor() as i64 - 1).clamp(least, last_first);
    let places = [0, 1, 2, 3].map(|i| first + i);
    Some(places.map(|place| {
        let others = places.iter().filter(|other| **other != place);
        let weight = others.fold(1.0, |weight, other| {
            weight * (at - *other as f64) / (place - other) as f64
        });
        (place, weight)
    }))
}

#[cfg(test)]
mod tests {
    use values::Rig;

    use super::*;
    use crate::{Simulator, World};

    #[test]
    fn a_cubic_is_met_within_and_at_the_ends() {
        let cube = |x: f64| 1.0 - 2.0 * x + 3.0 * x * x - 0.5 * x * x * x;
        let range = Interval {
            low: 0.31,
            high: 1.0,
        };
        for at in [0.31, 0.35, 0.52, 0.777, 0.99] {
            let places = cubic(at, range, 0.1).expect("wide enough");
            let sum: f64 = places
                .iter()
                .map(|(i, weight)| weight * cube(*i as f64 * 0.1))
                .sum();
            assert!((sum - cube(at)).abs() < 1e-12, "{at}: {sum}");
            assert!(
                places.iter().all(|(i, _)| (4..=10).contains(i)),
                "{places:?}"
            );
        }
        assert!(cubic(0.5, range, 0.3).is_none());
    }

    #[test]
    fn what_is_interpolated_is_what_mujoco_does() {
        for (shape, most) in [(Shape::Cylinder, 2e-5), (Shape::Box, 2e-4)] {
            let rig = Rig::demo(shape);
            let simulator = Simulator::new(&rig, &World::nominal(&rig)).expect("valid");
            let mut worker = simulator.worker();
            for i in 0..20 {
                let command = Command {
                    speed: 0.3 + 0.05 * f64::from(i),
                    angle: 0.3 - 0.03 * f64::from(i),
                };
                let likely = worker
                    .likely_release(command, &Conditions::default())
                    .expect("parts");
                let real = worker
                    .release(simulator.blow(command, &Conditions::default()))
                    .expect("parts");
                let real = Release::of(real.scaled(command.speed), command);
                let off = (likely.velocity - real.velocity).norm() / command.speed;
                assert!(off < most, "{shape:?}, {command:?}: {off}");
            }
        }
    }
}
