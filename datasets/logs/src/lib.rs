//! logs
pub mod write;
