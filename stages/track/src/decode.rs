//! Payloads to images. What a message says of its sizes is checked before memory is taken.

use std::io::Cursor;

use png::DecodingError;
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;

use crate::image::{Image, checked_size};
use crate::jpeg::ScanCheck;
use crate::message::Payload;
use crate::size::LARGEST_IMAGE;
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
                data,
            } => {
                let size = checked_size(width.into(), height.into())?;
                raw(&mut self.image, size, step as usize, encoding, data)?;
            }
            Payload::Compressed(data) => self.compressed(data)?,
            Payload::Video(format, data) => self.video.decode(format, data, &mut self.image)?,
        }
        Ok(&self.image)
    }

    fn compressed(&mut self, data: &[u8]) -> Result<(), ImageError> {
        if data.starts_with(&[0xff, 0xd8]) {
            jpeg(&mut self.image, &mut self.scans, data)
        } else if data.starts_with(b"\x89PNG") {
            png(&mut self.image, &mut self.scratch, data)
        } else {
            Err(ImageError::Unknown)
        }
    }
}

/// What a library's errors mean to a person.
const CUT: &str = "they end before the image does; record or copy it again";
const DAMAGED: &str = "they are damaged; record or copy it again";
const OTHER_KIND: &str = "they are of a kind that cameras do not make (lossless, or coded arithmetically); save the image anew";

fn jpeg(image: &mut Image, scans: &mut ScanCheck, data: &[u8]) -> Result<(), ImageError> {
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
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(data), options);
    decoder.decode_headers().map_err(wrong)?;
    let info = decoder.info();
    let info = info.ok_or_else(|| ImageError::Compressed("JPEG", DAMAGED.into()))?;
    image.resize(info.width.into(), info.height.into())?;
    image.grey = info.components == 1;
    let checked = scans.check(data);
    checked.map_err(|why| ImageError::Compressed("JPEG", why.into()))?;
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
    scratch.resize(size, 0);
    let frame = reader.next_frame(scratch).map_err(wrong)?;
    let channels = frame.color_type.samples();
    let encoding = ["mono8", "mono8_alpha", "rgb8", "rgba8"][channels.clamp(1, 4) - 1];
    raw(image, pixels, frame.line_size, encoding, scratch)
}

/// What a PNG may take.
const LIMITS: png::Limits = png::Limits {
    bytes: 4 * LARGEST_IMAGE,
};

/// Copies rows of a known pixel format. Memory is taken once they are known to be there.
fn raw(
    image: &mut Image,
    [width, height]: [usize; 2],
    step: usize,
    encoding: &str,
    data: &[u8],
) -> Result<(), ImageError> {
    let format = Format::of(encoding)?;
    let pixel = format.bytes();
    let needed = width * pixel;
    let last = step
        .checked_mul(height - 1)
        .and_then(|b| b.checked_add(needed));
    if step < needed || last.is_none_or(|last| last > data.len()) {
        return Err(ImageError::Rows {
            width,
            height,
            step,
            pixel,
            bytes: data.len(),
        });
    }
    image.resize(width as u64, height as u64)?;
    image.grey = matches!(format, Format::Mono(_));
    if let Format::Bayer { red } = format {
        return crate::bayer::demosaic(image, step, red, data);
    }
    let rows = data.chunks(step).zip(image.rgb.chunks_exact_mut(3 * width));
    for (from, to) in rows {
        let from = &from[..needed];
        match format {
            Format::Colour([0, 1, 2], 3) => to.copy_from_slice(from),
            Format::Colour(order, bytes) => {
                for (from, to) in from.chunks_exact(bytes).zip(to.chunks_exact_mut(3)) {
                    to.copy_from_slice(&order.map(|channel| from[channel]));
                }
            }
            Format::Mono(bytes) => {
                for (from, to) in from.chunks_exact(bytes).zip(to.chunks_exact_mut(3)) {
                    to.fill(from[0]);
                }
            }
            Format::Bayer { .. } => {}
        }
    }
    Ok(())
}

/// A pixel format of `sensor_msgs/image_encodings.hpp`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    /// Where red, green and blue lie in a pixel, and its bytes.
    Colour([usize; 3], usize),
    /// Grey first, and the pixel's bytes.
    Mono(usize),
    /// A mosaic; column and row of its red pixel in each square of four.
    Bayer { red: [usize; 2] },
}

impl Format {
    fn of(encoding: &str) -> Result<Self, ImageError> {
        Ok(match encoding {
            "rgb8" | "8UC3" => Self::Colour([0, 1, 2], 3),
            "bgr8" => Self::Colour([2, 1, 0], 3),
            "rgba8" => Self::Colour([0, 1, 2], 4),
            "bgra8" => Self::Colour([2, 1, 0], 4),
            "mono8" | "8UC1" => Self::Mono(1),
            "mono8_alpha" => Self::Mono(2),
            "bayer_rggb8" => Self::Bayer { red: [0, 0] },
            "bayer_grbg8" => Self::Bayer { red: [1, 0] },
            "bayer_gbrg8" => Self::Bayer { red: [0, 1] },
            "bayer_bggr8" => Self::Bayer { red: [1, 1] },
            other => return Err(ImageError::Encoding(other.into())),
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::Colour(_, bytes) | Self::Mono(bytes) => bytes,
            Self::Bayer { .. } => 1,
        }
    }
}
