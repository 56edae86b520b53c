//! What can go wrong with a world.

/// Why a world could not be read, compiled or struck. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// A file could not be read.
    #[error("read {path}: {source}")]
    Read {
        /// The file.
        path: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// A world file is not what it should be.
    #[error("parse the world file: {0}")]
    Parse(String),
    /// A parameter that no world has.
    #[error("use parameter `{name}`: unknown{hint}; known are {known}")]
    UnknownParameter {
        /// The name requested.
        name: String,
        /// ", did you mean …" or nothing.
        hint: String,
        /// All names.
        known: String,
    },
    /// A value out of its range, or not finite.
    #[error("use {name} = {value}: it must lie in [{low}, {high}] {unit}")]
    OutOfRange {
        /// Parameter, or effect and parameter.
        name: String,
        /// Value given.
        value: f64,
        /// Least value.
        low: f64,
        /// Greatest value.
        high: f64,
        /// Unit.
        unit: &'static str,
    },
    /// An effect that the library does not hold.
    #[error("add effect `{name}`: unknown; known are {known}")]
    UnknownEffect {
        /// The name requested.
        name: String,
        /// All names.
        known: String,
    },
    /// MuJoCo did not accept the scene.
    #[error("compile the MuJoCo world: {0}")]
    Compile(String),
    /// The strike did not end in a finite rest.
    #[error("simulate the strike at {speed} m/s, {angle} rad: {why}")]
    Diverged {
        /// Commanded speed in m/s.
        speed: f64,
        /// Commanded angle in rad.
        angle: f64,
        /// What happened.
        why: &'static str,
    },
}
