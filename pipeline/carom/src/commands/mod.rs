//! The commands, a file each, all of one shape: arguments in, [`Output`](crate::Output) out.
//!
//! To add one: a file here with its arguments and `run`, a line below, and a variant in `cli.rs` with what it runs.

pub mod artifacts;
pub mod camera;
pub mod check;
pub mod collect;
pub mod dataset;
pub mod demo;
pub mod key;
pub mod nightly;
pub mod predict;
pub mod query;
pub mod rebuild;
pub mod rig;
pub mod run;
pub mod score;
pub mod shell;
pub mod status;
pub mod track;
pub mod trial;
pub mod view;
pub mod work;
