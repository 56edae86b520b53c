//! What the arm may do on one straight line, and whether a report keeps to it.

use std::time::Instant;

use super::wire::Realtime;

/// The tip may be so far beside its line, in mm.
const ASIDE: f64 = 5.0;
/// It may be so much faster than commanded, as a share, and in mm/s.
const FASTER: (f64, f64) = (0.10, 10.0);
/// At the point where the striking speed must be reached, it may lack this share of it.
const SLOWER: f64 = 0.05;
/// Pose and controller's clock may run apart from this computer's by so much, in s.
const LAG: f64 = 0.05;
/// At rest at the end of its line: within mm, and slower than mm/s.
const ARRIVED: (f64, f64) = (0.5, 2.0);
/// State and mode in a report.
const MOVING: u8 = 1;
const READY: u8 = 2;
const POSITION_MODE: u8 = 0;

/// A report and when it came.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// When it came, by this computer's clock.
    pub(super) at: Instant,
    /// What it said.
    pub(super) report: Realtime,
}

/// A straight line of the tip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    /// Where it begins, x, y, z in mm.
    pub(super) from: [f64; 3],
    /// Where it ends.
    pub(super) to: [f64; 3],
    /// Greatest speed in mm/s.
    pub(super) speed: f64,
    /// Distance from the beginning, in mm, at which that speed must be reached; none where it need not.
    pub(super) reached_at: Option<f64>,
}

impl Line {
    /// Its length in mm.
    pub(super) fn length(&self) -> f64 {
        distance(self.from, self.to)
    }

    /// How far along it a point lies, and how far beside it, in mm.
    pub(super) fn place(&self, point: [f64; 3]) -> (f64, f64) {
        let length = self.length().max(1e-9);
        let along = (0..3)
            .map(|i| (point[i] - self.from[i]) * (self.to[i] - self.from[i]) / length)
            .sum::<f64>();
        let nearest = std::array::from_fn(|i| {
            let share = along.clamp(0.0, length) / length;
            self.from[i] + share * (self.to[i] - self.from[i])
        });
        (along, distance(point, nearest))
    }
}

/// A line that is being moved on.
#[derive(Debug)]
pub(super) struct Guard {
    line: Line,
    begun: Instant,
    /// The report before the one to be judged.
    before: Option<Sample>,
    /// The first report: where the clocks are compared from.
    first: Option<Sample>,
    was_reached: bool,
}

impl Guard {
    /// `last` is the report before the line was sent.
    pub(super) fn new(line: Line, last: Option<Sample>) -> Self {
        Self {
            line,
            begun: Instant::now(),
            before: last,
            first: None,
            was_reached: false,
        }
    }

    /// Since when it guards.
    pub(super) fn begun(&self) -> Instant {
        self.begun
    }

    /// Whether a report keeps to the line. Errors with what does not.
    pub(super) fn judge(&mut self, sample: &Sample) -> Result<(), String> {
        let before = self.before.replace(*sample);
        let first = *self.first.get_or_insert(*sample);
        let report = &sample.report;
        if !matches!(report.state, MOVING | READY | 0) {
            return Err(format!(
                "the controller left motion, state {}",
                report.state
            ));
        }
        if report.mode != POSITION_MODE {
            return Err(format!("another controller set mode {}", report.mode));
        }
        let (along, aside) = self.line.place(position(sample));
        if aside > ASIDE {
            return Err(format!(
                "the tip is {aside:.1} mm off its line, {ASIDE} mm is the most"
            ));
        }
        let speed = norm(report.velocity);
        let (share, more) = FASTER;
        let most = self.line.speed * (1.0 + share) + more;
        if speed > most {
            return Err(format!(
                "the tip moves at {speed:.0} mm/s, commanded were {:.0} mm/s",
                self.line.speed
            ));
        }
        let passed = |from: u64, to: u64| to.checked_sub(from).map(|us| us as f64 * 1e-6);
        if let Some(before) = before {
            let Some(step) = passed(before.report.clock, report.clock) else {
                return Err("the clock of its reports runs backwards".into());
            };
            let jump = distance(position(&before), position(sample));
            if jump > most * step + ASIDE {
                return Err(format!(
                    "the tip jumps by {jump:.1} mm within {:.1} ms",
                    step * 1e3
                ));
            }
        }
        let (here, there) = (
            sample.at.duration_since(first.at).as_secs_f64(),
            passed(first.report.clock, report.clock).unwrap_or(0.0),
        );
        if (here - there).abs() > LAG {
            return Err(format!("its reports lag by {:.0} ms", (here - there) * 1e3));
        }
        if let Some(reached_at) = self.line.reached_at
            && !self.was_reached
            && along >= reached_at
        {
            self.was_reached = true;
            let least = self.line.speed * (1.0 - SLOWER);
            if speed < least {
                return Err(format!(
                    "the speed is not reached: {speed:.0} mm/s of {:.0} mm/s before the object",
                    self.line.speed
                ));
            }
        }
        Ok(())
    }

    /// Whether the tip rests at the end of the line.
    pub(super) fn is_over(&self, sample: &Sample) -> bool {
        let (near, slow) = ARRIVED;
        distance(position(sample), self.line.to) <= near && norm(sample.report.velocity) <= slow
    }
}

fn position(sample: &Sample) -> [f64; 3] {
    let [x, y, z, ..] = sample.report.pose;
    [x, y, z]
}

pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    norm(std::array::from_fn(|i| a[i] - b[i]))
}

pub(super) fn norm(vector: [f64; 3]) -> f64 {
    vector.iter().map(|v| v * v).sum::<f64>().sqrt()
}
