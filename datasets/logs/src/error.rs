//! What can keep a log from being read.

/// Why a log could not be read; each text completes "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file could not be opened or read.
    #[error("read log {log}: {source}")]
    Io {
        /// The file.
        log: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file has no bytes.
    #[error(
        "read log {log}: it is empty (0 bytes); its recording never began, or it was not copied: record or copy it again, or take it away"
    )]
    Empty {
        /// The file.
        log: String,
    },
    /// The file does not begin as MCAP does.
    #[error(
        "read log {log}: it is no MCAP file (it does not begin with MCAP's magic bytes) and no bag of SQLite; record with \
         `ros2 bag record -s mcap`, or convert it with `ros2 bag convert` or `mcap convert`"
    )]
    NotMcap {
        /// The file.
        log: String,
    },
    /// A folder is no bag.
    #[error(
        "read log {log}: it is a folder without rosbag2's `metadata.yaml`, or with one that lists no files; name the files in it, or \
         write it anew with `ros2 bag reindex`"
    )]
    NoBag {
        /// The folder.
        log: String,
    },
    /// A bag of SQLite cannot be read.
    #[error("read log {log}, a bag of SQLite: {why}")]
    Sqlite {
        /// The file.
        log: String,
        /// What is wrong with it.
        why: String,
    },
    /// A record or chunk is larger than this reader lets a file make it.
    #[error(
        "read log {log}: the {what} at byte {offset} takes {size} bytes where at most {limit} are read; \
         write the log anew with smaller chunks, such as `mcap filter --chunk-size 1048576`"
    )]
    TooLarge {
        /// The file.
        log: String,
        /// `chunk` or `record`.
        what: &'static str,
        /// Where it begins.
        offset: u64,
        /// Bytes that it takes or says that it takes.
        size: u64,
        /// Bytes that it may take.
        limit: u64,
    },
    /// A chunk is compressed by something else than zstd or LZ4.
    #[error(
        "read log {log}: a chunk is compressed with `{compression}`; use zstd, lz4 or no compression"
    )]
    Compression {
        /// The file.
        log: String,
        /// What the chunk names.
        compression: String,
    },
    /// A topic that is needed is not in the file.
    #[error(
        "find topic {topic} in log {log}: it has {}; set the topic's name in rig.toml under [topics]{}",
        list(found),
        if *images { ". Camera images are there: name their topic under [topics.image], with the camera's lens and pose and the object's colour, to take the centroid from them" } else { "" }
    )]
    MissingTopic {
        /// The file.
        log: String,
        /// The topic that is missing.
        topic: String,
        /// The topics that the file has, with their schemas.
        found: Vec<String>,
        /// Whether images are among them.
        images: bool,
    },
    /// A topic's message encoding or schema encoding is none that is decoded.
    #[error(
        "decode topic {topic}: its messages are encoded as `{message}` with a `{schema}` schema; \
         cdr with ros2msg, ros1 with ros1msg, json, and protobuf are read{}",
        match (message.as_str(), schema.as_str()) {
            ("cdr", "ros2idl" | "omgidl") => " (record with a ros2msg schema: rosbag2 writes it for packages with .msg files)",
            ("cdr", "" | "unknown") => " (rosbag2 leaves a definition out that it does not find: record or convert where the message's package is installed)",
            _ => "",
        }
    )]
    Encoding {
        /// The topic.
        topic: String,
        /// The channel's message encoding.
        message: String,
        /// The schema's encoding.
        schema: String,
    },
    /// A schema in the file makes no sense.
    #[error("decode topic {topic}: its schema {schema} is unusable: {why}")]
    Schema {
        /// The topic.
        topic: String,
        /// The schema's name.
        schema: String,
        /// What is wrong with it.
        why: String,
    },
    /// A field path of the rig file leads nowhere in the schema.
    #[error("find field `{path}` of topic {topic}: {why}; set the path in rig.toml under [topics]")]
    Field {
        /// The topic.
        topic: String,
        /// The dotted path.
        path: String,
        /// Where it leads astray.
        why: String,
    },
    /// Not one message of a topic could be decoded.
    #[error(
        "decode topic {topic} of log {log}: none of its {messages} messages could be, the first because {why}"
    )]
    Undecodable {
        /// The file.
        log: String,
        /// The topic.
        topic: String,
        /// Messages seen.
        messages: u64,
        /// What was wrong with the first.
        why: String,
    },
}

fn list(found: &[String]) -> String {
    if found.is_empty() {
        "no topics at all".into()
    } else {
        found.join(", ")
    }
}
