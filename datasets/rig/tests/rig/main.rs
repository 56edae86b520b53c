//! The embedded rig: what a demo folder holds, and what it hides.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod demo;
