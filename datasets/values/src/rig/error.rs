//! Why a rig file was not accepted.

/// Why a rig file was not accepted.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// The file could not be read.
    #[error("read {path}: {source}")]
    Read {
        /// The file.
        path: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is not TOML, or a key is missing, unknown or of another type.
    #[error("parse the rig file: {0}")]
    Parse(String),
    /// A key that the format does not have.
    #[error(
        "accept the key `{key}` on line {line}: there is none of that name; did you mean `{nearest}`?"
    )]
    UnknownKey {
        /// Dotted key.
        key: String,
        /// Line of the file, from 1.
        line: usize,
        /// The known key most like it, dotted.
        nearest: String,
    },
    /// A key of a table below one of its lists of tables, to which it then belongs.
    #[error(
        "accept the key `{key}` on line {line}: it stands below [[{list}]], and TOML takes it for a key of that; move [[{list}]], with its \
         own keys, below all other keys of [{around}]"
    )]
    MisplacedKey {
        /// Dotted key, as it was meant.
        key: String,
        /// Line of the file, from 1.
        line: usize,
        /// The list of tables.
        list: String,
        /// The table around it.
        around: String,
    },
    /// A key that must be there is not.
    #[error("find the key `{key}`: add a line such as `{mend}`")]
    MissingKey {
        /// Dotted key.
        key: String,
        /// A line that would mend it.
        mend: String,
    },
    /// A value makes no sense.
    #[error("accept {key} = {value}: {why}")]
    Value {
        /// Dotted key.
        key: String,
        /// What stands there.
        value: String,
        /// What it must be.
        why: String,
    },
}
