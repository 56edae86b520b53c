//! What repeats of a set's own commands really scatter by: the floor that a diagnosis should find.

use rig::{Sim, StrikeTruth};
use values::Point;

use super::cases::Drawn;

/// Commands of the set that are repeated, and how often each is: the floor is then known to some 3 %.
const COMMANDS: usize = 40;
const TIMES: u64 = 12;
/// Frames this long after rest are free of stamps' errors, in s; so many must be seen.
const SETTLED: f64 = 0.1;
const FRAMES: usize = 5;

/// Root mean square distance of measured stops from their command's mean, in m: all noise of the set but a wander, which repeats of one hour
/// do not show. None where hardly a stop is seen.
pub(super) fn repeats(drawn: &Drawn, really: &[StrikeTruth]) -> Option<f64> {
    let mut truth = drawn.truth.clone();
    truth
        .noise
        .0
        .retain(|kind| kind.name() != "friction_wander");
    let seed = truth.seed;
    let sims: Vec<Sim> = (1..=TIMES)
        .map(|time| {
            truth.seed = seed + 1_000_000_000 * time;
            Sim::from(truth.clone())
        })
        .collect::<Result<_, _>>()
        .ok()?;
    let step = really.len().div_ceil(COMMANDS).max(1);
    let (mut squares, mut freedom) = (0.0, 0.0);
    for strike in really.iter().step_by(step) {
        let stops: Vec<Point> = sims.iter().filter_map(|sim| again(sim, strike)).collect();
        if stops.len() < 2 {
            continue;
        }
        let sum = stops.iter().fold(Point::default(), |sum, stop| sum + *stop);
        let mean = sum * (1.0 / stops.len() as f64);
        squares += stops.iter().map(|s| s.distance(mean).powi(2)).sum::<f64>();
        freedom += stops.len() as f64 - 1.0;
    }
    (freedom > 20.0).then(|| (squares / freedom).sqrt())
}

/// Where the camera reports that the same strike stops: the median of its frames at rest, in m.
fn again(sim: &Sim, strike: &StrikeTruth) -> Option<Point> {
    let seen = sim.truth().see(strike.initial, strike.index());
    let recording = sim
        .clone()
        .after(strike.order)
        .in_session(strike.session)
        .strike(seen, strike.command);
    let rest = recording.truth.impact + ((recording.truth.rest_time + SETTLED) * 1e9) as u64;
    let frames = recording
        .samples
        .centroids
        .iter()
        .filter(|f| f.stamp > rest);
    let (mut x, mut y): (Vec<f64>, Vec<f64>) = frames.map(|f| (f.x, f.y)).unzip();
    if x.len() < FRAMES {
        return None;
    }
    x.sort_by(f64::total_cmp);
    y.sort_by(f64::total_cmp);
    Some(Point::new(x[x.len() / 2], y[y.len() / 2]))
}
