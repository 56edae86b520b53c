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
        "its encoding is `{0}`; JPEG, PNG, WebP, rgb, bgr, rgba, bgra, mono and bayer_* of 8 and 16 bits, yuv422, yuv422_yuy2, nv12 and nv21 are read"
    )]
    Encoding(String),
    /// Compressed data are neither JPEG, PNG nor WebP.
    #[error("it is neither JPEG, PNG nor WebP")]
    Unknown,
    /// It is a part of a video of another format than H.264.
    #[error(
        "it is a part of a video (`{0}`), of which only `h264` is decoded; record H.264, or each image as JPEG or PNG in \
         sensor_msgs/CompressedImage or foxglove.CompressedImage"
    )]
    Video(String),
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
    /// The marker's dictionary is none that is known.
    #[error(
        "know the dictionary `{name}` of object.marker: write OpenCV's name, {}",
        crate::Dictionary::NAMES
    )]
    Dictionary {
        /// What the rig file says.
        name: String,
    },
    /// Its dictionary has no marker of this number.
    #[error("find marker {id} of object.marker: {name} has those of 0 to {last}")]
    Marker {
        /// The number.
        id: usize,
        /// The dictionary.
        name: String,
        /// The last number.
        last: usize,
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

/// Why no camera was found from points; each text completes "failed to …".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// Too few points.
    #[error("calibrate from {points} points: at least {needed} are needed, spread over the table")]
    Few {
        /// Points that were given.
        points: usize,
        /// Points that are needed.
        needed: usize,
    },
    /// The points do not determine the camera.
    #[error(
        "calibrate: the points do not determine the camera; spread them over the table and not along a line, give the lens in the rig \
         file (camera.matrix), or add points of known height"
    )]
    Undetermined,
    /// No camera sees the points in these pixels.
    #[error(
        "calibrate: the pixels are {error:.1} px off (rms) any camera found, more than {most} px; point {point} is off by most, {worst:.1} px: \
         check what was typed, or give the lens's distortion in the rig file"
    )]
    Poor {
        /// Reprojection error in px.
        error: f64,
        /// The most that is let pass.
        most: f64,
        /// Number of the worst point, from 1.
        point: usize,
        /// How far it is off, in px.
        worst: f64,
    },
    /// Only a camera below the table sees the points so.
    #[error(
        "calibrate: these points are mirrored, for only a camera below the table sees them so: is y to the robot's left? are pixels \
         u, v counted from the upper left?"
    )]
    Mirrored,
    /// The object's place would not be known.
    #[error(
        "calibrate: somewhere on the table the object's place would be known to {unsure:.1} mm only (standard error; {most} mm are let pass): \
         add points near the table's edges and of known height, or give the lens in the rig file (camera.matrix)"
    )]
    Unsure {
        /// Standard error in mm.
        unsure: f64,
        /// The most that is let pass, in mm.
        most: f64,
    },
}

/// Why a board gave no lens or no pose; each text completes "failed to …".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BoardError {
    /// Too few images show it.
    #[error(
        "find the board: {views} of the images show {corners} of its corners or more, {needed} are needed; check --board, --square, \
         --marker and --dictionary, and that it is sharp, evenly lit and has some white around it"
    )]
    Few {
        /// Images that show it.
        views: usize,
        /// Images that are needed.
        needed: usize,
        /// Corners that are needed in each.
        corners: usize,
    },
    /// The images do not determine the lens.
    #[error(
        "find the lens: the images do not determine it; hold the board at a slant, to the left, the right, up and down, by 20 to 45 degrees"
    )]
    Undetermined,
    /// No lens sees the corners where they are.
    #[error(
        "find the lens: the corners are {error:.2} px off (rms) any lens found, more than {most} px; image {} is off by most, {worst:.2} px: \
         leave it out if it is blurred, and check that the board is flat and the numbers of its squares are right", .view + 1
    )]
    Poor {
        /// Reprojection error in px.
        error: f64,
        /// The most that is let pass.
        most: f64,
        /// Index of the worst image.
        view: usize,
        /// Its rms, in px.
        worst: f64,
    },
    /// The focal length is not known well enough.
    #[error(
        "find the lens: the focal length would be known to {unsure:.1} % only (standard error; {most} % are let pass): take more images, with \
         the board at more of a slant and over all of the image"
    )]
    Unsure {
        /// Standard error in per cent.
        unsure: f64,
        /// The most that is let pass, in per cent.
        most: f64,
    },
    /// What was measured on the table is not the board.
    #[error(
        "place the board on the table: the corners typed are {typed:.4} m apart, the board is {width:.4} m wide; measure its upper left and its \
         upper right corner again"
    )]
    Width {
        /// Distance of the corners that were typed, in m.
        typed: f64,
        /// The board's width in m.
        width: f64,
    },
}

/// Why no colour range was proposed; each text completes "failed to …".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TuneError {
    /// The pixel is none of the image's.
    #[error("look at pixel {x}, {y}: the image has {width} × {height} pixels")]
    Outside {
        /// Column.
        x: usize,
        /// Row.
        y: usize,
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// All is of one colour.
    #[error(
        "find the object: nothing stands off the table in colour; put it on the table, or name a pixel of it with --pixel"
    )]
    Nothing,
    /// What is at the pixel looks like the table.
    #[error(
        "separate the object from the table: what is at the pixel has the table's colour; name another with --pixel, or give the object another colour"
    )]
    Table,
    /// What was found is no object.
    #[error(
        "find the object: what stands off the table takes {share:.2} % of the image; name a pixel of the object with --pixel"
    )]
    Size {
        /// Of the image, in per cent.
        share: f64,
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
    /// The file of the log with the centroids could not be made.
    #[error(transparent)]
    File(#[from] durable::Error),
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
    /// What the log says of the camera's lens is of no use.
    #[error("take the camera's lens from topic {topic} of log {log}: {why}")]
    CameraInfo {
        /// The file.
        log: String,
        /// The topic.
        topic: String,
        /// What is wrong with it.
        why: String,
    },
    /// Rectified images have no lens that bends, and the rig file states one.
    #[error(
        "track the images of topic {topic} in log {log}: they are rectified, by their name, and camera.distortion in the rig file bends their corners by {percent:.0} %; log \
         the CameraInfo beside them, or write its projection P into the rig file as camera.matrix, without distortion"
    )]
    Rectified {
        /// The file.
        log: String,
        /// The topic.
        topic: String,
        /// How far the lens bends, of the distance from the middle.
        percent: f64,
    },
    /// A log from which one image was wanted has none.
    #[error("find an image in log {log}: {why}")]
    NoImage {
        /// The file.
        log: String,
        /// What was wrong with the first, or that there is none.
        why: String,
    },
    /// Not one image could be decoded.
    #[error("decode the images of topic {topic} in log {log}: none of {images} could be; {why}")]
    Undecodable {
        /// The file.
        log: String,
        /// The topic.
        topic: String,
        /// Images seen.
        images: u64,
        /// What was wrong with the first, and which it is.
        why: String,
    },
}
