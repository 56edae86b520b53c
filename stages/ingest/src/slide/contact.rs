//! Where a slide meets a fence that is known.

use values::{Point, Rig};

use super::frames::Frames;

/// An object this near to a fence may touch it, in m.
const NEAR_FENCE: f64 = 0.004;
/// Places that are looked at on the way from one frame to the next.
const ON_THE_WAY: u32 = 8;

/// The first frame whose object may have touched a fence.
pub(super) fn met(frames: &Frames<'_>, first: usize, until: usize) -> Option<usize> {
    let all = &frames.frames;
    let last = until.min(all.len());
    (first..last).find(|at| {
        let before = [at.checked_sub(2), at.checked_sub(1)].map(|i| i.map(|i| all[i].point));
        reaches_fence(frames.rig, before, all[*at].point)
    })
}

/// Whether an object here, which the two frames before saw there, may have touched a fence: it is near to one, or would have met it on
/// its way from the last frame, as fast as it was.
pub(crate) fn reaches_fence(rig: &Rig, before: [Option<Point>; 2], point: Point) -> bool {
    let reach = rig.object.solid.reach();
    let is_within = |point: Point, reach: f64| {
        let mut fences = rig.table.fences.iter();
        fences.any(|fence| fence.distance(point) < reach)
    };
    let on_its_way = || {
        let [Some(from), Some(last)] = before else {
            return false;
        };
        (1..=ON_THE_WAY).any(|part| {
            let share = f64::from(part) / f64::from(ON_THE_WAY);
            is_within(last + (last - from) * share, reach)
        })
    };
    !rig.table.fences.is_empty() && (is_within(point, reach + NEAR_FENCE) || on_its_way())
}
