//! The table as a log shows it without the object: the median of some of its images, and whether the camera still sees it where it was.

use rayon::prelude::*;

use crate::Image;
use crate::aligned::{Aligned, Alignment, Place};
use crate::colour::{Contrast, Map, Range};
use crate::flow::Flow;
use crate::spots::{GAIN, Spot, Spots};

#[derive(Clone, Debug)]
pub(crate) struct Background {
    image: Image,
    /// Whether each pixel was seen without the object.
    is_known: Vec<bool>,
    /// Whether each pixel has the object's colour in nearly all images: what is always there is not the object.
    is_coloured: Vec<bool>,
    /// Where its brightness shows a movement.
    spots: Spots,
    /// How far it has moved where the log begins.
    origin: Flow,
    /// Where a pushed camera sees it for a while.
    places: Vec<Place>,
}

/// An image, and the part of it (`[[x, y], [x, y]]`, px) where the object is.
pub(crate) type Pilot = (Image, [[f64; 2]; 2]);

/// Images from which a background is taken, at the least.
pub(crate) const FEWEST_PILOTS: usize = 5;
/// A pixel that has the object's colour in this share of the images has always had it.
const ALWAYS: f64 = 0.8;
/// Movements that differ by less px are one; none is known better than this (px).
const ONE_PLACE: f64 = 1.0;
const LEAST_DEVIATION: f64 = 0.03;
/// What has always had it reaches so many px farther: an edge is blurred, and a camera trembles.
const REACH: usize = 3;
/// A table that has more of the object's colour than this cannot be told from it.
const MOST_OWN: f32 = 0.79;
impl Background {
    /// The background of some images of one size, in their order; none where they are too few. Where the camera was pushed between them,
    /// it is that of those that see it from one place.
    pub(crate) fn of(pilots: &[Pilot], range: Option<&Range>) -> Option<Self> {
        let all: Vec<&Pilot> = pilots.iter().collect();
        let rests = |background: &Self, (image, _): &Pilot| {
            let aligned = background.align(image);
            aligned.is_some_and(|aligned| aligned.flow.farthest() == 0.0)
        };
        let with_places = |mut background: Self| {
            background.places = background.places_in(&all);
            background
        };
        let few = all.windows(FEWEST_PILOTS).find_map(|few| {
            let background = Self::of_all(few, range)?;
            few.iter()
                .all(|pilot| rests(&background, pilot))
                .then(|| with_places(background))
        });
        let of_one_place = few.and_then(|few| {
            let rest: Vec<&Pilot> = pilots.iter().filter(|pilot| rests(&few, pilot)).collect();
            Self::of_all(&rest, range)
        });
        let background = of_one_place.or_else(|| Self::of_all(&all, range))?;
        let mut background = with_places(background);
        let first = pilots.iter().find_map(|(image, _)| background.align(image));
        if let Some(first) = first {
            background.origin = first.flow;
        }
        Some(background)
    }

    /// The background of some images of one size, of a camera that does not move: what seems to is the light.
    pub(crate) fn at_rest(pilots: &[Pilot], range: Option<&Range>) -> Option<Self> {
        let all: Vec<&Pilot> = pilots.iter().collect();
        let mut background = Self::of_all(&all, range)?;
        background.spots.forget();
        Some(background)
    }

    fn of_all(pilots: &[&Pilot], range: Option<&Range>) -> Option<Self> {
        let (first, _) = *pilots.first()?;
        let (width, height) = (first.width, first.height);
        let is_alike = |(image, _): &&Pilot| image.width == width && image.height == height;
        if pilots.len() < FEWEST_PILOTS || !pilots.iter().all(is_alike) {
            return None;
        }
        let is_coloured = |pixel, grey| range.is_some_and(|range| range.contains(pixel, grey));
        let mut image = Image::default();
        image.resize(width as u64, height as u64).ok()?;
        image.grey = first.grey;
        let mut is_known = vec![false; width * height];
        let mut is_always = vec![false; width * height];
        let mut is_steady = vec![false; width * height];
        let rows = image.rgb.par_chunks_exact_mut(3 * width);
        let rows = rows.zip(is_known.par_chunks_exact_mut(width));
        let rows = rows.zip(is_always.par_chunks_exact_mut(width));
        let rows = rows.zip(is_steady.par_chunks_exact_mut(width));
        // The most images that may show another colour where the object's was always seen, of so many.
        let most_others = |seen: usize| seen - (ALWAYS * seen as f64).ceil() as usize;
        let each = |(row, (((rgb, known), always), steady)): Row<'_>| {
            let (mut seen, mut others) = (vec![pilots.len(); width], vec![0; width]);
            let row_of = |(image, [low, high]): &&Pilot| {
                let mut bytes = image.rgb[3 * width * row..][..3 * width].to_vec();
                let within = |at: f64| (at.ceil() as usize).min(width);
                let is_hidden = (low[1]..high[1]).contains(&(row as f64));
                let end = if is_hidden { within(high[0]) } else { 0 };
                let hidden = within(low[0]).min(end)..end;
                let pixels = bytes.as_chunks::<3>().0.iter().zip(&mut others);
                for (column, (pixel, others)) in pixels.enumerate() {
                    let may_be = *others <= most_others(pilots.len()) && !hidden.contains(&column);
                    *others += usize::from(may_be && !is_coloured(*pixel, image.grey));
                }
                seen[hidden.clone()].iter_mut().for_each(|seen| *seen -= 1);
                bytes[3 * hidden.start..3 * hidden.end].fill(u8::MAX);
                bytes
            };
            let mut rows: Vec<Vec<u8>> = pilots.iter().map(row_of).collect();
            sort_each(&mut rows);
            for (column, (seen, others)) in seen.into_iter().zip(others).enumerate() {
                let at = |share: f32, part: usize| {
                    let rank = (share * seen as f32) as usize;
                    (rank < seen).then(|| rows[rank][3 * column + part])
                };
                known[column] = seen >= FEWEST_PILOTS.min(pilots.len() / 2);
                always[column] = known[column] && others <= most_others(seen);
                for (part, median) in rgb[3 * column..][..3].iter_mut().enumerate() {
                    *median = at(0.5, part).unwrap_or_default();
                }
                steady[column] = are_near(at(0.25, 1), at(0.75, 1));
            }
        };
        rows.enumerate().for_each(each);
        let is_table = |column: usize, row: usize| {
            let at = row * width + column;
            let is_coloured = is_coloured(image.pixel(column, row), image.grey);
            is_known[at] && is_steady[at] && !is_coloured
        };
        let images = pilots.iter().map(|(image, _)| image);
        Some(Self {
            spots: Spots::find(&image, &is_table, images),
            image,
            is_known,
            is_coloured: grown(&is_always, width, height),
            origin: Flow::still([width, height]),
            places: Vec::new(),
        })
    }

    /// Where images in their order see it, if not where it was: several that follow one another show that better than each by itself.
    fn places_in(&self, pilots: &[&Pilot]) -> Vec<Place> {
        let seen = pilots.iter().map(|(image, _)| self.spots.seen(image));
        let seen: Vec<Vec<(Spot, f32)>> = seen.collect();
        let seen: Vec<&[(Spot, f32)]> = seen.iter().map(Vec::as_slice).collect();
        let unmoved = self.spots.still();
        let place = |few: &[&[(Spot, f32)]]| {
            let aligned = self.spots.align(&Spots::medians(few), &unmoved, &[])?;
            (aligned.flow.farthest() > 0.0).then_some(Place {
                flow: aligned.flow,
                deviation: aligned.deviation,
            })
        };
        let mut found: Vec<(Place, usize)> = Vec::new();
        for new in seen.windows(FEWEST_PILOTS).filter_map(place) {
            let is_it = |known: &Place| known.flow.since(&new.flow).farthest() < ONE_PLACE;
            match found.iter_mut().find(|(known, _)| is_it(known)) {
                Some((_, count)) => *count += 1,
                None => found.push((new, 1)),
            }
        }
        found.retain(|(_, count)| *count > 1);
        let flows: Vec<Flow> = found.iter().map(|(place, _)| place.flow).collect();
        let scatter = |seen: &[(Spot, f32)], flow: Flow| {
            let fit = self.spots.fitted::<GAIN>(seen, flow);
            fit.map_or(f32::INFINITY, |fit| fit.scatter)
        };
        let own = |flow: Flow| -> Option<Place> {
            let others = || flows.iter().copied().chain([unmoved]);
            let is_there = |seen: &&&[(Spot, f32)]| {
                let here = scatter(seen, flow);
                others().all(|other| here <= scatter(seen, other))
            };
            let there: Vec<&[(Spot, f32)]> = seen.iter().filter(is_there).copied().collect();
            let all = place(&there)?;
            let half = |first: usize| {
                let half: Vec<_> = there.iter().skip(first).step_by(2).copied().collect();
                place(&half)
            };
            let between = half(0)?.flow.since(&half(1)?.flow).farthest();
            Some(Place {
                deviation: all.deviation.hypot(0.5 * between).max(LEAST_DEVIATION),
                ..all
            })
        };
        flows.iter().filter_map(|flow| own(*flow)).collect()
    }

    /// How it lies in an image; none where it is not what is seen there.
    pub(crate) fn align(&self, image: &Image) -> Option<Aligned> {
        if image.width != self.image.width || image.height != self.image.height {
            return None;
        }
        let seen = self.spots.seen(image);
        self.spots.align(&seen, &self.origin, &self.places)
    }

    /// A pixel; none where it is not known.
    pub(crate) fn pixel(&self, x: f64, y: f64) -> Option<[u8; 3]> {
        self.known(within(x, self.image.width)?, within(y, self.image.height)?)
    }

    fn known(&self, column: usize, row: usize) -> Option<[u8; 3]> {
        self.is_known[row * self.image.width + column].then(|| self.image.pixel(column, row))
    }

    /// Makes values of a map the share of a pixel that is object: what the table has of the object's colour is taken off, where it is known.
    pub(crate) fn take_from(
        &self,
        map: &mut Map,
        contrast: &Contrast,
        codes: &[f32; 256],
        alignment: &Alignment,
    ) {
        let part = map.part;
        let [x, y] = alignment.shift;
        let gain = alignment.light.powf(1.0 / 2.2);
        let codes = codes.map(|code| gain * code);
        let columns = (part.left..).map(|column| within(column as f64 - x, self.image.width));
        let columns: Vec<Option<usize>> = columns.take(part.width).collect();
        for (row, values) in map.values.chunks_exact_mut(part.width).enumerate() {
            let Some(row) = within((part.top + row) as f64 - y, self.image.height) else {
                continue;
            };
            for (value, column) in values.iter_mut().zip(&columns) {
                if let Some(rgb) = column.and_then(|column| self.known(column, row)) {
                    let own = contrast.of(rgb.map(|byte| codes[usize::from(byte)]));
                    if own.abs() < MOST_OWN {
                        *value = (*value - own) / (1.0 - own);
                    }
                }
            }
        }
    }

    /// Whether a pixel has had the object's colour in nearly all images, the object elsewhere; false outside.
    pub(crate) fn is_coloured(&self, column: usize, row: usize) -> bool {
        let is_in = column < self.image.width && row < self.image.height;
        is_in && self.is_coloured[row * self.image.width + column]
    }
}

/// The pixel in which a place lies, of so many.
fn within(at: f64, size: usize) -> Option<usize> {
    let at = at.round();
    (at >= 0.0 && at < size as f64).then_some(at as usize)
}

/// A row of pixels: its number, bytes, and whether each pixel is known, always coloured and steady.
type Row<'a> = (
    usize,
    (
        ((&'a mut [u8], &'a mut [bool]), &'a mut [bool]),
        &'a mut [bool],
    ),
);

/// Whether most images show one brightness of a pixel, whatever a little light makes of it, by its quartiles: an arm comes and goes.
fn are_near(low: Option<u8>, high: Option<u8>) -> bool {
    /// Distance of the quartiles at the most, of 255, and of the brightness.
    const MOST: f32 = 8.0;
    const MOST_SHARE: f32 = 0.2;
    low.zip(high).is_some_and(|(low, high)| {
        let [low, high] = [low, high].map(f32::from);
        high - low <= MOST + MOST_SHARE * low
    })
}

/// Sorts the bytes at each place of some rows of one length: the least come to the first row. All places at once.
fn sort_each(rows: &mut [Vec<u8>]) {
    for end in (1..rows.len()).rev() {
        for at in 0..end {
            let [low, high] = &mut rows[at..at + 2] else {
                continue;
            };
            for (low, high) in low.iter_mut().zip(high) {
                (*low, *high) = ((*low).min(*high), (*low).max(*high));
            }
        }
    }
}

fn grown(is_set: &[bool], width: usize, height: usize) -> Vec<bool> {
    let mut grown = vec![false; is_set.len()];
    for (at, _) in is_set.iter().enumerate().filter(|(_, is_set)| **is_set) {
        let (column, row) = (at % width, at / width);
        for y in row.saturating_sub(REACH)..(row + REACH + 1).min(height) {
            let (from, to) = (
                column.saturating_sub(REACH),
                (column + REACH + 1).min(width),
            );
            grown[y * width + from..y * width + to].fill(true);
        }
    }
    grown
}
