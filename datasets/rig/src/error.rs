//! Why the rig would not do what it was asked.

/// Completes "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum RigSimError {
    #[error(
        "hide {name}: no effect and no kind of noise has that name; the nearest is {nearest}; there are {all}"
    )]
    UnknownEffect {
        name: String,
        nearest: String,
        all: String,
    },
    #[error("hide {name}: it is a kind of noise, and an effect is wanted here")]
    NoEffect { name: &'static str },
    #[error("hide none and {other}: `none` hides nothing; leave out one of them")]
    NoneAnd { other: String },
    #[error("hide {effect}: {why}; it takes {takes}")]
    EffectValue {
        effect: String,
        why: String,
        takes: String,
    },
    #[error("{doing} {path}: {source}")]
    File {
        doing: &'static str,
        path: String,
        source: std::io::Error,
    },
    #[error("read {what}: {why}")]
    Parse { what: String, why: String },
    #[error("strike the object of the rig file: {0}")]
    Object(String),
    #[error("make strike {index}: {why}")]
    Strike { index: usize, why: String },
    #[error(
        "draw strikes that stay on the table: {tries} in a row left it; enlarge [table], lower [robot] speed, or hide less"
    )]
    NoStrikeFits { tries: u32 },
    #[error(transparent)]
    Log(#[from] logs::write::WriteError),
    #[error(transparent)]
    Reading(#[from] logs::LogError),
    #[error("film the demo: {0}")]
    Film(String),
}
