//! Datasets with a version: a recipe names logs; its lock pins each by SHA-256 and records the hash of every table.
//!
//! Logs are known by their content once they are pinned: they may be renamed, copied, named in any order or lie elsewhere.

mod lerobot;
mod lock;
mod recipe;
mod rows;

pub use lerobot::{MOST_FPS, all_turn, episode, usual_fps};
pub use lock::{Lock, PinnedLog, pin};
pub use recipe::Recipe;
pub use rows::{FILES, Rows, hashes};
