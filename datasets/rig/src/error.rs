//! Why the rig would not do what it was asked.

/// Completes "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum RigSimError {
    /// No effect has that name.
    #[error(
        "hide {name}: no effect and no kind of noise has that name; the nearest is {nearest}; there are {all}"
    )]
    UnknownEffect {
        /// The name requested.
        name: String,
        /// The known name most like it.
        nearest: String,
        /// Every known name.
        all: String,
    },
    /// A kind of noise was given where an effect is wanted.
    #[error("hide {name}: it is a kind of noise, and an effect is wanted here")]
    NoEffect {
        /// The kind of noise.
        name: &'static str,
    },
    /// Nothing and something is to be hidden.
    #[error("hide none and {other}: `none` hides nothing; leave out one of them")]
    NoneAnd {
        /// The other name.
        other: String,
    },
    /// A value of an effect is not a number, or there are too many or too few, or its name is unknown.
    #[error("hide {effect}: {why}; it takes {takes}")]
    EffectValue {
        /// The effect.
        effect: String,
        /// What is wrong.
        why: String,
        /// Its parameters with units and defaults.
        takes: String,
    },
    /// A file could not be read or written.
    #[error("{doing} {path}: {source}")]
    File {
        /// `read` or `write`.
        doing: &'static str,
        /// The file.
        path: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// A truth or plan file does not hold what it should.
    #[error("read {what}: {why}")]
    Parse {
        /// Which file or text.
        what: String,
        /// Where and what is wrong.
        why: String,
    },
    /// The rig file lacks a size that the object's shape needs, or a size is not positive.
    #[error("strike the object of the rig file: {0}")]
    Object(String),
    /// A strike that was asked for is not finite or not on the table.
    #[error("make strike {index}: {why}")]
    Strike {
        /// Its place in the plan, from 0.
        index: usize,
        /// What is wrong and how to mend it.
        why: String,
    },
    /// No random strike stays on the table.
    #[error(
        "draw strikes that stay on the table: {tries} in a row left it; enlarge [table], lower [robot] speed, or hide less"
    )]
    NoStrikeFits {
        /// How many were drawn.
        tries: u32,
    },
    /// A log could not be written.
    #[error(transparent)]
    Log(#[from] logs::write::WriteError),
    /// A log that was just written could not be read.
    #[error(transparent)]
    Reading(#[from] logs::LogError),
    /// A picture could not be made.
    #[error("film the demo: {0}")]
    Film(String),
}
