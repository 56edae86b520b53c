//! Bayer mosaics: each missing colour is the mean of the neighbours that have it.

use crate::{Image, ImageError};

/// Fills an image from a mosaic whose red pixels lie at `red` (column, row) of each square of four; the rows have been checked. A row has
/// `step` bytes, a pixel `bytes`, of which the first counts.
pub(crate) fn demosaic(
    image: &mut Image,
    [step, bytes]: [usize; 2],
    red: [usize; 2],
    data: &[u8],
) -> Result<(), ImageError> {
    let (width, height) = (image.width, image.height);
    if width < 2 || height < 2 {
        return Err(ImageError::Size {
            width: width as u64,
            height: height as u64,
        });
    }
    // Mirrored at the border, which keeps a neighbour's colour.
    let mirrored = |at: usize, by: isize, size: usize| match at.checked_add_signed(by) {
        Some(at) if at < size => at,
        Some(_) => size - 2,
        None => 1,
    };
    for row in 0..height {
        let rows = [-1, 0, 1].map(|by| mirrored(row, by, height) * step);
        for column in 0..width {
            let columns = [-1, 0, 1].map(|by| mirrored(column, by, width) * bytes);
            let value = |dx: usize, dy: usize| u16::from(data[rows[dy] + columns[dx]]);
            let own = value(1, 1);
            let across = (value(0, 1) + value(2, 1)).div_ceil(2);
            let down = (value(1, 0) + value(1, 2)).div_ceil(2);
            let cross = (value(0, 1) + value(2, 1) + value(1, 0) + value(1, 2) + 2) / 4;
            let corners = (value(0, 0) + value(2, 0) + value(0, 2) + value(2, 2) + 2) / 4;
            let of_red = [column % 2 == red[0], row % 2 == red[1]];
            let rgb = match of_red {
                [true, true] => [own, cross, corners],
                [false, true] => [across, own, down],
                [true, false] => [down, own, across],
                [false, false] => [corners, cross, own],
            };
            let at = 3 * (row * width + column);
            for (to, value) in image.rgb[at..at + 3].iter_mut().zip(rgb) {
                *to = value.min(255) as u8;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_colour_comes_back_from_each_mosaic() {
        let colour = [200u8, 90, 30];
        for red in [[0, 0], [1, 0], [0, 1], [1, 1]] {
            let (width, height) = (7, 5);
            let mut image = Image::default();
            image.resize(width as u64, height as u64).expect("small");
            let mut mosaic = vec![0; width * height];
            for row in 0..height {
                for column in 0..width {
                    let channel = match (column % 2 == red[0], row % 2 == red[1]) {
                        (true, true) => 0,
                        (false, false) => 2,
                        _ => 1,
                    };
                    mosaic[row * width + column] = colour[channel];
                }
            }
            demosaic(&mut image, [width, 1], red, &mosaic).expect("decodes");
            assert!(image.rgb.chunks(3).all(|pixel| pixel == colour), "{red:?}");
        }
    }
}
