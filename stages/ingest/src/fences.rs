//! Fences that the rig file does not state: straight lines at which many objects are turned round, or led along.
//!
//! A single bounce, or graze, is a hand, the arm's other end, or a frame astray. A fence is where many of them, of the whole data set, lie on
//! one line and come no farther from its one side.

use values::{Fence, Point, Rig};

use crate::bounces::{BREAK_NOISE, Bounce};
use crate::seen::Seen;

/// A fence that was found, and how often objects bounced there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundFence {
    /// The line that the object's edge meets.
    pub fence: Fence,
    /// Number of bounces at it.
    pub bounces: usize,
}

/// Least number of bounces at a fence, and the least part of all motions that they are.
const FEWEST: usize = 6;
const LEAST_SHARE: f64 = 0.02;
/// As many lines as differ are looked at, and chance lays this many bounces on one of them this seldom: the other player's mallet turns a
/// puck round anywhere. By chance as many lie on a line as lie beside it, in bands of its width on both sides, so many in all.
const LINES: f64 = 2_000.0;
const BY_CHANCE: f64 = 0.01;
const BANDS: f64 = 4.0;
/// Greatest distance from a fence's line of its bounces, in m and in deviations of the camera's noise.
const NEAR: f64 = 0.006;
const NEAR_NOISE: f64 = 3.0;
/// What turns an object round pushes it along the normal, but for friction: within this, in rad.
const ASIDE: f64 = 0.6;
/// What grazes a fence, or meets one that gives nothing back, goes on towards it with no more than this part of its velocity: by the camera's
/// noise alone.
const ONWARDS: f64 = 0.3;
/// Bounces nearer to one another than this give a line no direction, in m.
const APART: f64 = 0.05;
/// Pairs that are tried, and bounces that are looked at, at the most.
const MOST_PAIRS: usize = 20_000;
const MOST_BOUNCES: usize = 2_000;
/// Greatest number of fences of a table.
const MOST_FENCES: usize = 8;
/// Objects that touch a fence so slowly that no bounce shows do so beyond its last bounces too: a fence goes on by this part of the length
/// that bounces show. One that is stated too long ends a track that goes by its end a little early, which costs frames; one too short takes
/// a touched slide for a free one.
const BEYOND: f64 = 0.25;
/// Grid, in m, to which a fence's ends are rounded: a few more bounces leave it as it was.
const GRID: f64 = 0.002;

/// The fences that these logs show beside those that the rig file states.
pub fn fences<'a>(rig: &Rig, logs: impl IntoIterator<Item = &'a Seen>) -> Vec<FoundFence> {
    let reach = rig.object.solid.reach();
    let spread = reach - rig.object.solid.narrowest();
    let near = NEAR + NEAR_NOISE * rig.camera.noise + spread;
    let (mut bounces, mut motions) = (Vec::new(), 0);
    for seen in logs {
        let is_stated = |place: Point| {
            let mut stated = rig.table.fences.iter();
            stated.any(|fence| fence.distance(place) < reach + near)
        };
        // Errors of a camera that last for some frames move an object that rests.
        let least = BREAK_NOISE * seen.stirring().unwrap_or(0.0);
        let is_seen = |b: &&Bounce| (b.after - b.before).norm() >= least && !is_stated(b.place);
        bounces.extend(seen.bounces.iter().filter(is_seen).copied());
        motions += seen.motions.len();
    }
    let stride = bounces.len().div_ceil(MOST_BOUNCES).max(1);
    let mut bounces: Vec<Bounce> = bounces.into_iter().step_by(stride).collect();
    let least = FEWEST.max((LEAST_SHARE * motions as f64) as usize);
    let mut found = Vec::new();
    while found.len() < MOST_FENCES
        && let Some((line, at)) = best_line(&bounces, near)
        && stride * at.len() >= least
        && at.len() >= FEWEST
    {
        if !line.is_chance(at.len(), &bounces, near) {
            let places: Vec<Bounce> = at.iter().map(|i| bounces[*i]).collect();
            found.push(FoundFence {
                fence: line.fence(&places, reach),
                bounces: stride * at.len(),
            });
        }
        // One that is seen from one line's side is no part of another.
        let mut index = 0;
        bounces.retain(|_| {
            index += 1;
            !at.contains(&(index - 1))
        });
    }
    found
}

/// A line, and the normal from the side on which objects are.
#[derive(Clone, Copy, Debug)]
struct Line {
    through: Point,
    normal: Point,
}

impl Line {
    fn distance(&self, point: Point) -> f64 {
        (point - self.through).dot(self.normal)
    }

    fn turns(&self, bounce: &Bounce, near: f64) -> bool {
        let impulse = bounce.before - bounce.after;
        self.distance(bounce.place).abs() <= near
            && bounce.before.dot(self.normal) > 0.0
            && bounce.after.dot(self.normal) < ONWARDS * bounce.before.dot(self.normal)
            && impulse.dot(self.normal) >= ASIDE.cos() * impulse.norm()
    }

    fn turned(&self, bounces: &[Bounce], near: f64) -> Vec<usize> {
        (0..bounces.len())
            .filter(|i| self.turns(&bounces[*i], near))
            .collect()
    }

    /// Whether so many bounces may lie on it by chance alone.
    fn is_chance(&self, count: usize, bounces: &[Bounce], near: f64) -> bool {
        let about = self.turned(bounces, (1.0 + BANDS) * near).len();
        let expected = about.saturating_sub(count) as f64 / BANDS;
        // One less the probabilities of fewer, of Poisson's distribution.
        let (mut term, mut fewer) = ((-expected).exp(), 0.0);
        for k in 0..count {
            fewer += term;
            term *= expected / (k + 1) as f64;
        }
        LINES * (1.0 - fewer) > BY_CHANCE
    }

    /// Through the middle of bounces, along them where they tell a direction.
    fn through(bounces: &[Bounce]) -> Option<Self> {
        let n = bounces.len() as f64;
        let middle = bounces
            .iter()
            .fold(Point::default(), |sum, b| sum + b.place)
            * (1.0 / n);
        let away = bounces
            .iter()
            .fold(Point::default(), |sum, b| sum + (b.before - b.after));
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for bounce in bounces {
            let p = bounce.place - middle;
            xx += p.x * p.x;
            xy += p.x * p.y;
            yy += p.y * p.y;
        }
        let along = Point::polar(1.0, 0.5 * (2.0 * xy).atan2(xx - yy));
        let extent = bounces
            .iter()
            .map(|b| (b.place - middle).dot(along).abs())
            .fold(0.0, f64::max);
        let normal = if extent > APART {
            let normal = along.rotated(std::f64::consts::FRAC_PI_2);
            normal * normal.dot(away).signum()
        } else {
            away * (1.0 / away.norm().max(1e-12))
        };
        normal.is_finite().then_some(Self {
            through: middle,
            normal,
        })
    }

    /// Some way beyond what bounces show ([`BEYOND`]); the object's edge meets it.
    fn fence(&self, bounces: &[Bounce], reach: f64) -> Fence {
        let along = self.normal.rotated(std::f64::consts::FRAC_PI_2);
        let (low, high) = bounces
            .iter()
            .map(|b| (b.place - self.through).dot(along))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| {
                (low.min(s), high.max(s))
            });
        let beyond = reach + BEYOND * (high - low);
        let end = |s: f64| {
            let point = self.through + along * s + self.normal * reach;
            let rounded = |x: f64| (x / GRID).round() * GRID;
            // As it is written in a rig file.
            let tidy = |x: f64| (rounded(x) * 1e6).round() / 1e6;
            Point::new(tidy(point.x), tidy(point.y))
        };
        Fence {
            from: end(low - beyond),
            to: end(high + beyond),
        }
    }
}

/// The line at which most bounces are turned round, and which these are.
fn best_line(bounces: &[Bounce], near: f64) -> Option<(Line, Vec<usize>)> {
    let mut lines: Vec<Line> = bounces
        .iter()
        .filter_map(|bounce| Line::through(std::slice::from_ref(bounce)))
        .collect();
    let pairs = bounces.len() * bounces.len().saturating_sub(1) / 2;
    let stride = pairs.div_ceil(MOST_PAIRS).max(1);
    let all = (0..bounces.len()).flat_map(|i| (0..i).map(move |j| [i, j]));
    lines.extend(all.step_by(stride).filter_map(|[i, j]| {
        let pair = [bounces[i], bounces[j]];
        let is_apart = pair[0].place.distance(pair[1].place) > APART;
        Line::through(&pair).filter(|_| is_apart)
    }));
    let count = |line: &Line| bounces.iter().filter(|b| line.turns(b, near)).count();
    let mut best: Option<(usize, Line)> = None;
    for line in lines {
        let turned = count(&line);
        if best.is_none_or(|(most, _)| turned > most) {
            best = Some((turned, line));
        }
    }
    let (_, mut line) = best?;
    // By all that it turns, twice.
    for _ in 0..2 {
        let at: Vec<Bounce> = line
            .turned(bounces, near)
            .iter()
            .map(|i| bounces[*i])
            .collect();
        if let Some(refined) = Line::through(&at).filter(|refined| count(refined) >= at.len()) {
            line = refined;
        }
    }
    let at = line.turned(bounces, near);
    Some((line, at))
}

#[cfg(test)]
mod tests {
    use values::Shape;

    use super::*;

    fn bounce(x: f64, y: f64, towards: f64, back: f64) -> Bounce {
        Bounce {
            place: Point::new(x, y),
            before: Point::new(0.6, towards),
            after: Point::new(-0.3, back),
        }
    }

    fn seen(bounces: Vec<Bounce>) -> Seen {
        Seen {
            bounces,
            ..Seen::default()
        }
    }

    #[test]
    fn many_bounces_on_one_line_are_a_fence_and_bounces_all_over_the_table_are_none() {
        let rig = Rig::demo(Shape::Cylinder);
        let radius = rig.object.solid.reach();
        let on_line = (0..20).map(|i| {
            let y = -0.2 + 0.02 * f64::from(i);
            let off = 0.001 * (f64::from(i) * 2.1).sin();
            bounce(0.6 + 0.1 * y + off, y, 0.1, 0.05)
        });
        let stray = |i: u32| {
            let part = |k: f64| (f64::from(i) * k).fract();
            bounce(0.3 + 0.5 * part(0.618), -0.4 + 0.8 * part(0.414), 0.1, 0.0)
        };
        let all = seen(on_line.chain((0..10).map(stray)).collect());
        let found = fences(&rig, [&all]);
        let [one] = &found[..] else {
            panic!("{found:?}");
        };
        assert!(one.bounces >= 20 && one.bounces < 25, "{one:?}");
        let distance = one.fence.distance(Point::new(0.6, 0.0));
        assert!((distance - radius).abs() < 0.003, "{distance} {one:?}");
        // It goes on where objects that hardly touch it show no bounce.
        let reach = |y: f64| one.fence.distance(Point::new(0.6 + 0.1 * y, y));
        assert!(reach(-0.3) < 0.04 && reach(0.27) < 0.04, "{one:?}");
        assert_eq!(fences(&rig, [&seen((0..30).map(stray).collect())]), []);

        // Stated, it is not found again.
        let mut rig = rig;
        rig.table.fences.push(one.fence);
        assert_eq!(fences(&rig, [&all]), []);
    }

    #[test]
    fn what_another_mallet_turns_round_in_a_part_of_the_table_is_no_fence() {
        let rig = Rig::demo(Shape::Cylinder);
        let strokes = (0..45).map(|i| {
            let part = |k: f64| (f64::from(i * i) * k).fract();
            bounce(0.5 + 0.25 * part(0.618), -0.4 + 0.8 * part(0.414), 0.1, 0.0)
        });
        let strokes: Vec<Bounce> = strokes.collect();
        assert_eq!(fences(&rig, [&seen(strokes.clone())]), []);
        let wall = (0..20).map(|i| bounce(0.8, -0.3 + 0.03 * f64::from(i), 0.1, 0.05));
        let found = fences(&rig, [&seen(strokes.into_iter().chain(wall).collect())]);
        assert_eq!(found.len(), 1, "{found:?}");
    }

    #[test]
    fn what_a_cameras_errors_stir_of_resting_objects_is_no_fence() {
        let rig = Rig::demo(Shape::Cylinder);
        let found = |stir: f64| {
            let mut all = seen(
                (0..12)
                    .map(|i| bounce(0.6, 0.03 * f64::from(i), 0.1, 0.05))
                    .collect(),
            );
            all.bounces
                .iter_mut()
                .for_each(|b| (b.before.x, b.after.x) = (0.1, -0.1));
            all.stirs = vec![stir, -stir, 0.5 * stir, 1.5 * stir];
            fences(&rig, [&all]).len()
        };
        assert_eq!([found(0.005), found(0.04)], [1, 0]);
    }

    #[test]
    fn bounces_of_one_command_at_one_place_are_a_fence() {
        let rig = Rig::demo(Shape::Cylinder);
        let all = seen(
            (0..8)
                .map(|i| bounce(0.6, 0.001 * f64::from(i), 0.0, 0.0))
                .collect(),
        );
        assert_eq!(fences(&rig, [&all]).len(), 1);
    }
}
