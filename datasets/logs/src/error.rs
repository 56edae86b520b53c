//! What can keep a log from being read.

/// Why a log could not be read; each text completes "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum LogError {
    #[error("read log {log}: {source}")]
    Io { log: String, source: std::io::Error },
    #[error(
        "read log {log}: it is empty (0 bytes); its recording never began, or it was not copied: record or copy it again, or take it away"
    )]
    Empty { log: String },
    #[error(
        "read log {log}: it is no MCAP file (it does not begin with MCAP's magic bytes) and no bag of SQLite; record with \
         `ros2 bag record -s mcap`, or convert it with `ros2 bag convert` or `mcap convert`"
    )]
    NotMcap { log: String },
    #[error(
        "read log {log}: it is a folder without rosbag2's `metadata.yaml`, or with one that lists no files; name the files in it, or \
         write it anew with `ros2 bag reindex`"
    )]
    NoBag { log: String },
    #[error("read log {log}, a bag of SQLite: {why}")]
    Sqlite { log: String, why: String },
    #[error(
        "read log {log}: the {what} at byte {offset} takes {size} bytes where at most {limit} are read; \
         write the log anew with smaller chunks, such as `mcap filter --chunk-size 1048576`"
    )]
    TooLarge {
        log: String,
        what: &'static str,
        offset: u64,
        size: u64,
        limit: u64,
    },
    #[error(
        "read log {log}: a chunk is compressed with `{compression}`; use zstd, lz4 or no compression"
    )]
    Compression { log: String, compression: String },
    #[error(
        "find topic {topic} in log {log}: it has {}; set the topic's name in rig.toml under [topics]{}",
        list(found),
        if *images { ". Camera images are there: name their topic under [topics.image], with the camera's lens and pose and the object's colour, to take the centroid from them" } else { "" }
    )]
    MissingTopic {
        log: String,
        topic: String,
        found: Vec<String>,
        images: bool,
    },
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
        topic: String,
        message: String,
        schema: String,
    },
    #[error("decode topic {topic}: its schema {schema} is unusable: {why}")]
    Schema {
        topic: String,
        schema: String,
        why: String,
    },
    #[error("find field `{path}` of topic {topic}: {why}; set the path in rig.toml under [topics]")]
    Field {
        topic: String,
        path: String,
        why: String,
    },
    #[error(
        "decode topic {topic} of log {log}: none of its {messages} messages could be, the first because {why}"
    )]
    Undecodable {
        log: String,
        topic: String,
        messages: u64,
        why: String,
    },
}

impl LogError {
    /// A log that the system does not let be read.
    pub(crate) fn io(log: impl std::fmt::Display, source: std::io::Error) -> Self {
        let log = log.to_string();
        Self::Io { log, source }
    }
}

fn list(found: &[String]) -> String {
    if found.is_empty() {
        "no topics at all".into()
    } else {
        found.join(", ")
    }
}
