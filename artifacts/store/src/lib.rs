//! What comes out: versions that a robot can strike with, and the store that keeps them.
//!
//! A version is a folder `versions/vNNNN/` whose `manifest.json` lists every file by hash and records all that is needed
//! to compute it again; `latest` names the one to use. [`Store::publish`] makes a version appear whole or not at all;
//! [`Store::load`] hands out nothing that it has not checked: every hash, size, name, shape and version, the rig's
//! identity, and that every number is finite; [`Store::load_trusted`] in addition who signed it.

mod artifact;
mod change;
mod error;
mod files;
pub mod launch_map;
mod load;
mod manifest;
mod model;
pub mod network;
pub mod objects;
mod remote;
mod residual_model;
mod signature;
mod store;
mod version;

pub use artifact::Artifact;
pub use error::{ArtifactError, Fault};
pub use files::{Calibrated, Contents};
pub use launch_map::{LaunchMap, LaunchMapError, LaunchOffset};
pub use manifest::{
    FileHash, InputFile, Logged, Manifest, Moved, Provenance, StageRecord, TrainedRegion,
    TrainingExtent,
};
pub use model::Model;
pub use network::{Network, NetworkError};
pub use remote::{pull, push};
pub use residual_model::{MOST_NETWORKS, Networks, ResidualModel, ResidualModelError};
pub use signature::{Key, SIGNATURE, Signer};
pub use store::{Listing, Store};

/// Version of the store's layout and of `manifest.json`; raised when a file or key changes its name or meaning.
pub const SCHEMA_VERSION: u32 = 2;

/// Longest file of a version that is read, in bytes. A world or a rig is some kilobytes, an ensemble of networks below a megabyte.
const LONGEST_FILE: u64 = 1 << 26;
