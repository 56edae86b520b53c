//! What can go wrong with a world.

/// Why a world could not be read, compiled or struck. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum WorldError {
    #[error("read {path}: {source}")]
    Read {
        path: String,
        source: std::io::Error,
    },
    #[error("parse the world file: {0}")]
    Parse(String),
    #[error("use parameter `{name}`: unknown{hint}; known are {known}")]
    UnknownParameter {
        name: String,
        hint: String,
        known: String,
    },
    #[error("use {name} = {value}: it must lie in [{low}, {high}] {unit}")]
    OutOfRange {
        name: String,
        value: f64,
        low: f64,
        high: f64,
        unit: &'static str,
    },
    #[error("add effect `{name}`: unknown; known are {known}")]
    UnknownEffect { name: String, known: String },
    #[error("compile the MuJoCo world: {0}")]
    Compile(String),
    #[error("simulate the strike at {speed} m/s, {angle} rad: {why}")]
    Diverged {
        speed: f64,
        angle: f64,
        why: &'static str,
    },
}
