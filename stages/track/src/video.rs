//! H.264 video, one image a message, as `foxglove.CompressedVideo` demands it: Annex B, no B-frames, parameter sets before every key frame.
//!
//! An image builds on those before it: what follows a damaged one is not given until the next key frame.

use std::panic::{AssertUnwindSafe, catch_unwind};

use rust_h264::decoder::{ChromaFormat, Decoder, Frame};
use rust_h264::nal::{NalUnit, NalUnitType, parse_annex_b, parse_sps_info};

use crate::ImageError;
use crate::image::{Image, checked_size};
use crate::size::MOST_BYTES;
use crate::video_headers::{Numbering, SliceStart};

/// Decodes the images of one video in their order.
#[derive(Default)]
pub(crate) struct Video {
    decoder: Decoder,
    /// Whether all images since the last key frame were decoded.
    is_whole: bool,
    /// Whether it has images that are shown in another order than they are sent.
    is_reordered: bool,
    /// How its reference images are numbered, and the number of the last one.
    numbering: Option<Numbering>,
    last: u32,
    /// Whether its colours are those of BT.709, else of BT.601.
    is_bt709: bool,
    /// Whether its samples go from 0 to 255, else from 16 to 235.
    is_full: bool,
}

/// Most images that an image may refer to, and the number of BT.709's colours (ITU-T H.264, A.3.1 and table E-5).
const MOST_REFERENCES: u32 = 16;
const BT_709: u8 = 1;
/// Bytes of pixels that are given back before the next image is decoded.
const LARGE: usize = 8 << 20;
/// Tenths of bytes that the decoder takes for each pixel of the image that it decodes, of one slice or of several (it copies what it has
/// before each further one), and for each of every image that it may refer to: samples, and how blocks move. Measured with one to sixteen
/// such images of 1080 to 2160 rows.
const ONE_SLICE: usize = 75;
const SLICES: usize = 95;
const REFERENCE: usize = 27;

/// Whether an access unit is a key frame, with which a video can begin.
pub(crate) fn is_key_frame(data: &[u8]) -> bool {
    let nals = parse_annex_b(data);
    nals.iter()
        .any(|nal| nal.nal_unit_type == NalUnitType::SliceIdr)
}

impl std::fmt::Debug for Video {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut debug = f.debug_struct("Video");
        debug.field("is_whole", &self.is_whole);
        debug.finish_non_exhaustive()
    }
}

impl Video {
    /// Decodes the next image.
    ///
    /// # Errors
    /// Another format, damage, an image that builds on what was not decoded, more pixels than are read.
    pub(crate) fn decode(
        &mut self,
        format: &str,
        data: &[u8],
        image: &mut Image,
    ) -> Result<(), ImageError> {
        if format != "h264" {
            return Err(ImageError::Video(format.into()));
        }
        let nals = parse_annex_b(data);
        if nals.is_empty() {
            return Err(wrong("it holds no start code of Annex B"));
        }
        let is_key = nals
            .iter()
            .any(|nal| nal.nal_unit_type == NalUnitType::SliceIdr);
        if is_key {
            self.decoder = Decoder::new();
        } else if !self.is_whole {
            return Err(wrong(LOST));
        }
        // Until it is known to be whole.
        self.is_whole = false;
        // The pixels of so large an image are not held beside what the decoder takes.
        if image.rgb.len() > LARGE {
            *image = Image::default();
        }
        let slices = [NalUnitType::SliceIdr, NalUnitType::Slice];
        let is_slice = |nal: &&NalUnit<'_>| slices.contains(&nal.nal_unit_type);
        let is_in_one = nals.iter().filter(is_slice).count() < 2;
        for nal in nals
            .iter()
            .filter(|nal| nal.nal_unit_type == NalUnitType::Sps)
        {
            let info = parse_sps_info(nal).map_err(wrong)?;
            let size = checked_size(info.coded_width.into(), info.coded_height.into())?;
            if info.reference_frames > MOST_REFERENCES {
                return Err(wrong("it refers to more images than the format allows"));
            }
            check_video(size, info.reference_frames as usize, is_in_one)?;
            self.is_bt709 = info.matrix == BT_709;
            self.is_full = info.full_range;
            self.is_reordered |= info.max_reorder_frames.is_some_and(|frames| frames > 0);
            self.numbering = Numbering::of(&nal.rbsp);
        }
        self.check_order(&nals)?;
        let frame = self.frame(&nals)?;
        let colours = Colours::new(self.is_bt709, self.is_full);
        pixels(&frame, &colours, image)?;
        self.is_whole = true;
        Ok(())
    }

    /// Checks that no image is shown before one that was sent earlier, and that none is missing before this one.
    fn check_order(&mut self, nals: &[NalUnit<'_>]) -> Result<(), ImageError> {
        let mut next = self.last;
        for nal in nals {
            let is_key = nal.nal_unit_type == NalUnitType::SliceIdr;
            if !is_key && nal.nal_unit_type != NalUnitType::Slice {
                continue;
            }
            let slice = SliceStart::of(&nal.rbsp, self.numbering);
            let slice = slice.ok_or_else(|| wrong("the header of a slice is damaged"))?;
            self.is_reordered |= slice.is_bidirectional;
            let Some((numbering, number)) = self.numbering.zip(slice.number) else {
                continue;
            };
            let expected = if is_key {
                0
            } else {
                numbering.after(self.last)
            };
            if number != expected {
                return Err(wrong(LOST));
            }
            if nal.nal_ref_idc > 0 {
                next = number;
            }
        }
        self.last = next;
        if self.is_reordered {
            return Err(wrong(REORDERED));
        }
        Ok(())
    }

    fn frame(&mut self, nals: &[NalUnit<'_>]) -> Result<Frame, ImageError> {
        // What the decoder does not foresee of a damaged stream is an error of that stream, not of the program.
        let decoder = &mut self.decoder;
        let decoded = catch_unwind(AssertUnwindSafe(|| {
            for nal in nals {
                if decoder.decode_nal(nal).map_err(wrong)?.is_some() {
                    return Err(wrong("a message holds more than one image"));
                }
            }
            decoder.flush().ok_or_else(|| wrong("it holds no image"))
        }));
        decoded.unwrap_or_else(|_| Err(wrong("its decoder gave up")))
    }
}

/// Checks that there is room for what the decoder takes of images of this size, and their pixels as RGB, where these are there at that time.
///
/// # Errors
/// It takes more than [`MOST_BYTES`].
fn check_video(
    [width, height]: [usize; 2],
    references: usize,
    is_in_one: bool,
) -> Result<(), ImageError> {
    let pixels = width * height;
    let rgb = if 3 * pixels > LARGE { 0 } else { 3 * pixels };
    let decoded = if is_in_one { ONE_SLICE } else { SLICES };
    let bytes = rgb + pixels * (decoded + REFERENCE * references) / 10;
    if bytes > MOST_BYTES {
        return Err(ImageError::VideoMemory {
            width,
            height,
            references,
            bytes,
        });
    }
    Ok(())
}

const LOST: &str = "it builds on an image before it that is not there or damaged";
const REORDERED: &str =
    "the video has B-frames; encode without them (x264: --bframes 0 or --tune zerolatency)";

fn wrong(why: impl std::fmt::Display) -> ImageError {
    ImageError::Compressed("H.264", why.to_string())
}

/// From Y'CbCr to R'G'B', in parts of 65536.
struct Colours {
    luma: (i32, i32),
    /// Factors of Cr to red, of Cb and Cr to green, of Cb to blue.
    chroma: [i32; 4],
}

impl Colours {
    /// Source: ITU-R BT.601 and BT.709, sections 3.
    fn new(is_bt709: bool, is_full: bool) -> Self {
        let (red, blue) = if is_bt709 {
            (0.2126, 0.0722)
        } else {
            (0.299, 0.114)
        };
        let green = 1.0 - red - blue;
        let (luma, least, chroma) = if is_full {
            (1.0, 0, 1.0)
        } else {
            (255.0 / 219.0, 16, 255.0 / 224.0)
        };
        let parts = |share: f64| (65_536.0 * share).round() as i32;
        let [to_red, to_blue] = [red, blue].map(|own| 2.0 * (1.0 - own) * chroma);
        Self {
            luma: (parts(luma), least),
            chroma: [
                parts(to_red),
                parts(to_blue * blue / green),
                parts(to_red * red / green),
                parts(to_blue),
            ],
        }
    }
}

fn pixels(frame: &Frame, colours: &Colours, image: &mut Image) -> Result<(), ImageError> {
    if frame.bit_depth != 8 || frame.chroma_format != ChromaFormat::Yuv420 {
        return Err(wrong("it is not 8 bits a sample, 4:2:0"));
    }
    let [width, height] = checked_size(frame.width.into(), frame.height.into())?;
    let (across, down) = (
        frame.chroma_width() as usize,
        frame.chroma_height() as usize,
    );
    let is_complete = frame.y.len() >= width * height
        && frame.u.len().min(frame.v.len()) >= across * down
        && across.min(down) > 0;
    if !is_complete {
        return Err(wrong("it has too few samples"));
    }
    image.resize(width as u64, height as u64)?;
    image.grey = false;
    let [to_red, blue_to_green, red_to_green, to_blue] = colours.chroma;
    let (scale, least) = colours.luma;
    let mut chroma = [vec![0; across], vec![0; across]];
    for (row, to) in image.rgb.chunks_exact_mut(3 * width).enumerate() {
        let (near, far) = between(row, down);
        for (plane, chroma) in [&frame.u, &frame.v].into_iter().zip(&mut chroma) {
            let rows = plane[near * across..].iter().zip(&plane[far * across..]);
            for (to, (near, far)) in chroma.iter_mut().zip(rows) {
                *to = 3 * i32::from(*near) + i32::from(*far) - 4 * 128;
            }
        }
        let luma = &frame.y[row * width..][..width];
        for (column, (y, to)) in luma.iter().zip(to.chunks_exact_mut(3)).enumerate() {
            let (near, far) = between(column, across);
            // In sixteenths.
            let [u, v] = [0, 1].map(|plane| 3 * chroma[plane][near] + chroma[plane][far]);
            let y = scale * (i32::from(*y) - least) + 32_768;
            let parts = [
                y + ((to_red * v) >> 4),
                y - ((blue_to_green * u + red_to_green * v) >> 4),
                y + ((to_blue * u) >> 4),
            ];
            for (to, part) in to.iter_mut().zip(parts) {
                *to = (part >> 16).clamp(0, 255) as u8;
            }
        }
    }
    Ok(())
}

/// The two samples of chroma, of so many, between which a pixel lies: the nearer one a quarter of their distance away. Encoders average
/// squares of four pixels, whatever a stream says of where that is.
fn between(pixel: usize, count: usize) -> (usize, usize) {
    let near = (pixel / 2).min(count - 1);
    let far = if pixel.is_multiple_of(2) {
        near.saturating_sub(1)
    } else {
        (near + 1).min(count - 1)
    };
    (near, far)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_images_with_many_references_are_refused() {
        assert_eq!(check_video([3840, 2160], 1, true), Ok(()));
        assert_eq!(check_video([1920, 1080], 12, false), Ok(()));
        assert!(check_video([1920, 1080], 13, false).is_err());
        assert!(check_video([3840, 2160], 1, false).is_err());
        let refused = check_video([3840, 2160], 2, true).expect_err("too large");
        assert!(refused.to_string().contains("--ref 1"), "{refused}");
    }
}
