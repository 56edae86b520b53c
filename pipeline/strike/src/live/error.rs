//! Why the live topics cannot be used.

/// Texts complete "failed to …".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LiveError {
    /// It is no address of a server.
    #[error(
        "use the address `{0}`: it must be `ws://HOST:PORT` of a Foxglove WebSocket server, such as ws://localhost:8765 (TLS, `wss://`, \
         is not spoken)"
    )]
    Address(String),
    /// No connection, or one that broke off.
    #[error("reach the live topics at {url}: {why}")]
    Connection {
        /// The server.
        url: String,
        /// What happened, and how to mend it.
        why: String,
    },
    /// The server does not keep to the protocol.
    #[error("read the live topics of {url}: {why}")]
    Protocol {
        /// The server.
        url: String,
        /// What is wrong.
        why: String,
    },
    /// Neither the centroid's topic nor the pose's is there.
    #[error(
        "find the object in the live topics of {url}: neither {centroid} nor {pose} is there, it has {found}; set the names in the rig \
         file under [topics]"
    )]
    NoTopic {
        /// The server.
        url: String,
        /// Topic of the centroid.
        centroid: String,
        /// Topic of the pose.
        pose: String,
        /// What is there.
        found: String,
    },
    /// The object's places come in a frame, and then in another one.
    #[error(
        "tell where the object is: the camera's messages came in frame `{0}`, and now come in frame `{1}` (frame_id): a place of one is not that \
         of the other; let one tracker publish it, in the frame of the table, and start again"
    )]
    Frames(String, String),
    /// The object is not seen, or not at rest, or not where it was.
    #[error("see the object at rest: {0}")]
    NotAtRest(String),
}
