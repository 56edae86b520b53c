//! Why the live topics cannot be used.

/// Why the live topics cannot be used. Texts complete "failed to …".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum LiveError {
    #[error(
        "use the address `{0}`: it must be `ws://HOST:PORT` of a Foxglove WebSocket server, such as ws://localhost:8765 (TLS, `wss://`, \
         is not spoken)"
    )]
    Address(String),
    #[error("reach the live topics at {url}: {why}")]
    Connection { url: String, why: String },
    #[error("read the live topics of {url}: {why}")]
    Protocol { url: String, why: String },
    #[error(
        "find the object in the live topics of {url}: neither {centroid} nor {pose} is there, it has {found}; set the names in the rig \
         file under [topics]"
    )]
    NoTopic {
        url: String,
        centroid: String,
        pose: String,
        found: String,
    },
    #[error(
        "tell where the object is: the camera's messages came in frame `{0}`, and now come in frame `{1}` (frame_id): a place of one is not that \
         of the other; let one tracker publish it, in the frame of the table, and start again"
    )]
    Frames(String, String),
    #[error("see the object at rest: {0}")]
    NotAtRest(String),
}
