//! What a server of live topics sends: control messages and frames.

use anyhow::anyhow;
use strike::{ServerMessage, read_messages};
use values::Topics;

const CENTROID: &str = r#"{"op":"advertise","channels":[{"id":5,"topic":"/object/centroid","encoding":"json","schemaName":"","schema":""}]}"#;
const POSE: &str = r#"{"op":"advertise","channels":[{"id":7,"topic":"/object/pose","encoding":"json","schemaName":"P","schema":"{}"}]}"#;
const GONE: &str = r#"{"op":"unadvertise","channelIds":[5]}"#;
const STATUS: &str = r#"{"op":"status","level":2,"message":"full"}"#;
const POINT: &[u8] = br#"{"header":{"stamp":{"sec":1,"nanosec":5}},"point":{"x":0.3,"y":0.1}}"#;
const PLACE: &[u8] =
    br#"{"pose":{"position":{"x":0.3,"y":0.1},"orientation":{"x":0,"y":0,"z":0,"w":1}}}"#;

/// Sequences of messages: of each, two bytes are its length and one says whether it is binary.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    let text_message = |text: &str| whole(0, text.as_bytes());
    let frame = |subscription: u32, data: &[u8]| {
        let header = [&[1][..], &subscription.to_le_bytes(), &9_u64.to_le_bytes()].concat();
        whole(1, &[&header, data].concat())
    };
    vec![
        [text_message(CENTROID), frame(1, POINT), frame(1, POINT)].concat(),
        [
            text_message(POSE),
            text_message(CENTROID),
            frame(1, PLACE),
            frame(2, POINT),
        ]
        .concat(),
        [
            text_message(CENTROID),
            text_message(GONE),
            text_message(CENTROID),
            frame(2, POINT),
        ]
        .concat(),
        [
            text_message(STATUS),
            text_message(CENTROID),
            frame(1, b"{}"),
        ]
        .concat(),
    ]
}

fn whole(kind: u8, message: &[u8]) -> Vec<u8> {
    let length = (message.len() as u16).to_le_bytes();
    [&length[..], &[kind], message].concat()
}

/// Reads such a sequence, as the executor does; a text that is no UTF-8 never leaves the WebSocket.
pub(super) fn reader(topics: Topics) -> impl Fn(&[u8]) -> anyhow::Result<()> {
    move |mut input| {
        let mut messages = Vec::new();
        while let Some(([low, high, kind], rest)) = input.split_first_chunk() {
            let length = usize::from(u16::from_le_bytes([*low, *high])).min(rest.len());
            let (message, more) = rest.split_at(length);
            match (kind, str::from_utf8(message)) {
                (0, Ok(text)) => messages.push(ServerMessage::Control(text)),
                _ => messages.push(ServerMessage::Data(message)),
            }
            input = more;
        }
        read_messages(&topics, &messages)
            .map(drop)
            .map_err(|why| anyhow!(why))
    }
}
