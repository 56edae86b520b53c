//! From logs to strikes: what was commanded, where the object rested before and after, and how it slid in between.
//!
//! Contract, section 1. A strike is found from the command (`episode`, `plateau`), its rests and its slide from the centroids
//! around it (`slide`), what the arm delivered from its state (`arm`), and the object's yaw from its pose (`yaw`), where these are
//! logged. All come from the log as streams (`order`, `segment`), of which no more is held than the strikes in hand need.
//! Every command that rises and falls is a [`Strike`] or a [`Reject`] with a reason: nothing is dropped in silence.
//!
//! Each log is ingested on its own ([`Ingest`], a list stage): its strikes go to the cache while they are found. [`Strikes`]
//! then joins all logs, one row for a strike that several logs hold, in the order of time, and reads them one by one; what is
//! held of a strike is what distinguishes it from others ([`StrikeSummary`]). [`assemble`] does the same with logs that are held whole.

mod arm;
mod assemble;
mod bounces;
mod caught;
mod counts;
mod episode;
mod error;
mod extras;
mod fences;
mod frames;
mod grazes;
mod identity;
mod ingest;
mod log;
mod lost;
mod notes;
mod order;
mod outcome;
mod plateau;
mod pushes;
mod rejection;
mod robust;
mod seen;
mod segment;
mod settings;
mod slide;
mod touched;
mod unmeasured;
mod yaw;

pub use arm::{Meeting, TouchDelay};
pub use assemble::{Strikes, assemble};
pub use bounces::{Bounce, Hit};
pub use caught::Braking;
pub use error::IngestError;
pub use fences::{FoundFence, fences};
pub use log::ingest_log;
pub use notes::Note;
pub use outcome::{LogFile, LogOutcome, StrikeSummary};
pub use rejection::Detail;
pub use seen::{CommandSeen, MotionSeen, Seen};
pub use settings::Ingest;
pub use yaw::yaw_of;
