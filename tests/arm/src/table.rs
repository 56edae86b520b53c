//! What lies before the emulated arm: a table with an object, whose physics is the embedded rig's, and a camera that looks at it.

use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rig::{RigSimError, Sim, StrikeIndex, StrikeOutcome, Truth};
use values::{Command, Interval, Point, Rig};

/// The tip meets the object below this height, in mm.
const LOW: f64 = 45.0;
/// Slower than this, in m/s, the tip does not strike.
const STILL: f64 = 0.05;
/// The object lies this long before it is put back.
const LIES: Duration = Duration::from_millis(2_500);
/// One that is not struck for so long is put elsewhere, as a person does who is asked to.
const IGNORED: Duration = Duration::from_secs(15);
/// Least distance from the tip, in m, at which the object is put.
const CLEAR: f64 = 0.1;
/// Least distance from where it stopped, in m, at which the object is put: `carom collect` waits until it was put elsewhere.
const ELSEWHERE: f64 = 0.03;
/// An object that is in the hand is not seen for so long.
const IN_HAND: Duration = Duration::from_millis(400);
/// The hand puts it into this part of the table.
const PUT_X: Interval = Interval::new(0.26, 0.40);
const PUT_Y: Interval = Interval::new(-0.15, 0.15);

#[derive(Debug)]
pub struct Table {
    sim: Sim,
    random: ChaCha8Rng,
    /// Where the object lies, or lay before it was struck.
    at: Point,
    struck: Option<(Instant, StrikeOutcome)>,
    /// When something changed last: the object was put down, or came to rest.
    since: Instant,
    puts_back: bool,
    before: Option<Point>,
    /// Where the last strike left the object.
    pub stop: Option<Point>,
    /// Strikes, and how often the tip came into the object again while it slid.
    pub counts: (usize, usize),
}

impl Table {
    /// The rig of this truth; `puts_back` says whether a hand puts the object back after each strike.
    pub fn new(truth: Truth, at: Point, puts_back: bool) -> Result<Self, RigSimError> {
        Ok(Self {
            random: ChaCha8Rng::seed_from_u64(truth.seed),
            sim: Sim::from(truth)?,
            at,
            struck: None,
            since: Instant::now(),
            puts_back,
            before: None,
            stop: None,
            counts: (0, 0),
        })
    }

    pub fn put(&mut self, at: Point) {
        self.at = at;
        self.struck = None;
        self.since = Instant::now() + IN_HAND;
    }

    /// A hand pushes the object by so much (m), before the camera's eyes.
    pub fn push(&mut self, by: Point) {
        self.at = self.at + by;
    }

    /// A hand covers the camera for so long.
    pub fn cover(&mut self, time: Duration) {
        self.since = Instant::now() + time;
    }

    /// Place of the object now, in m, at rest or sliding.
    pub fn place(&self, now: Instant) -> Point {
        match &self.struck {
            Some((impact, shot)) => shot.at(now.saturating_duration_since(*impact).as_secs_f64()),
            None => self.at,
        }
    }

    /// Where the camera sees it, with noise; none where it is not seen.
    pub fn seen(&mut self, now: Instant) -> Option<Point> {
        let truth = self.sim.truth();
        let (noise, dropped) = (truth.rig.camera.noise, truth.camera.dropped);
        let seen = truth.see(self.place(now), self.index());
        let [x, y]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(&mut self.random));
        let is_seen = now >= self.since && self.random.random::<f64>() >= dropped;
        is_seen.then(|| seen + Point::new(x, y) * noise)
    }

    fn index(&self) -> StrikeIndex {
        self.sim.index()
    }

    /// The tip's centre is at a place of the table (m) at a height (mm) and moves at this velocity (m/s).
    pub fn tip(&mut self, at: Point, height: f64, velocity: Point, now: Instant) {
        let reach = reach(&self.sim.truth().rig);
        let before = self.before.replace(at);
        let place = self.place(now);
        let came_in = |limit: f64| {
            height < LOW
                && at.distance(place) <= limit
                && before.is_some_and(|before| before.distance(place) > at.distance(place))
        };
        let struck = self
            .struck
            .as_ref()
            .map(|(impact, shot)| (*impact, shot.rest_time(), shot.stop()));
        match struck {
            None if velocity.norm() > STILL && came_in(reach) => {
                let direction = velocity * (1.0 / velocity.norm());
                let to_object = self.at - at;
                // How far the tip's line passes to the left of the object's centre.
                let aside = to_object.x * direction.y - to_object.y * direction.x;
                let tip = Command::new(velocity.norm(), velocity.bearing());
                let shot = self.sim.meet(self.at, tip, aside);
                self.counts.0 += 1;
                self.stop = Some(shot.stop());
                self.struck = Some((now, shot));
            }
            Some((impact, rest_time, stop)) => {
                let since = now.saturating_duration_since(impact).as_secs_f64();
                // Past the impact itself, the tip must not come near again.
                if since > 0.1 && since < rest_time && came_in(reach) {
                    self.counts.1 += 1;
                }
                if since > rest_time {
                    let has_lain = since - rest_time > LIES.as_secs_f64();
                    if self.puts_back && has_lain && velocity.norm() < STILL {
                        let next = self.next();
                        // Beside an arm that was stopped low, the next draw may be free.
                        if next.distance(at) > CLEAR && next.distance(stop) > ELSEWHERE {
                            self.put(next);
                        }
                    } else if !self.puts_back {
                        self.at = stop;
                        self.struck = None;
                    }
                }
            }
            None if self.puts_back && now.saturating_duration_since(self.since) > IGNORED => {
                self.put_elsewhere();
            }
            None => {}
        }
    }

    /// A hand puts it elsewhere, as where a strike from here was refused.
    pub fn put_elsewhere(&mut self) {
        let next = self.next();
        self.put(next);
    }

    fn next(&mut self) -> Point {
        let mut between =
            |ends: Interval| ends.low + (ends.high - ends.low) * self.random.random::<f64>();
        Point::new(between(PUT_X), between(PUT_Y))
    }
}

/// Distance of tip's and object's centre at touch, of a round object.
fn reach(rig: &Rig) -> f64 {
    rig.object.solid.narrowest() + rig.striker.radius
}
