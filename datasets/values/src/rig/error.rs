//! Why a rig file was not accepted.

/// Why a rig file was not accepted.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum RigError {
    #[error("read {path}: {source}")]
    Read {
        path: String,
        source: std::io::Error,
    },
    #[error("parse the rig file: {0}")]
    Parse(String),
    #[error(
        "accept the key `{key}` on line {line}: there is none of that name; did you mean `{nearest}`?"
    )]
    UnknownKey {
        key: String,
        line: usize,
        nearest: String,
    },
    #[error(
        "accept the key `{key}` on line {line}: it stands below [[{list}]], and TOML takes it for a key of that; move [[{list}]], with its \
         own keys, below all other keys of [{around}]"
    )]
    MisplacedKey {
        key: String,
        line: usize,
        list: String,
        around: String,
    },
    #[error("find the key `{key}`: add a line such as `{mend}`")]
    MissingKey { key: String, mend: String },
    #[error("accept {key} = {value}: {why}")]
    Value {
        key: String,
        value: String,
        why: String,
    },
}
