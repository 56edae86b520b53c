//! What a stage is, and how its answers are kept.
//!
//! A [`Stage`] is its settings plus `run`; an [`ItemStage`] answers item by item; a [`ListStage`] answers each item with a
//! list that is never all held. [`Run`] hashes name, version,
//! settings and input into a key and answers from the folder's cache, or computes and stores the answer. Nothing in
//! the cache is trusted that its hash does not prove: a damaged answer is computed again. One run at a time works in a
//! folder, or any number of workers, each of which goes through the whole of it and computes what no other has ([`Share`]). One that is
//! killed loses at most the batch of items it was computing.
//!
//! What hashes must be plain data in a fixed order: a `BTreeMap`, never a `HashMap`.

mod answers;
mod codec;
mod contract;
mod error;
mod key;
mod list;
mod pack;
mod progress;
mod run;
mod summary;
mod work_log;
mod worker;

pub use contract::{ItemStage, ListStage, Stage};
pub use error::{RunError, StageError};
pub use list::{Entries, ListAnswer, Reader};
pub use progress::Progress;
pub use run::{Options, Run};
pub use summary::{Record, StageSummary, Summary};
pub use work_log::{Event, Line, WorkerSeen, workers};
pub use worker::{PATIENCE, Share};
