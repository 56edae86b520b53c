//! What can keep an image from being looked at.

use crate::size::LARGEST_IMAGE;

/// Why an image could not be decoded; each text says what is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// The message ends before what its own lengths say is there.
    #[error("it ends at byte {0}, before what its lengths say is there")]
    Short(usize),
    /// It has no pixels, or more than are read.
    #[error("it says that it is {width} × {height} pixels; 1 to {most} pixels are read", most = LARGEST_IMAGE)]
    Size {
        /// Its width.
        width: u64,
        /// Its height.
        height: u64,
    },
    /// Its rows do not fit its bytes.
    #[error(
        "its {height} rows of {step} bytes do not fit a width of {width} pixels of {pixel} bytes in {bytes} bytes"
    )]
    Rows {
        /// Its width in pixels.
        width: usize,
        /// Its height in rows.
        height: usize,
        /// Bytes a row, as it says.
        step: usize,
        /// Bytes a pixel.
        pixel: usize,
        /// Bytes that are there.
        bytes: usize,
    },
    /// Its encoding is none that is decoded.
    #[error(
        "its encoding is `{0}`; rgb8, bgr8, rgba8, bgra8, mono8, bayer_*8, JPEG and PNG are read"
    )]
    Encoding(String),
    /// The message is not as its schema has it.
    #[error("its message is not what its type says: {0}")]
    Message(&'static str),
    /// The compressed data are damaged.
    #[error("its {0} data cannot be decoded: {1}")]
    Compressed(&'static str, String),
}

/// What the rig file lacks for images; each text completes "failed to …".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SetupError {
    /// A key that images need is not in the rig file.
    #[error("find the key `{key}`, which images need: {mend}")]
    Missing {
        /// Dotted key.
        key: &'static str,
        /// How to get it.
        mend: &'static str,
    },
    /// The camera does not see the table.
    #[error(
        "see the table at {x:.2}, {y:.2} m: it lies behind the camera; check camera.position and camera.orientation"
    )]
    Behind {
        /// A point of the table, in m.
        x: f64,
        /// Its second coordinate, in m.
        y: f64,
    },
}

/// Why a log's images could not be tracked; each text completes "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum TrackError {
    /// The rig file lacks what images need.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The log could not be read, or lacks the topic.
    #[error(transparent)]
    Log(#[from] logs::LogError),
    /// The log with the centroids could not be written.
    #[error(transparent)]
    Write(#[from] logs::write::WriteError),
    /// The rig file names no topic of images.
    #[error(
        "find the key `topics.image.name`: name the topic of images in the rig file, such as `name = \"/camera/image/compressed\"`"
    )]
    NoTopic,
    /// The topic holds something else.
    #[error(
        "read images of topic {topic}: its messages are {schema}; sensor_msgs Image and CompressedImage, foxglove RawImage, CompressedImage and CompressedVideo are read"
    )]
    NoImages {
        /// The topic.
        topic: String,
        /// Its messages' type.
        schema: String,
    },
    /// Not one image could be decoded.
    #[error(
        "decode the images of topic {topic} in log {log}: none of {images} could be, the first because {why}"
    )]
    Undecodable {
        /// The file.
        log: String,
        /// The topic.
        topic: String,
        /// Images seen.
        images: u64,
        /// What was wrong with the first.
        why: String,
    },
}
