//! Where the object may be: blobs of its colour on a coarse grid of pixels.

use crate::Image;
use crate::background::Background;

/// Pixels of the object's colour that touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Blob {
    /// Its area in px².
    pub(crate) area: f64,
    /// Its centroid in px.
    pub(crate) centre: [f64; 2],
    /// How far it reaches from there to the side and up or down, in px.
    pub(crate) reach: [f64; 2],
}

/// Finds the blobs among every `stride`-th pixel of every `stride`-th row, the largest first. Those of one grid point are noise,
/// and what has always had the object's colour is not the object.
pub(crate) fn blobs(
    image: &Image,
    is_object: impl Fn([u8; 3]) -> bool,
    stride: usize,
    background: Option<&Background>,
) -> Vec<Blob> {
    let half = stride / 2;
    let columns = (image.width - half.min(image.width)).div_ceil(stride);
    let rows = (image.height - half.min(image.height)).div_ceil(stride);
    let mut runs: Vec<Run> = Vec::new();
    let mut above = 0..0;
    for row in 0..rows {
        let begin = runs.len();
        let mut open = None;
        for column in 0..columns {
            let (x, y) = (half + column * stride, half + row * stride);
            let is_in = is_object(image.pixel(x, y))
                && !background.is_some_and(|background| background.is_coloured(x, y));
            match (is_in, open) {
                (true, None) => open = Some(column),
                (false, Some(from)) => {
                    runs.push(Run::new(row, from, column, runs.len()));
                    open = None;
                }
                _ => {}
            }
        }
        if let Some(from) = open {
            runs.push(Run::new(row, from, columns, runs.len()));
        }
        join(&mut runs, above, begin);
        above = begin..runs.len();
    }
    gather(&mut runs, stride)
}

/// Grid points of a row from one column up to another, and the run that stands for their blob.
#[derive(Clone, Copy)]
struct Run {
    row: usize,
    from: usize,
    to: usize,
    parent: usize,
}

impl Run {
    fn new(row: usize, from: usize, to: usize, index: usize) -> Self {
        Self {
            row,
            from,
            to,
            parent: index,
        }
    }
}

/// Joins the runs from `begin` on with those of the row above that they touch, corners included.
fn join(runs: &mut [Run], above: std::ops::Range<usize>, begin: usize) {
    let mut first = above.start;
    for index in begin..runs.len() {
        let run = runs[index];
        while first < above.end && runs[first].to < run.from {
            first += 1;
        }
        let mut other = first;
        while other < above.end && runs[other].from <= run.to {
            let (a, b) = (root(runs, index), root(runs, other));
            runs[a.max(b)].parent = a.min(b);
            other += 1;
        }
    }
}

fn root(runs: &mut [Run], mut index: usize) -> usize {
    while runs[index].parent != index {
        runs[index].parent = runs[runs[index].parent].parent;
        index = runs[index].parent;
    }
    index
}

fn gather(runs: &mut [Run], stride: usize) -> Vec<Blob> {
    let mut sums = vec![[0.0; 3]; runs.len()];
    let mut bounds = vec![
        [
            f64::INFINITY,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NEG_INFINITY
        ];
        runs.len()
    ];
    for index in 0..runs.len() {
        let run = runs[index];
        let count = (run.to - run.from) as f64;
        let root = root(runs, index);
        let [left, top, right, bottom] = &mut bounds[root];
        *left = left.min(run.from as f64);
        *top = top.min(run.row as f64);
        *right = right.max(run.to as f64);
        *bottom = bottom.max(run.row as f64 + 1.0);
        let sum = &mut sums[root];
        sum[0] += count;
        sum[1] += count * 0.5 * (run.from + run.to - 1) as f64;
        sum[2] += count * run.row as f64;
    }
    let (scale, half) = (stride as f64, (stride / 2) as f64);
    let mut blobs: Vec<Blob> = sums
        .into_iter()
        .zip(bounds)
        .filter(|([count, ..], _)| *count > 1.0)
        .map(|([count, x, y], [left, top, right, bottom])| {
            let [x, y] = [x / count, y / count];
            Blob {
                area: count * scale * scale,
                centre: [half + scale * x, half + scale * y],
                reach: [(x - left).max(right - x), (y - top).max(bottom - y)]
                    .map(|reach| scale * reach),
            }
        })
        .collect();
    blobs.sort_by(|a, b| b.area.total_cmp(&a.area));
    blobs
}

#[cfg(test)]
mod tests {
    use values::Colour;

    use crate::colour::Range;

    use super::*;

    fn painted(is_object: impl Fn(usize, usize) -> bool) -> Image {
        let mut image = Image::default();
        image.resize(120, 80).expect("small");
        for row in 0..80 {
            for column in 0..120 {
                let pixel = if is_object(column, row) {
                    [200, 40, 40]
                } else {
                    [120, 120, 120]
                };
                image.rgb[3 * (row * 120 + column)..][..3].copy_from_slice(&pixel);
            }
        }
        image
    }

    #[test]
    fn blobs_are_distinguished_and_a_ring_is_one() {
        let far = |c: usize, r: usize, x: f64, y: f64| (c as f64 - x).hypot(r as f64 - y);
        let image = painted(|c, r| {
            (8.0..14.0).contains(&far(c, r, 30.0, 40.0)) || far(c, r, 90.0, 30.0) < 9.0
        });
        let range = Range::of(&Colour::demo());
        for stride in [1, 2, 3] {
            let blobs = blobs(&image, |rgb| range.contains(rgb, false), stride, None);
            assert_eq!(blobs.len(), 2, "stride {stride}");
            let near = |blob: &Blob, x: f64, y: f64| {
                (blob.centre[0] - x).abs() < 1.0 && (blob.centre[1] - y).abs() < 1.0
            };
            assert!(near(&blobs[0], 30.0, 40.0), "{blobs:?}");
            assert!(near(&blobs[1], 90.0, 30.0), "{blobs:?}");
        }
    }
}
