//! From camera images to the place of the object on the table.
//!
//! ```text
//! message (raw, JPEG, PNG) → image → blobs of the object's colour → outline of the known shape fitted to the edges → centre on
//! the table, a quality, or a reason why the frame is not trusted
//! ```
//!
//! - [`Decoder`] decodes one message of an image topic; sizes that lie cost no memory.
//! - [`Tracker`] looks at one image after another: `detect` finds where the object may be, `fit` moves the
//!   projected outline of the known shape until it lies on the edges seen, `trust` decides whether to believe it.
//! - [`track_log`] reads a log and writes another with the centroids.
//!
//! What is measured is the object's centre on the table, not the centroid of its picture: the outline is that of the shape at its
//! height, seen through the camera's lens from its pose. Stamps are moved to the middle of the exposure of the object's rows.

mod bayer;
mod camera;
mod colour;
mod decode;
mod detect;
mod edges;
mod error;
mod fit;
mod image;
mod lens;
mod linear;
mod log;
mod message;
mod outline;
mod sequence;
mod size;
mod tracker;
mod trust;

pub use camera::CameraModel;
pub use decode::Decoder;
pub use error::{ImageError, SetupError, TrackError};
pub use image::Image;
pub use lens::Lens;
pub use log::{FrameReport, QUALITY_TOPIC, TrackOutcome, track_log};
pub use message::{ImageMessage, Payload, is_image};
pub use size::LARGEST_IMAGE;
pub use tracker::{Observation, Tracker};
pub use trust::Reason;
