//! Lines on images, for people.

use std::io::Cursor;

use crate::{Image, Observation};

const TRUSTED: [u8; 3] = [0, 230, 0];
const NOT_TRUSTED: [u8; 3] = [255, 160, 0];
/// Half the length of the cross at the centroid, in px.
const ARM: f64 = 6.0;

pub(crate) fn drawn(image: &Image, observation: &Observation) -> Option<Vec<u8>> {
    let mut image = image.clone();
    draw_observation(&mut image, observation);
    jpeg_of(&image)
}

/// Draws an outline, and a cross at its centroid: green where they are trusted, orange where not.
pub fn draw_observation(image: &mut Image, observation: &Observation) {
    let colour = if observation.centre.is_ok() {
        TRUSTED
    } else {
        NOT_TRUSTED
    };
    draw_outline(image, &observation.outline, colour);
    if let Some(pixel) = observation.pixel {
        draw_cross(image, pixel, ARM, colour);
    }
}

/// Draws a closed line through points (px).
fn draw_outline(image: &mut Image, outline: &[[f64; 2]], colour: [u8; 3]) {
    let next = outline.iter().cycle().skip(1);
    for (from, to) in outline.iter().zip(next) {
        line(image, *from, *to, colour);
    }
}

/// Draws a cross at a point (px) with arms of so many px.
fn draw_cross(image: &mut Image, [x, y]: [f64; 2], arm: f64, colour: [u8; 3]) {
    line(image, [x - arm, y], [x + arm, y], colour);
    line(image, [x, y - arm], [x, y + arm], colour);
}

fn line(image: &mut Image, from: [f64; 2], to: [f64; 2], colour: [u8; 3]) {
    let far = (to[0] - from[0]).abs().max((to[1] - from[1]).abs());
    // Of a point that lies far beyond the image nothing is drawn.
    let steps = far.ceil().max(1.0);
    if !far.is_finite() || steps > 4.0 * (image.width + image.height) as f64 {
        return;
    }
    for step in 0..=steps as usize {
        let share = step as f64 / steps;
        let [x, y] = [0, 1].map(|i| (from[i] + share * (to[i] - from[i])).round());
        if x >= 0.0 && y >= 0.0 && x < image.width as f64 && y < image.height as f64 {
            let at = 3 * (y as usize * image.width + x as usize);
            image.rgb[at..at + 3].copy_from_slice(&colour);
        }
    }
}

/// The image as PNG; none where it has no pixels.
pub fn png_of(image: &Image) -> Option<Vec<u8>> {
    let mut data = Cursor::new(Vec::new());
    let (width, height) = (u32::try_from(image.width), u32::try_from(image.height));
    let mut encoder = png::Encoder::new(&mut data, width.ok()?, height.ok()?);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(&image.rgb).ok()?;
    writer.finish().ok()?;
    Some(data.into_inner())
}

/// The image as JPEG, small enough for a viewer's log; none where it is too large for JPEG.
pub(crate) fn jpeg_of(image: &Image) -> Option<Vec<u8>> {
    /// A quality at which lines of a pixel are seen.
    const QUALITY: u8 = 85;
    let mut data = Vec::new();
    let (width, height) = (u16::try_from(image.width), u16::try_from(image.height));
    let encoder = jpeg_encoder::Encoder::new(&mut data, QUALITY);
    let colours = jpeg_encoder::ColorType::Rgb;
    encoder
        .encode(&image.rgb, width.ok()?, height.ok()?, colours)
        .ok()?;
    Some(data)
}
