//! Where a slide meets a fence that is known.

use values::{Point, Rig};

use super::frames::Frames;

/// Distance, in m, within which an object may touch a fence.
const NEAR_FENCE: f64 = 0.004;
/// Number of places tried on the way from one frame to the next.
const ON_THE_WAY: u32 = 8;

/// The first frame whose object may have touched a fence.
pub(super) fn met(frames: &Frames<'_>, first: usize, until: usize) -> Option<usize> {
    let all = &frames.frames;
    let last = until.min(all.len());
    (first..last).find(|at| {
        let seen = |at: usize| (all[at].t, all[at].point);
        let before = [at.checked_sub(2), at.checked_sub(1)].map(|i| i.map(seen));
        reaches_fence(frames.rig, before, seen(*at))
    })
}

/// Whether an object that is seen here, and was in the two frames before (times in s), may have touched a fence: it is near to one, or would
/// have met it on its way since the last frame, as fast as it was. Where it touches, frames are lost.
pub(crate) fn reaches_fence(
    rig: &Rig,
    before: [Option<(f64, Point)>; 2],
    (now, point): (f64, Point),
) -> bool {
    /// Longest time, in s, over which the last speed is taken to go on: later the object is slower and need not have come so far.
    const LONGEST: f64 = 0.1;
    let reach = rig.object.solid.reach();
    let is_within = |point: Point, reach: f64| {
        let mut fences = rig.table.fences.iter();
        fences.any(|fence| fence.distance(point) < reach)
    };
    let on_its_way = || {
        let [Some((first, from)), Some((then, last))] = before else {
            return false;
        };
        let velocity = (last - from) * (1.0 / (then - first).max(1e-6));
        let time = (now - then).min(LONGEST);
        (1..=ON_THE_WAY).any(|part| {
            let share = f64::from(part) / f64::from(ON_THE_WAY);
            is_within(last + velocity * (time * share), reach)
        })
    };
    !rig.table.fences.is_empty() && (is_within(point, reach + NEAR_FENCE) || on_its_way())
}

#[cfg(test)]
mod tests {
    use values::{Fence, Shape};

    use super::*;

    #[test]
    fn an_object_that_is_lost_as_it_touches_a_fence_touches_it() {
        let mut rig = Rig::demo(Shape::Cylinder);
        let reach = rig.object.solid.reach();
        rig.table.fences.push(Fence {
            from: Point::new(0.6 + reach, -0.5),
            to: Point::new(0.6 + reach, 0.5),
        });
        // 0.9 m/s towards it at 60 Hz.
        let frame = |i: f64| (i / 60.0, Point::new(0.57 + 0.015 * i, 0.0));
        let back = |i: f64| (i / 60.0, Point::new(0.59, 0.0));
        let touches = |now| reaches_fence(&rig, [Some(frame(-1.0)), Some(frame(0.0))], now);
        assert!(!touches(frame(1.0)));
        // Two frames are lost; the next one sees it on its way back.
        assert!(touches(back(3.0)));
    }
}
