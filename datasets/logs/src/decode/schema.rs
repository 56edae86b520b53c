//! A channel's schema.

/// A channel's schema as the file holds it.
#[derive(Clone, Copy, Debug)]
pub struct SchemaText<'a> {
    /// Message type, such as `geometry_msgs/msg/PointStamped`.
    pub name: &'a str,
    /// `ros2msg`, `ros1msg`, `protobuf`, `jsonschema` …
    pub encoding: &'a str,
    /// Its text, or a serialized `FileDescriptorSet`.
    pub data: &'a [u8],
}
