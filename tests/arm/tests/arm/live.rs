//! Live topics: servers that keep to the protocol, and servers that do not.

use std::io::Write;
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use arm::foxglove::{Topic, accept};
use strike::{Live, LiveError};
use tungstenite::{Message, WebSocket};
use values::Point;

use crate::bench::rig;

const PATIENCE: Duration = Duration::from_secs(4);
const CENTROID: &str = r#"{"id":5,"topic":"/object/centroid","encoding":"json"}"#;

fn never() -> AtomicBool {
    AtomicBool::new(false)
}

/// A camera that publishes places at 60 Hz until the flag is set.
fn camera(at: impl Fn(f64) -> Option<[f64; 2]> + Send + 'static) -> (String, Arc<AtomicBool>) {
    let topic = Topic::serve(([127, 0, 0, 1], 0).into(), "/object/centroid").unwrap();
    let (url, ends) = (
        format!("ws://{}", topic.address),
        Arc::<AtomicBool>::default(),
    );
    let until = ends.clone();
    thread::spawn(move || {
        let begun = Instant::now();
        while !until.load(Ordering::Relaxed) {
            if let Some([x, y]) = at(begun.elapsed().as_secs_f64()) {
                topic.publish(x, y);
            }
            thread::sleep(Duration::from_millis(16));
        }
    });
    (url, ends)
}

#[test]
fn an_object_is_seen_at_rest_and_again_where_it_comes_to_rest() {
    let (url, ends) = camera(|t| {
        let slid = (t - 1.5).clamp(0.0, 1.0);
        Some([0.3 + 0.3 * slid, 0.02])
    });
    let live = Live::connect(&url, &rig()).unwrap();
    let rest = live.wait_for_rest(PATIENCE, &never()).unwrap();
    assert!(rest.point.distance(Point::new(0.3, 0.02)) < 1e-6);
    live.is_still_at(rest.point).unwrap();
    let moved = live.is_still_at(Point::new(0.31, 0.02)).unwrap_err();
    assert!(moved.to_string().contains("moved by 10.0 mm"), "{moved}");
    live.record();
    thread::sleep(Duration::from_millis(1_500));
    let stop = live
        .wait_for_stop(Instant::now(), PATIENCE, &never())
        .unwrap();
    assert!(
        stop.point.distance(Point::new(0.6, 0.02)) < 1e-3,
        "{stop:?}"
    );
    let (received, left_out) = live.recorded();
    assert!(
        received.len() > 100 && left_out.is_none(),
        "{}",
        received.len()
    );
    assert!(received.is_sorted_by_key(|message| message.log_time));
    assert_eq!(received[0].channel.schema, "geometry_msgs/msg/PointStamped");
    ends.store(true, Ordering::Relaxed);
}

#[test]
fn what_is_not_at_rest_is_reported_and_waiting_ends() {
    type Seen = fn(f64) -> Option<[f64; 2]>;
    let cases: [(Seen, &str); 4] = [
        (|t| Some([0.3 + 0.1 * t, 0.0]), "moves"),
        (
            |t| {
                Some([
                    0.3,
                    if ((t * 37.0) as u32).is_multiple_of(2) {
                        0.2
                    } else {
                        -0.1
                    },
                ])
            },
            "two objects",
        ),
        (|_| None, "not seen it yet"),
        (|t| (t < 0.9).then_some([0.3, 0.0]), "has not seen it for"),
    ];
    for (seen, said) in cases {
        let (url, ends) = camera(seen);
        let live = Live::connect(&url, &rig()).unwrap();
        thread::sleep(Duration::from_millis(1_300));
        let error = live
            .wait_for_rest(Duration::from_millis(50), &never())
            .unwrap_err();
        assert!(matches!(error, LiveError::NotAtRest(_)), "{error}");
        assert!(error.to_string().contains(said), "{said}: {error}");
        ends.store(true, Ordering::Relaxed);
    }
}

#[test]
fn a_clock_that_differs_is_reported_before_a_log_joins_both() {
    let topic = Topic::serve(([127, 0, 0, 1], 0).into(), "/object/centroid").unwrap();
    let live = Live::connect(&format!("ws://{}", topic.address), &rig()).unwrap();
    for _ in 0..80 {
        topic.send(r#"{"header":{"stamp":{"sec":1000,"nanosec":0}},"point":{"x":0.3,"y":0.0}}"#);
        thread::sleep(Duration::from_millis(10));
    }
    let error = live.at_rest().unwrap_err().to_string();
    assert!(error.contains("behind this computer's clock"), "{error}");
    // Messages that make no sense are reported beside what is missing.
    for _ in 0..40 {
        topic.send(r#"{"point":{"x":"far"}}"#);
        thread::sleep(Duration::from_millis(10));
    }
    let error = live.at_rest().unwrap_err().to_string();
    assert!(
        error.contains("a message of topic /object/centroid"),
        "{error}"
    );
}

#[test]
fn addresses_that_are_none_and_servers_that_are_not_there_are_reported() {
    for text in [
        "",
        "localhost:8765",
        "wss://localhost:8765",
        "http://localhost:1",
        "ws://localhost",
        "ws://",
    ] {
        let error = Live::connect(text, &rig()).unwrap_err();
        assert!(matches!(error, LiveError::Address(_)), "{text}: {error}");
    }
    let free = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    let error = Live::connect(&format!("ws://{free}"), &rig()).unwrap_err();
    assert!(matches!(error, LiveError::Connection { .. }), "{error}");
}

/// Whether connecting to a server that does this fails with a text that holds `said`, within ten seconds.
fn fails(serve: impl FnOnce(TcpStream) + Send + 'static, said: &str) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("ws://{}", listener.local_addr().unwrap());
    thread::spawn(move || serve(listener.accept().unwrap().0));
    let begun = Instant::now();
    let error = Live::connect(&url, &rig()).and_then(|live| live.wait_for_rest(PATIENCE, &never()));
    let text = error.unwrap_err().to_string();
    assert!(text.contains(said), "{said}: {text}");
    assert!(begun.elapsed() < Duration::from_secs(11), "{said}");
}

/// The same once the WebSocket is open.
fn fails_then(serve: impl FnOnce(WebSocket<TcpStream>) + Send + 'static, said: &str) {
    fails(move |stream| serve(accept(stream).unwrap()), said);
}

fn wait() {
    thread::sleep(Duration::from_secs(8));
}

#[test]
fn a_server_that_is_silent_or_slow_in_its_handshake_is_given_up() {
    fails(|_stream| wait(), "handshake was not over");
    fails(
        |mut stream| {
            let _ = stream.write_all(b"HTTP/1.1 101 Switching Protocols\r\n");
            for byte in b"a: b\r\n".iter().cycle() {
                if stream.write_all(&[*byte]).is_err() {
                    return;
                }
                thread::sleep(Duration::from_millis(150));
            }
        },
        "handshake was not over",
    );
}

#[test]
fn a_server_that_is_none_is_reported() {
    fails(
        |mut stream| drop(stream.write_all(b"HTTP/1.1 200 OK\r\n\r\n")),
        "reach the live topics",
    );
    fails(
        |mut stream| drop(stream.write_all(&[0xff; 4096])),
        "reach the live topics",
    );
    fails(drop, "reach the live topics");
    // A header without end.
    fails(
        |mut stream| while stream.write_all(&[b'a'; 4096]).is_ok() {},
        "reach the live topics",
    );
}

#[test]
fn a_server_that_advertises_no_topics_or_others_is_reported() {
    fails_then(|_socket| wait(), "no topics at all");
    fails_then(
        |mut socket| {
            let others =
                r#"{"op":"advertise","channels":[{"id":1,"topic":"/tf","encoding":"cdr"}]}"#;
            socket.send(Message::text(others)).unwrap();
            wait();
        },
        "it has /tf",
    );
}

#[test]
fn control_messages_that_make_no_sense_end_the_listening() {
    let advertise = |channels: &str| format!(r#"{{"op":"advertise","channels":[{channels}]}}"#);
    for (text, said) in [
        ("{".to_owned(), "makes no sense"),
        ("[1]".to_owned(), "makes no sense"),
        (
            advertise(r#"{"id":1,"id":2,"topic":"/object/centroid","encoding":"json"}"#),
            "duplicate",
        ),
        (
            advertise(&format!(r#"{CENTROID},{}"#, CENTROID.replace('5', "6"))),
            "two programs",
        ),
        (
            advertise(&format!(
                r#"{CENTROID},{}"#,
                CENTROID.replace("json", "cdr")
            )),
            "different contents",
        ),
        (advertise(&CENTROID.replace("json", "morse")), "morse"),
        (
            advertise(
                &CENTROID
                    .replace("json", "protobuf")
                    .replace('}', r#","schema":"$"}"#),
            ),
            "base64",
        ),
        (format!(r#"{{"op":"{}"}}"#, "a".repeat(17 << 20)), "bytes"),
        (
            format!("{{\"op\":{}", "[".repeat(100_000)),
            "makes no sense",
        ),
    ] {
        fails_then(
            move |mut socket| {
                let _ = socket.send(Message::text(text));
                wait();
            },
            said,
        );
    }
}

#[test]
fn frames_that_are_half_empty_or_too_large_end_the_listening() {
    let advertised = |mut socket: WebSocket<TcpStream>| {
        let advertise = format!(r#"{{"op":"advertise","channels":[{CENTROID}]}}"#);
        socket.send(Message::text(advertise)).unwrap();
        socket
    };
    fails_then(
        move |socket| {
            let mut socket = advertised(socket);
            socket.send(Message::binary(vec![])).unwrap();
            wait();
        },
        "empty",
    );
    fails_then(
        move |socket| {
            let mut socket = advertised(socket);
            socket
                .send(Message::binary(vec![1, 1, 0, 0, 0, 9]))
                .unwrap();
            wait();
        },
        "fewer than its header",
    );
    // A frame that says it has 2^63 bytes, and one of a kind that is not there.
    for bytes in [
        vec![0x82, 127, 0x7f, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff],
        vec![0xff; 32],
    ] {
        fails_then(
            move |socket| {
                let mut socket = advertised(socket);
                socket.get_mut().write_all(&bytes).unwrap();
                wait();
            },
            "reach the live topics",
        );
    }
    // Half a frame, and then nothing; half a frame, and then the end.
    fails_then(
        move |socket| {
            let mut socket = advertised(socket);
            socket.get_mut().write_all(&[0x82, 100, 1, 1, 0]).unwrap();
            wait();
        },
        "not seen it yet",
    );
    fails_then(
        move |socket| {
            let mut socket = advertised(socket);
            socket.get_mut().write_all(&[0x82, 100, 1, 1, 0]).unwrap();
        },
        "reach the live topics",
    );
}

#[test]
fn messages_of_subscriptions_that_nobody_made_are_passed_over() {
    fails_then(
        move |mut socket| {
            let advertise = format!(r#"{{"op":"advertise","channels":[{CENTROID}]}}"#);
            socket.send(Message::text(advertise)).unwrap();
            for _ in 0..400 {
                let mut frame = vec![1, 77, 0, 0, 0];
                frame.extend([0; 8]);
                frame.extend(br#"{"point":{"x":0.3,"y":0.0}}"#);
                let _ = socket.send(Message::binary(frame));
                thread::sleep(Duration::from_millis(10));
            }
        },
        "not seen it yet",
    );
}
