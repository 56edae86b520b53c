//! Pictures, and pictures as files.

use jpeg_encoder::{ChromaSubsamplingMethod, ColorType, Encoder, SamplingFactor};

/// Why a picture could not be encoded.
#[derive(Debug, thiserror::Error)]
#[error("encode a picture of {width} × {height} pixels: {why}")]
pub struct EncodeError {
    width: usize,
    height: usize,
    why: String,
}

impl Picture {
    /// The image as JPEG of this quality (1 to 100), its colours at half the resolution, as cameras and OpenCV do.
    pub fn jpeg(&self, quality: u8) -> Result<Vec<u8>, EncodeError> {
        let mut data = Vec::new();
        let size = |size: usize| u16::try_from(size).map_err(|error| self.error(&error));
        let (width, height) = (size(self.width)?, size(self.height)?);
        let mut encoder = Encoder::new(&mut data, quality);
        encoder.set_sampling_factor(SamplingFactor::F_2_2);
        encoder.set_chroma_subsampling_method(ChromaSubsamplingMethod::Average);
        let encoded = encoder.encode(&self.rgb, width, height, ColorType::Rgb);
        encoded.map_err(|error| self.error(&error))?;
        Ok(data)
    }

    /// The image as PNG.
    pub fn png(&self) -> Result<Vec<u8>, EncodeError> {
        let mut data = Vec::new();
        let size = |size: usize| u32::try_from(size).map_err(|error| self.error(&error));
        let mut encoder = png::Encoder::new(&mut data, size(self.width)?, size(self.height)?);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header().map_err(|error| self.error(&error))?;
        let written = writer.write_image_data(&self.rgb);
        written.map_err(|error| self.error(&error))?;
        writer.finish().map_err(|error| self.error(&error))?;
        Ok(data)
    }

    fn error(&self, why: &dyn std::error::Error) -> EncodeError {
        EncodeError {
            width: self.width,
            height: self.height,
            why: why.to_string(),
        }
    }
}

/// What a camera gives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Three bytes a pixel, rows from the top.
    pub rgb: Vec<u8>,
}
