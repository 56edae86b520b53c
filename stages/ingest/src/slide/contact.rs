//! Where a slide meets a fence that the rig file states.

use super::frames::Frames;

/// An object this near to a stated fence may touch it, in m.
const NEAR_FENCE: f64 = 0.004;

/// The first frame whose object may touch a fence that the rig file states.
pub(super) fn met(frames: &Frames<'_>, first: usize, until: usize) -> Option<usize> {
    let object = &frames.rig.object;
    let half_sides = object.half_size.map(|[x, y, _]| x.min(y));
    let reach = object.radius.or(half_sides).unwrap_or(0.0) + NEAR_FENCE;
    let fences = &frames.rig.table.fences;
    (first..until.min(frames.frames.len())).find(|at| {
        fences
            .iter()
            .any(|fence| fence.distance(frames.frames[*at].point) < reach)
    })
}
