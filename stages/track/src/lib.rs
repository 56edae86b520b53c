//! From camera images to the place of the object on the table.
//!
//! ```text
//! message (raw, JPEG, PNG, H.264) → image → blobs of the object's colour → outline of the known shape fitted to the edges → centre on
//! the table, a quality, or a reason why the frame is not trusted
//! ```
//!
//! - [`Decoder`] decodes one message of an image topic; sizes that lie cost no memory.
//! - [`Tracker`] looks at one image after another: `detect` finds where the object may be, `fit` moves the
//!   projected outline of the known shape until it lies on the edges seen, `trust` decides whether to believe it.
//! - [`track_log`] reads a log and writes another with the centroids: first some of its images together (`learn`: the table without the
//!   object, its sides, its size), then each by itself with that.
//! - [`excerpt()`] takes some images of a log, small, for viewers.
//! - [`LensFit`] finds a lens from images of a [`Board`], [`Calibration`] a camera from points of the table, [`Tuned`] the object's colour range from an image.
//!
//! What is measured is the object's centre on the table, not the centroid of its picture: the outline is that of the shape at its
//! height, seen through the camera's lens from its pose. Stamps are moved to the middle of the exposure of the object's rows.

mod aligned;
mod background;
mod bayer;
mod board;
mod calibrate;
mod camera;
mod camera_info;
mod change;
mod colour;
mod decode;
mod detect;
mod draw;
mod edges;
mod error;
mod excerpt;
mod fit;
mod flow;
mod frame;
mod height;
mod homography;
mod huffman;
mod image;
mod jpeg;
mod learn;
mod learned;
mod lens;
mod log;
mod marker;
mod marker_fit;
mod message;
mod message_queue;
mod minimise;
mod notes;
mod outline;
mod readout;
mod rotation;
mod sequence;
mod size;
mod spots;
mod table;
mod tracker;
mod trust;
mod tune;
mod video;
mod video_headers;
mod view;
mod wire;

pub use board::{Board, Dictionary, FEWEST_CORNERS, LensFit, SeenBoard};
pub use calibrate::{Calibration, KnownLens, SeenPoint, Workspace};
pub use camera::CameraModel;
pub use decode::Decoder;
pub use draw::{draw_observation, png_of};
pub use error::{BoardError, CalibrationError, ImageError, SetupError, TrackError, TuneError};
pub use excerpt::{Excerpt, SmallImage, Window, averaged_by, excerpt, first_image};
pub use image::Image;
pub use lens::Lens;
pub use log::track_log;
pub use message::{ImageMessage, Payload, is_image};
pub use notes::{FrameReport, QUALITY_TOPIC, TrackOutcome};
pub use size::LARGEST_IMAGE;
pub use tracker::{Observation, SeenMarker, Tracker};
pub use trust::Reason;
pub use tune::Tuned;
