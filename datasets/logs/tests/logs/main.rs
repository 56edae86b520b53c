//! Logs as other programs write them, whole and damaged.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;
mod damage;
mod formats;
mod part;
mod rosbag2;
