//! The Foxglove WebSocket protocol, as far as a client needs it that listens: what a server says, and the subscription.
//!
//! Source: `foxglove/ws-protocol`, `docs/spec.md` (`foxglove.websocket.v1`), and the servers of Foxglove's SDK, which call the same
//! messages `foxglove.sdk.v1`. Control messages are JSON, a message's data is a binary frame: opcode 1, the subscription's id
//! (4 bytes), the server's time of receipt in ns (8 bytes), and the message; numbers are little-endian.

use data_encoding::BASE64;
use serde::Deserialize;

/// Names of the protocol, the one of today's servers first.
pub(super) const SUBPROTOCOLS: &str = "foxglove.sdk.v1, foxglove.websocket.v1";
/// Largest control message that is read, in bytes.
const LARGEST_CONTROL: usize = 16 << 20;
/// Opcode of a message's data.
const MESSAGE_DATA: u8 = 1;
/// Bytes before the message.
const DATA_HEADER: usize = 13;

/// A control message that matters here.
#[derive(Debug)]
pub(super) enum Control {
    Advertise(Vec<Channel>),
    Unadvertise(Vec<u64>),
    Error(String),
    Other,
}

#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Channel {
    pub(super) id: u64,
    pub(super) topic: String,
    pub(super) encoding: String,
    #[serde(default)]
    pub(super) schema_name: String,
    #[serde(default)]
    schema: String,
    #[serde(default)]
    schema_encoding: Option<String>,
}

impl Channel {
    /// The schema's encoding; where the server leaves it out, the one that goes with the message's encoding.
    pub(super) fn schema_encoding(&self) -> &str {
        match (&self.schema_encoding, self.encoding.as_str()) {
            (Some(encoding), _) => encoding,
            (None, "cdr") => "ros2msg",
            (None, "ros1") => "ros1msg",
            (None, "json") => "jsonschema",
            (None, encoding) => encoding,
        }
    }

    /// The schema's bytes. Errors where one that is no text is not in base64.
    pub(super) fn schema(&self) -> Result<Vec<u8>, String> {
        match self.schema_encoding() {
            "protobuf" | "flatbuffer" => BASE64.decode(self.schema.as_bytes()).map_err(|error| {
                format!("the schema of topic {} is no base64: {error}", self.topic)
            }),
            _ => Ok(self.schema.clone().into_bytes()),
        }
    }
}

/// Reads a control message. Errors where it is none.
pub(super) fn control(text: &str) -> Result<Control, String> {
    #[derive(Deserialize)]
    struct Operation {
        op: String,
    }
    #[derive(Deserialize)]
    struct Advertise {
        channels: Vec<Channel>,
    }
    #[derive(Deserialize)]
    #[serde(rename_all = "camelCase")]
    struct Unadvertise {
        channel_ids: Vec<u64>,
    }
    #[derive(Deserialize)]
    struct Status {
        level: u8,
        message: String,
    }
    /// Level of an error in a status.
    const ERROR: u8 = 2;
    if text.len() > LARGEST_CONTROL {
        return Err(format!("a control message has {} bytes", text.len()));
    }
    let wrong = |error: serde_json::Error| format!("a control message makes no sense: {error}");
    let Operation { op } = serde_json::from_str(text).map_err(wrong)?;
    Ok(match op.as_str() {
        "advertise" => {
            let Advertise { channels } = serde_json::from_str(text).map_err(wrong)?;
            Control::Advertise(channels)
        }
        "unadvertise" => {
            let Unadvertise { channel_ids } = serde_json::from_str(text).map_err(wrong)?;
            Control::Unadvertise(channel_ids)
        }
        "status" => {
            let Status { level, message } = serde_json::from_str(text).map_err(wrong)?;
            if level >= ERROR {
                Control::Error(message)
            } else {
                Control::Other
            }
        }
        _ => Control::Other,
    })
}

pub(super) fn subscribe(subscription: u32, channel: u64) -> String {
    format!(
        r#"{{"op":"subscribe","subscriptions":[{{"id":{subscription},"channelId":{channel}}}]}}"#
    )
}

/// The subscription's id and the message of a binary frame; none where it is of another kind. Errors where it is too short.
pub(super) fn message(frame: &[u8]) -> Result<Option<(u32, &[u8])>, String> {
    match frame.first() {
        Some(&MESSAGE_DATA) => {}
        Some(_) => return Ok(None),
        None => return Err("a binary frame is empty".into()),
    }
    let id = frame
        .get(1..5)
        .and_then(|four| four.try_into().ok())
        .map(u32::from_le_bytes);
    match (id, frame.get(DATA_HEADER..)) {
        (Some(id), Some(message)) => Ok(Some((id, message))),
        _ => Err(format!(
            "a message's frame has {} bytes, fewer than its header",
            frame.len()
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_server_says_is_read_or_reported() {
        let text = r#"{"op":"advertise","channels":[
            {"id":3,"topic":"/a","encoding":"protobuf","schemaName":"A","schema":"aGk=","more":1},
            {"id":4,"topic":"/b","encoding":"cdr","schemaName":"B","schema":"float64 x"}]}"#;
        let Ok(Control::Advertise(channels)) = control(text) else {
            panic!("{text}");
        };
        assert_eq!(channels[0].schema().as_deref(), Ok(&b"hi"[..]));
        assert_eq!(channels[1].schema_encoding(), "ros2msg");
        assert!(matches!(
            control(r#"{"op":"unadvertise","channelIds":[3]}"#),
            Ok(Control::Unadvertise(ids)) if ids == [3]
        ));
        assert!(matches!(
            control(r#"{"op":"serverInfo","name":"x"}"#),
            Ok(Control::Other)
        ));
        for text in [
            "",
            "{",
            "[]",
            r#"{"op":3}"#,
            r#"{"op":"advertise"}"#,
            r#"{"op":"advertise","channels":[{"id":-1}]}"#,
            r#"{"op":"advertise","channels":[{"id":1,"id":2,"topic":"a","encoding":"json"}]}"#,
        ] {
            assert!(control(text).is_err(), "{text}");
        }
    }

    #[test]
    fn frames_of_any_length_are_read_or_reported() {
        let mut frame = vec![1, 7, 0, 0, 0];
        frame.extend(5u64.to_le_bytes());
        frame.extend(b"data");
        assert_eq!(message(&frame), Ok(Some((7, &b"data"[..]))));
        assert_eq!(message(&[2, 0]), Ok(None));
        for length in 0..DATA_HEADER {
            assert!(message(&frame[..length]).is_err(), "{length}");
        }
    }
}
