//! Payloads to images. What a message says of its sizes is checked before memory is taken.

use std::io::Cursor;

use png::DecodingError;
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;

use crate::image::{Image, check_room, checked_size};
use crate::jpeg::{ScanCheck, with_codes};
use crate::message::Payload;
use crate::size::{LARGEST_IMAGE, MOST_WAITING};
use crate::video::Video;
use crate::{ImageError, ImageMessage};

/// Decodes one image after another into the same memory.
#[derive(Debug, Default)]
pub struct Decoder {
    image: Image,
    /// The undecoded pixels of the last PNG.
    scratch: Vec<u8>,
    scans: ScanCheck,
    video: Video,
}

impl Decoder {
    /// Decodes the pixels of a message. The images of a video build on one another: they go in their order through one decoder.
    pub fn decode(&mut self, message: &ImageMessage<'_>) -> Result<&Image, ImageError> {
        match message.payload {
            Payload::Raw {
                width,
                height,
                step,
                encoding,
                is_big_endian,
                data,
            } => {
                let size = checked_size(width.into(), height.into())?;
                let greater = usize::from(!is_big_endian);
                raw(
                    &mut self.image,
                    size,
                    step as usize,
                    (encoding, greater),
                    data,
                )?;
            }
            Payload::Compressed(data) => self.compressed(data)?,
            Payload::Video(format, data) => self.video.decode(format, data, &mut self.image)?,
        }
        Ok(&self.image)
    }

    /// The image that was decoded last.
    pub(crate) fn into_image(self) -> Image {
        self.image
    }

    fn compressed(&mut self, data: &[u8]) -> Result<(), ImageError> {
        if data.starts_with(&[0xff, 0xd8]) {
            jpeg(&mut self.image, &mut self.scans, data)
        } else if data.starts_with(b"\x89PNG") {
            png(&mut self.image, &mut self.scratch, data)
        } else if data.starts_with(b"RIFF") && data.get(8..12) == Some(b"WEBP") {
            webp(&mut self.image, &mut self.scratch, data)
        } else {
            Err(ImageError::Unknown)
        }
    }
}

/// Width and height of a message's image, by what it says of itself; of a video nothing is said.
pub(crate) fn size(message: &ImageMessage<'_>) -> Option<[usize; 2]> {
    let [width, height] = match message.payload {
        Payload::Raw { width, height, .. } => [width.into(), height.into()],
        Payload::Compressed(data) if data.starts_with(b"\x89PNG") => {
            let reader = png::Decoder::new_with_limits(Cursor::new(data), LIMITS).read_info();
            let (width, height) = reader.ok()?.info().size();
            [width.into(), height.into()]
        }
        Payload::Compressed(data) if data.starts_with(b"RIFF") => {
            let decoder = image_webp::WebPDecoder::new(Cursor::new(data)).ok()?;
            let (width, height) = decoder.dimensions();
            [width.into(), height.into()]
        }
        Payload::Compressed(data) => {
            let data = with_codes(data);
            let mut decoder = JpegDecoder::new(ZCursor::new(&data[..]));
            decoder.decode_headers().ok()?;
            let info = decoder.info()?;
            [info.width.into(), info.height.into()]
        }
        Payload::Video(..) => return None,
    };
    checked_size(width, height).ok()
}

/// Bytes that a message takes: where it waits, the log's reader, the queue and the decoder have it.
fn held(message: &[u8]) -> usize {
    match message.len() {
        bytes if bytes > MOST_WAITING => bytes,
        bytes => 3 * bytes,
    }
}

/// Bytes of pixels that are given back before the next image is looked at.
const LARGE: usize = 64 << 20;

/// What a library's errors mean to a person.
const CUT: &str = "they end before the image does; record or copy it again";
const DAMAGED: &str = "they are damaged; record or copy it again";
const OTHER_KIND: &str = "they are of a kind that cameras do not make (lossless, or coded arithmetically); save the image anew";

fn jpeg(image: &mut Image, scans: &mut ScanCheck, data: &[u8]) -> Result<(), ImageError> {
    let data = &with_codes(data);
    let wrong = |error| {
        let why = match error {
            DecodeErrors::ExhaustedData | DecodeErrors::IoErrors(_) => CUT,
            DecodeErrors::Unsupported(_) => OTHER_KIND,
            _ => DAMAGED,
        };
        ImageError::Compressed("JPEG", why.into())
    };
    // Strict, so that a JPEG that is cut off is an error and no grey lower half.
    let options = DecoderOptions::default()
        .jpeg_set_out_colorspace(ColorSpace::RGB)
        .set_strict_mode(true);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(&data[..]), options);
    decoder.decode_headers().map_err(wrong)?;
    let info = decoder.info();
    let info = info.ok_or_else(|| ImageError::Compressed("JPEG", DAMAGED.into()))?;
    let [width, height] = checked_size(info.width.into(), info.height.into())?;
    // The memory of so large an image is not held beside that of its scans.
    if image.rgb.len() > LARGE {
        *image = Image::default();
    }
    let checked = scans.check(data);
    checked.map_err(|why| ImageError::Compressed("JPEG", why.into()))?;
    check_room([width, height], held(data) + scans.coefficient_bytes())?;
    image.resize(width as u64, height as u64)?;
    image.grey = info.components == 1;
    decoder.decode_into(&mut image.rgb).map_err(wrong)
}

fn png(image: &mut Image, scratch: &mut Vec<u8>, data: &[u8]) -> Result<(), ImageError> {
    let wrong = |error| {
        let why = match error {
            DecodingError::IoError(_) => CUT.into(),
            DecodingError::LimitsExceeded => format!("they take more than {} bytes", LIMITS.bytes),
            DecodingError::Format(_) | DecodingError::Parameter(_) => DAMAGED.into(),
        };
        ImageError::Compressed("PNG", why)
    };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(data), LIMITS);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(wrong)?;
    let (width, height) = reader.info().size();
    let pixels = checked_size(width.into(), height.into())?;
    let size = reader.output_buffer_size().unwrap_or_default();
    check_room(pixels, held(data) + size)?;
    scratch.resize(size, 0);
    let frame = reader.next_frame(scratch).map_err(wrong)?;
    let channels = frame.color_type.samples();
    let encoding = ["mono8", "mono8_alpha", "rgb8", "rgba8"][channels.clamp(1, 4) - 1];
    raw(image, pixels, frame.line_size, (encoding, 0), scratch)
}

fn webp(image: &mut Image, scratch: &mut Vec<u8>, data: &[u8]) -> Result<(), ImageError> {
    let wrong = |error| {
        let why = match error {
            image_webp::DecodingError::IoError(_) => CUT,
            _ => DAMAGED,
        };
        ImageError::Compressed("WebP", why.into())
    };
    let mut decoder = image_webp::WebPDecoder::new(Cursor::new(data)).map_err(wrong)?;
    decoder.set_memory_limit(4 * LARGEST_IMAGE);
    let (width, height) = decoder.dimensions();
    let pixels = checked_size(width.into(), height.into())?;
    let size = decoder.output_buffer_size().unwrap_or_default();
    check_room(pixels, held(data) + size)?;
    scratch.resize(size, 0);
    decoder.read_image(scratch).map_err(wrong)?;
    let (encoding, bytes) = if decoder.has_alpha() {
        ("rgba8", 4)
    } else {
        ("rgb8", 3)
    };
    raw(image, pixels, bytes * pixels[0], (encoding, 0), scratch)
}

/// What a PNG may take.
const LIMITS: png::Limits = png::Limits {
    bytes: 4 * LARGEST_IMAGE,
};

/// Copies rows of a known pixel format; of numbers of two bytes the greater byte, which is the first or the second. Memory is taken once the
/// rows are known to be there.
fn raw(
    image: &mut Image,
    [width, height]: [usize; 2],
    step: usize,
    (encoding, greater): (&str, usize),
    data: &[u8],
) -> Result<(), ImageError> {
    let format = Format::of(encoding, greater)?;
    let pixel = format.bytes();
    // A plane of colours of half the height follows that of brightness.
    let rows = match format {
        Format::Planes { .. } => height + height.div_ceil(2),
        _ => height,
    };
    let needed = width * pixel;
    let last = step
        .checked_mul(rows - 1)
        .and_then(|b| b.checked_add(needed));
    let is_odd = matches!(format, Format::Pairs { .. } | Format::Planes { .. }) && width % 2 == 1;
    if step < needed || is_odd || last.is_none_or(|last| last > data.len()) {
        return Err(ImageError::Rows {
            width,
            height,
            step,
            pixel,
            bytes: data.len(),
        });
    }
    check_room([width, height], held(data))?;
    image.resize(width as u64, height as u64)?;
    image.grey = matches!(format, Format::Mono(..));
    if let Format::Bayer { red, bytes } = format {
        let first = &data[if bytes == 2 { greater } else { 0 }..];
        return crate::bayer::demosaic(image, [step, bytes], red, first);
    }
    let rows = data.chunks(step).zip(image.rgb.chunks_exact_mut(3 * width));
    for (row, (from, to)) in rows.enumerate() {
        let from = &from[..needed];
        match format {
            Format::Colour([0, 1, 2], 3) => to.copy_from_slice(from),
            Format::Colour(order, bytes) => {
                for (from, to) in from.chunks_exact(bytes).zip(to.chunks_exact_mut(3)) {
                    to.copy_from_slice(&order.map(|channel| from[channel]));
                }
            }
            Format::Mono(at, bytes) => {
                for (from, to) in from.chunks_exact(bytes).zip(to.chunks_exact_mut(3)) {
                    to.fill(from[at]);
                }
            }
            Format::Pairs { luma, chroma } => {
                for (from, to) in from.chunks_exact(4).zip(to.chunks_exact_mut(6)) {
                    for (at, to) in luma.iter().zip(to.chunks_exact_mut(3)) {
                        to.copy_from_slice(&rgb_of([from[*at], from[chroma[0]], from[chroma[1]]]));
                    }
                }
            }
            Format::Planes { chroma } => {
                let colours = &data[(height + row / 2) * step..];
                for (column, (from, to)) in from.iter().zip(to.chunks_exact_mut(3)).enumerate() {
                    let pair = &colours[column & !1..];
                    to.copy_from_slice(&rgb_of([*from, pair[chroma[0]], pair[chroma[1]]]));
                }
            }
            Format::Bayer { .. } => {}
        }
    }
    Ok(())
}

/// Red, green and blue of a brightness and two colour differences, 8 bits of the range that cameras use (ITU-R BT.601, luma 16 to 235).
fn rgb_of(yuv: [u8; 3]) -> [u8; 3] {
    let [y, u, v] = yuv.map(f32::from);
    let (y, u, v) = (1.164 * (y - 16.0), u - 128.0, v - 128.0);
    [y + 1.596 * v, y - 0.392 * u - 0.813 * v, y + 2.017 * u].map(|part| part.round() as u8)
}

/// A pixel format of `sensor_msgs/image_encodings.hpp`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    /// Where red, green and blue lie in a pixel, and its bytes.
    Colour([usize; 3], usize),
    /// Where the grey lies in a pixel, and its bytes.
    Mono(usize, usize),
    /// A mosaic; column and row of its red pixel in each square of four, and a pixel's bytes.
    Bayer { red: [usize; 2], bytes: usize },
    /// Two pixels in four bytes: where their brightness lies, and the two colour differences that they share.
    Pairs {
        luma: [usize; 2],
        chroma: [usize; 2],
    },
    /// A plane of brightness, and one of the two colour differences by turns, each for four pixels: which comes first.
    Planes { chroma: [usize; 2] },
}

impl Format {
    /// A format by its name; `greater` is where the greater of a number's two bytes lies.
    fn of(encoding: &str, greater: usize) -> Result<Self, ImageError> {
        let of_two = |order: [usize; 3]| order.map(|at| 2 * at + greater);
        Ok(match encoding {
            "rgb8" | "8UC3" => Self::Colour([0, 1, 2], 3),
            "bgr8" => Self::Colour([2, 1, 0], 3),
            "rgba8" => Self::Colour([0, 1, 2], 4),
            "bgra8" => Self::Colour([2, 1, 0], 4),
            "rgb16" => Self::Colour(of_two([0, 1, 2]), 6),
            "bgr16" => Self::Colour(of_two([2, 1, 0]), 6),
            "rgba16" => Self::Colour(of_two([0, 1, 2]), 8),
            "bgra16" => Self::Colour(of_two([2, 1, 0]), 8),
            "mono8" | "8UC1" => Self::Mono(0, 1),
            "mono16" | "16UC1" => Self::Mono(greater, 2),
            "mono8_alpha" => Self::Mono(0, 2),
            "yuv422" | "uyvy" => Self::Pairs {
                luma: [1, 3],
                chroma: [0, 2],
            },
            "yuv422_yuy2" | "yuyv" => Self::Pairs {
                luma: [0, 2],
                chroma: [1, 3],
            },
            "nv12" => Self::Planes { chroma: [0, 1] },
            "nv21" => Self::Planes { chroma: [1, 0] },
            other => {
                let mosaic = other
                    .strip_prefix("bayer_")
                    .and_then(|rest| rest.split_at_checked(4));
                let red = match mosaic {
                    Some(("rggb", _)) => [0, 0],
                    Some(("grbg", _)) => [1, 0],
                    Some(("gbrg", _)) => [0, 1],
                    Some(("bggr", _)) => [1, 1],
                    _ => return Err(ImageError::Encoding(other.into())),
                };
                let bytes = match mosaic {
                    Some((_, "8")) => 1,
                    Some((_, "16")) => 2,
                    _ => return Err(ImageError::Encoding(other.into())),
                };
                Self::Bayer { red, bytes }
            }
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::Colour(_, bytes) | Self::Mono(_, bytes) | Self::Bayer { bytes, .. } => bytes,
            Self::Pairs { .. } => 2,
            Self::Planes { .. } => 1,
        }
    }
}
