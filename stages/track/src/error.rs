//! What can keep an image from being looked at.

use crate::size::{LARGEST_IMAGE, MOST_BYTES};

/// Why an image could not be decoded; each text says what is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum ImageError {
    #[error("it ends at byte {0}, before what its lengths say is there")]
    Short(usize),
    #[error("it says that it is {width} × {height} pixels; 1 to {most} pixels are read", most = LARGEST_IMAGE)]
    Size { width: u64, height: u64 },
    #[error(
        "its {width} × {height} pixels and what they are decoded from take {} MB, and at most {} MB may be taken: record smaller images, or JPEG \
         that is not progressive", bytes / 1_000_000, MOST_BYTES / 1_000_000
    )]
    Memory {
        width: usize,
        height: usize,
        bytes: usize,
    },
    #[error(
        "its decoder takes {} MB for {width} × {height} pixels with {references} reference images, and at most {} MB may be taken: record smaller \
         images, with fewer reference images (x264: --ref 1), or each in one slice (x264: --threads 1)", bytes / 1_000_000, MOST_BYTES / 1_000_000
    )]
    VideoMemory {
        width: usize,
        height: usize,
        references: usize,
        bytes: usize,
    },
    #[error(
        "its {height} rows of {step} bytes do not fit a width of {width} pixels of {pixel} bytes in {bytes} bytes"
    )]
    Rows {
        width: usize,
        height: usize,
        step: usize,
        pixel: usize,
        bytes: usize,
    },
    #[error(
        "its encoding is `{0}`; JPEG, PNG, WebP, rgb, bgr, rgba, bgra, mono and bayer_* of 8 and 16 bits, yuv422, yuv422_yuy2, nv12 and nv21 are read"
    )]
    Encoding(String),
    #[error("it is neither JPEG, PNG nor WebP")]
    Unknown,
    #[error(
        "it is a part of a video (`{0}`), of which only `h264` is decoded; record H.264, or each image as JPEG or PNG in \
         sensor_msgs/CompressedImage or foxglove.CompressedImage"
    )]
    Video(String),
    #[error("its message is not what its type says: {0}")]
    Message(&'static str),
    #[error("its {0} data cannot be decoded: {1}")]
    Compressed(&'static str, String),
}

/// What the rig file lacks for images; each text completes "failed to …".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum SetupError {
    #[error("find the key `{key}`, which images need: {mend}")]
    Missing {
        key: &'static str,
        mend: &'static str,
    },
    #[error(
        "know the dictionary `{name}` of object.marker: write OpenCV's name, {}",
        crate::Dictionary::NAMES
    )]
    Dictionary { name: String },
    #[error("find marker {id} of object.marker: {name} has those of 0 to {last}")]
    Marker {
        id: usize,
        name: String,
        last: usize,
    },
    #[error(
        "see the table at {x:.2}, {y:.2} m: it lies behind the camera; check camera.position and camera.orientation"
    )]
    Behind { x: f64, y: f64 },
}

/// Why no camera was found from points; each text completes "failed to …".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum CalibrationError {
    #[error("calibrate from {points} points: at least {needed} are needed, spread over the table")]
    Few { points: usize, needed: usize },
    #[error(
        "calibrate: the points do not determine the camera; spread them over the table and not along a line, give the lens in the rig \
         file (camera.matrix), or add points of known height"
    )]
    Undetermined,
    #[error(
        "calibrate: the pixels are {error:.1} px off (rms) any camera found, more than {most} px; point {point} is off by most, {worst:.1} px: \
         check what was typed, or give the lens's distortion in the rig file"
    )]
    Poor {
        error: f64,
        most: f64,
        point: usize,
        worst: f64,
    },
    #[error(
        "calibrate: these points are mirrored, for only a camera below the table sees them so: is y to the robot's left? are pixels \
         u, v counted from the upper left?"
    )]
    Mirrored,
    #[error(
        "calibrate: somewhere on the table the object's place would be known to {unsure:.1} mm only (standard error; {most} mm are let pass): \
         add points near the table's edges and of known height, or give the lens in the rig file (camera.matrix)"
    )]
    Unsure { unsure: f64, most: f64 },
}

/// Why a board gave no lens or no pose; each text completes "failed to …".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum BoardError {
    #[error(
        "find the board: {views} of the images show {corners} of its corners or more, {needed} are needed; check --board, --square, \
         --marker and --dictionary, and that it is sharp, evenly lit and has some white around it"
    )]
    Few {
        views: usize,
        needed: usize,
        corners: usize,
    },
    #[error(
        "find the lens: the images do not determine it; hold the board at a slant, to the left, the right, up and down, by 20 to 45 degrees"
    )]
    Undetermined,
    #[error(
        "find the lens: the corners are {error:.2} px off (rms) any lens found, more than {most} px; image {} is off by most, {worst:.2} px: \
         leave it out if it is blurred, and check that the board is flat and the numbers of its squares are right", .view + 1
    )]
    Poor {
        error: f64,
        most: f64,
        view: usize,
        worst: f64,
    },
    #[error(
        "find the lens: the focal length would be known to {unsure:.1} % only (standard error; {most} % are let pass): take more images, with \
         the board at more of a slant and over all of the image"
    )]
    Unsure { unsure: f64, most: f64 },
    #[error(
        "place the board on the table: the corners typed are {typed:.4} m apart, the board is {width:.4} m wide; measure its upper left and its \
         upper right corner again"
    )]
    Width { typed: f64, width: f64 },
}

/// Why no colour range was proposed; each text completes "failed to …".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum TuneError {
    #[error("look at pixel {x}, {y}: the image has {width} × {height} pixels")]
    Outside {
        x: usize,
        y: usize,
        width: usize,
        height: usize,
    },
    #[error(
        "find the object: nothing stands off the table in colour; put it on the table, or name a pixel of it with --pixel"
    )]
    Nothing,
    #[error(
        "separate the object from the table: what is at the pixel has the table's colour; name another with --pixel, or give the object another colour"
    )]
    Table,
    #[error(
        "find the object: what stands off the table takes {share:.2} % of the image; name a pixel of the object with --pixel"
    )]
    Size { share: f64 },
}

/// Why a log's images could not be tracked; each text completes "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum TrackError {
    #[error(transparent)]
    Setup(#[from] SetupError),
    #[error(transparent)]
    Log(#[from] logs::LogError),
    #[error(transparent)]
    Write(#[from] logs::write::WriteError),
    #[error(transparent)]
    File(#[from] durable::Error),
    #[error(
        "find the key `topics.image.name`: name the topic of images in the rig file, such as `name = \"/camera/image/compressed\"`"
    )]
    NoTopic,
    #[error(
        "read images of topic {topic}: its messages are {schema}; sensor_msgs Image and CompressedImage, foxglove RawImage, CompressedImage and CompressedVideo are read"
    )]
    NoImages { topic: String, schema: String },
    #[error("take the camera's lens from topic {topic} of log {log}: {why}")]
    CameraInfo {
        log: String,
        topic: String,
        why: String,
    },
    #[error(
        "track the images of topic {topic} in log {log}: they are rectified, by their name, and camera.distortion in the rig file bends their corners by {percent:.0} %; log \
         the CameraInfo beside them, or write its projection P into the rig file as camera.matrix, without distortion"
    )]
    Rectified {
        log: String,
        topic: String,
        percent: f64,
    },
    #[error("find an image in log {log}: {why}")]
    NoImage { log: String, why: String },
    #[error("decode the images of topic {topic} in log {log}: none of {images} could be; {why}")]
    Undecodable {
        log: String,
        topic: String,
        images: u64,
        why: String,
    },
}
