//! How a table lies in an image: where the camera was pushed or turned, and how bright it is.

use crate::flow::Flow;
use crate::spots::{ALL, FARTHEST, Fitted, GAIN, SHIFT, Spot, Spots, TURNED};

/// How a background lies in a part of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Alignment {
    /// How far it has moved there, in px.
    pub(crate) shift: [f64; 2],
    /// How bright it is, of its own light.
    pub(crate) light: f32,
}

/// How a background lies in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Aligned {
    pub(crate) flow: Flow,
    /// How far it has moved since the log began: what is known of the camera is of then.
    pub(crate) moved: Flow,
    /// How well that is known: standard deviation in px, nothing where it has not moved.
    pub(crate) deviation: f64,
    light: f32,
}

impl Aligned {
    /// An image that has not moved since the one before.
    pub(crate) fn still() -> Self {
        Self {
            flow: Flow::still([0; 2]),
            moved: Flow::still([0; 2]),
            deviation: 0.0,
            light: 1.0,
        }
    }

    pub(crate) fn near(&self, pixel: [f64; 2]) -> Alignment {
        Alignment {
            shift: self.flow.at(pixel),
            light: self.light,
        }
    }
}

/// The step (px) in which a far movement is searched for, and the spots by which it is.
const COARSE: f64 = 3.0;
const SEARCHED: usize = 250;
/// Cells across an image in which light is even, and most of a spot's brightness, of 255.
const CELLS: usize = 4;
const MOST_OFF: f32 = 20.0;
/// What is left, of its noise, where a turn is worth a fit, and where a far movement is worth the search.
const NOISY: f32 = 1.1;
const ODD: f32 = 2.0;
/// Places from which a fit begins, and how far from one another two are others, in px.
const STARTS: usize = 6;
const APART: f64 = 3.0;
/// A movement of so many px is far; what is left where it has moved far, of what is left where it has not.
const FAR: f64 = 2.0;
const FAR_BETTER: f32 = 0.7;
/// A movement that is known to this (px) is known; one of less than the least, or of less than so many deviations, is none.
const KNOWN: f64 = 0.16;
const LEAST_SHIFT: f64 = 0.5;
const SURE: f64 = 8.0;
/// How far compression's grid holds a table back (standard deviation, px) that shows no more than it.
const OF_GRID: f64 = 0.5;
/// Deviations below which a turn is none: what moves on the table imitates one.
const SURE_TURNED: f64 = 16.0;
/// Where the background scatters by so many times its noise, and this much of 255, it is not where it was.
const ELSEWHERE: f32 = 3.0;
const LEAST_ELSEWHERE: f32 = 5.0;

/// Where several images of a log see the table, and how well that is known (standard deviation, px).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) flow: Flow,
    pub(crate) deviation: f64,
}

impl Spots {
    /// How the table lies in an image of which these spots are seen; none where it is not what is seen there. `origin` is how it lay where the
    /// log began, `places` where others of its images see it: one image alone shows by far less well where it lies than at which of these.
    pub(crate) fn align(
        &self,
        seen: &[(Spot, f32)],
        origin: &Flow,
        places: &[Place],
    ) -> Option<Aligned> {
        if !self.shows_movement() {
            return Some(Aligned::still());
        }
        let at = |place: &Place| {
            let lit = self.brightness(seen, &place.flow)?;
            let fit = self.fitted_from::<GAIN>(seen, place.flow, lit)?;
            Some((fit, lit, place.deviation))
        };
        let unmoved = Place {
            flow: self.still(),
            deviation: 0.0,
        };
        let known = std::iter::once(&unmoved).chain(places).filter_map(at);
        let known = known.min_by(|(a, ..), (b, ..)| a.scatter.total_cmp(&b.scatter));
        let (still, lit, known_to) = known?;
        let most = LEAST_ELSEWHERE.max(ELSEWHERE * self.noise);
        let likely = |fit: &Fitted| fit.scatter <= most;
        let shifted = |start: Flow| self.fitted::<SHIFT>(seen, start).filter(likely);
        let moved = self.fitted_from::<SHIFT>(seen, still.flow, lit);
        let mut moved = moved.filter(likely);
        let near = moved.map_or(still, |moved| moved.least(still));
        if near.scatter > ODD * self.noise {
            let starts = self.searched(seen, still.gain).into_iter();
            let mut far: Vec<Fitted> = starts
                .filter_map(|start| shifted(self.still().moved(start)))
                .filter(|far| far.scatter < FAR_BETTER * near.scatter)
                .collect();
            far.sort_by(|a, b| a.scatter.total_cmp(&b.scatter));
            if let Some(best) = far.first().copied() {
                let is_other = |other: &Fitted| {
                    other.flow.since(&best.flow).farthest() > APART
                        && FAR_BETTER * other.scatter < best.scatter
                };
                // A pattern that repeats fits at several places.
                if far.iter().any(is_other) {
                    return None;
                }
                moved = Some(best);
            }
        }
        // A camera that was pushed is mostly turned as well.
        let from = moved.map_or(still.flow, |fit| fit.flow);
        let is_odd = still.scatter > NOISY * self.noise;
        let turned = is_odd.then(|| self.fitted::<TURNED>(seen, from)).flatten();
        let from = turned.map_or(from, |fit| fit.flow);
        let tilted = is_odd.then(|| self.fitted::<ALL>(seen, from)).flatten();
        // The last that is surely better than all that are simpler.
        let (mut best, mut least) = (None, still);
        for (fit, sure) in [(moved, SURE), (turned, SURE_TURNED), (tilted, SURE_TURNED)] {
            let Some(fit) = fit.filter(|fit| fit.scatter <= most && fit.deviation < KNOWN) else {
                continue;
            };
            let is_moved =
                fit.flow.since(&still.flow).farthest() > LEAST_SHIFT.max(SURE * fit.deviation);
            if is_moved && fit.is_better(&least, sure) {
                best = Some(fit);
            }
            least = fit.least(least);
        }
        let fit = best.unwrap_or(still);
        // It has moved, and how far is not known.
        let is_elsewhere = best.is_none()
            && moved.is_some_and(|moved| {
                let far = moved.flow.since(&still.flow).farthest();
                moved.scatter < FAR_BETTER * still.scatter && far > FAR
            });
        if is_elsewhere {
            return None;
        }
        let moved = fit.flow.since(origin);
        let is_moved = moved.farthest() > LEAST_SHIFT;
        (fit.scatter <= most).then_some(Aligned {
            flow: fit.flow,
            moved: if is_moved { moved } else { self.still() },
            deviation: if is_moved {
                // What scatters from image to image scatters alike in all spots, for a part: compression has its grid, which stays.
                let share = (fit.scatter / self.steepness).min(1.0);
                let known_to = best.map_or(known_to, |fit| fit.deviation);
                known_to.hypot(OF_GRID * f64::from(share))
            } else {
                0.0
            },
            // Of light, from bytes.
            light: fit.gain.max(0.1).powf(2.2) as f32,
        })
    }

    /// The shifts, to some px, at which spots look most as they did.
    fn searched(&self, seen: &[(Spot, f32)], gain: f64) -> Vec<[f64; 2]> {
        let few = seen.len().div_ceil(SEARCHED);
        let mut offs = Vec::with_capacity(SEARCHED);
        let mut off = |[x, y]: [f64; 2]| {
            offs.clear();
            let mut means = [(0.0f32, 0.0f32); CELLS * CELLS];
            for (spot, value) in seen.iter().step_by(few) {
                let at = [spot.column as f64 - x, spot.row as f64 - y].map(|part| part as f32);
                if let Some(luma) = self.luma_at(at[0], at[1]) {
                    let cell = CELLS * (CELLS * spot.row / self.size[1])
                        + CELLS * spot.column / self.size[0];
                    let off = value - gain as f32 * luma;
                    means[cell].0 += off;
                    means[cell].1 += 1.0;
                    offs.push((cell, off));
                }
            }
            // What a part of the image is brighter by is light.
            let beside = |(cell, off): &(usize, f32)| {
                let (sum, count) = means[*cell];
                (off - sum / count).abs().min(MOST_OFF)
            };
            offs.iter().map(beside).sum::<f32>() / offs.len().max(1) as f32
        };
        let steps = (FARTHEST / COARSE) as i32;
        let step = |k: i32| f64::from(k) * COARSE;
        let all = (-steps..=steps).flat_map(|x| (-steps..=steps).map(move |y| [step(x), step(y)]));
        let mut all: Vec<(f32, [f64; 2])> = all.map(|at| (off(at), at)).collect();
        all.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let mut best: Vec<[f64; 2]> = Vec::new();
        for (_, [x, y]) in all {
            let is_near = |other: &[f64; 2]| (other[0] - x).hypot(other[1] - y) < 2.0 * APART;
            if best.len() < STARTS && !best.iter().any(is_near) {
                best.push([x, y]);
            }
        }
        best
    }
}
