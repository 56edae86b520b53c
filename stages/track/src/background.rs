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
        let each = |(row, (((rgb, known), always), steady)): Row<'_>| {
            let mut seen: Vec<[u8; 3]> = Vec::with_capacity(pilots.len());
            for column in 0..width {
                seen.clear();
                let mut coloured = 0;
                for (image, [low, high]) in pilots.iter().copied() {
                    let (x, y) = (column as f64, row as f64);
                    let pixel = image.pixel(column, row);
                    if !(low[0]..high[0]).contains(&x) || !(low[1]..high[1]).contains(&y) {
                        seen.push(pixel);
                        coloured += usize::from(is_coloured(pixel, image.grey));
                    }
                }
                known[column] = seen.len() >= FEWEST_PILOTS.min(pilots.len() / 2);
                always[column] = known[column] && coloured as f64 >= ALWAYS * seen.len() as f64;
                let middle = seen.len() / 2;
                for i in 0..3 {
                    if !seen.is_empty() {
                        let (_, median, _) = seen.select_nth_unstable_by_key(middle, |rgb| rgb[i]);
                        rgb[3 * column + i] = median[i];
                    }
                }
                steady[column] = is_steady_in(&mut seen);
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

    /// Whether a pixel has had the object's colour in nearly all images, the object elsewhere.
    pub(crate) fn is_coloured(&self, column: usize, row: usize) -> bool {
        self.is_coloured[row * self.image.width + column]
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

/// Whether most images show one brightness of a pixel, whatever a little light makes of it: an arm comes and goes.
fn is_steady_in(seen: &mut [[u8; 3]]) -> bool {
    /// Distance of the quartiles at the most, of 255, and of the brightness.
    const MOST: f32 = 8.0;
    const MOST_SHARE: f32 = 0.2;
    seen.sort_unstable_by_key(|rgb| rgb[1]);
    let at = |share: f32| seen.get((share * seen.len() as f32) as usize);
    match (at(0.25), at(0.75)) {
        (Some(low), Some(high)) => {
            let [low, high] = [low, high].map(|rgb| f32::from(rgb[1]));
            high - low <= MOST + MOST_SHARE * low
        }
        _ => false,
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
