//! How an object moved: states at equal steps, and what lies between them.

use values::Point;

/// Position, yaw (rad) and velocity at a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moment {
    pub at: Point,
    pub yaw: f64,
    pub velocity: Point,
}

/// The motion of the centre from the impact to rest.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    step: f64,
    moments: Vec<Moment>,
    stop: Point,
    yaw: f64,
    rest_time: f64,
}

impl Motion {
    pub(crate) fn still(at: Point, yaw: f64) -> Self {
        Self {
            step: 1.0,
            moments: Vec::new(),
            stop: at,
            yaw,
            rest_time: 0.0,
        }
    }

    pub(crate) fn new(step: f64, first: Moment) -> Self {
        Self {
            step,
            moments: vec![first],
            stop: first.at,
            yaw: first.yaw,
            rest_time: 0.0,
        }
    }

    /// Adds the next step's moment.
    pub(crate) fn push(&mut self, moment: Moment) {
        self.moments.push(moment);
    }

    /// Ends at rest, this long after the last moment.
    pub(crate) fn rest(mut self, stop: Point, after: f64) -> Self {
        self.rest_time = (self.moments.len() - 1) as f64 * self.step + after;
        self.stop = stop;
        self
    }

    /// Where it comes to rest, in m.
    pub(crate) fn stop(&self) -> Point {
        self.stop
    }

    pub(crate) fn rest_time(&self) -> f64 {
        self.rest_time
    }

    /// Position at a time after the impact (s), before it the first; cubic between steps.
    pub(crate) fn at(&self, time: f64) -> Point {
        let Some(&first) = self.moments.first() else {
            return self.stop;
        };
        if time <= 0.0 {
            return first.at;
        }
        let step = (time / self.step) as usize;
        let (Some(&from), true) = (self.moments.get(step), time < self.rest_time) else {
            return self.stop;
        };
        let into = time - step as f64 * self.step;
        let Some(&to) = self.moments.get(step + 1) else {
            // The last fraction of a step slows evenly to rest.
            let left = (self.rest_time - time) / (self.rest_time - step as f64 * self.step);
            return self.stop - (self.stop - from.at) * (left * left);
        };
        let s = into / self.step;
        let (s2, s3) = (s * s, s * s * s);
        from.at * (2.0 * s3 - 3.0 * s2 + 1.0)
            + from.velocity * ((s3 - 2.0 * s2 + s) * self.step)
            + to.at * (3.0 * s2 - 2.0 * s3)
            + to.velocity * ((s3 - s2) * self.step)
    }

    /// Yaw at a time after the impact (s), in rad; linear between steps, and that of the last one to rest.
    pub(crate) fn yaw(&self, time: f64) -> f64 {
        let step = (time / self.step).max(0.0);
        let yaw = |place: usize| {
            let last = self.moments.len().saturating_sub(1);
            self.moments
                .get(place.min(last))
                .map_or(self.yaw, |moment| moment.yaw)
        };
        let (from, to) = (yaw(step as usize), yaw(step as usize + 1));
        from + (to - from) * step.fract()
    }

    /// Every point passed, in m.
    pub(crate) fn points(&self) -> impl Iterator<Item = Point> {
        self.moments
            .iter()
            .map(|moment| moment.at)
            .chain([self.stop])
    }
}
