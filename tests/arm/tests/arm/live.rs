//! Live topics: servers that keep to the protocol, and servers that do not.

use std::f64::consts::PI;
use std::io::Write;
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use arm::foxglove::{Topic, accept};
use strike::{Epoch, Live, LiveError, Resting};
use tungstenite::{Message, WebSocket};
use values::{Point, Rig, Shape};

use crate::bench::rig;

/// How long an object that is not at rest is waited for.
const PATIENCE: Duration = Duration::from_secs(4);
/// How long anything may take on a machine that is slow and busy: what takes longer hangs.
const HANGS: Duration = Duration::from_secs(90);
const CENTROID: &str = r#"{"id":5,"topic":"/object/centroid","encoding":"json"}"#;

fn never() -> AtomicBool {
    AtomicBool::new(false)
}

/// A camera that publishes places at 60 Hz until the flag is set.
fn camera(at: impl Fn(f64) -> Option<[f64; 2]> + Send + 'static) -> (String, Arc<AtomicBool>) {
    publishing("/object/centroid", move |topic, t| {
        if let Some([x, y]) = at(t) {
            topic.publish(x, y);
        }
    })
}

/// A topic that this publishes at 60 Hz, given the seconds since it began, until the flag is set.
fn publishing(
    name: &str,
    publish: impl Fn(&Topic, f64) + Send + 'static,
) -> (String, Arc<AtomicBool>) {
    let topic = Topic::serve(([127, 0, 0, 1], 0).into(), name).unwrap();
    let (url, ends) = (
        format!("ws://{}", topic.address),
        Arc::<AtomicBool>::default(),
    );
    let until = ends.clone();
    thread::spawn(move || {
        let begun = Instant::now();
        while !until.load(Ordering::Relaxed) {
            publish(&topic, begun.elapsed().as_secs_f64());
            thread::sleep(Duration::from_millis(16));
        }
    });
    (url, ends)
}

/// Looks again and again until what is seen is what is waited for.
fn until<T>(
    look: impl Fn() -> Result<T, LiveError>,
    is_it: impl Fn(&Result<T, LiveError>) -> bool,
) {
    let begun = Instant::now();
    let mut last = String::new();
    while begun.elapsed() < HANGS {
        let seen = look();
        if is_it(&seen) {
            return;
        }
        last = seen
            .err()
            .map_or("at rest".into(), |error| error.to_string());
        thread::sleep(Duration::from_millis(10));
    }
    panic!("{last}");
}

/// Whether what is seen is an error with this text.
fn says<T>(text: &str) -> impl Fn(&Result<T, LiveError>) -> bool {
    move |seen| {
        let said = seen.as_ref().err().map(ToString::to_string);
        said.is_some_and(|said| said.contains(text))
    }
}

#[test]
fn an_object_is_seen_at_rest_and_again_where_it_comes_to_rest() {
    let place: Arc<Mutex<[f64; 2]>> = Arc::new(Mutex::new([0.3, 0.02]));
    let shown = place.clone();
    let (url, ends) = camera(move |_| Some(*shown.lock().unwrap()));
    let live = Live::connect(&url, &rig()).unwrap();
    let rest = live.wait_for_rest(HANGS, &never()).unwrap();
    assert!(rest.point.distance(Point::new(0.3, 0.02)) < 1e-6);
    until(|| live.is_still(&rest), Result::is_ok);
    let elsewhere = Resting::at(Point::new(0.31, 0.02));
    until(|| live.is_still(&elsewhere), says("moved by 10.0 mm"));
    live.record();
    *place.lock().unwrap() = [0.6, 0.02];
    let since = Instant::now() + Duration::from_millis(100);
    let stop = live.wait_for_stop(since, HANGS, &never()).unwrap();
    assert!(
        stop.point.distance(Point::new(0.6, 0.02)) < 1e-3,
        "{stop:?}"
    );
    let (received, left_out) = live.recorded(Epoch::now());
    assert!(
        received.len() > 5 && left_out.is_none(),
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
        (|t| (t < 0.9).then_some([0.3, 0.0]), "has not seen it"),
    ];
    for (seen, said) in cases {
        let (url, ends) = camera(seen);
        let live = Live::connect(&url, &rig()).unwrap();
        until(
            || live.wait_for_rest(Duration::from_millis(50), &never()),
            says(said),
        );
        ends.store(true, Ordering::Relaxed);
    }
}

#[test]
fn an_object_that_was_taken_away_a_moment_ago_or_whose_stamps_are_old_is_not_there() {
    let topic = Topic::serve(([127, 0, 0, 1], 0).into(), "/object/centroid").unwrap();
    let live = Live::connect(&format!("ws://{}", topic.address), &rig()).unwrap();
    let mut rest = None;
    let begun = Instant::now();
    while rest.is_none() && begun.elapsed() < HANGS {
        topic.publish(0.3, 0.0);
        thread::sleep(Duration::from_millis(10));
        rest = live.at_rest().ok();
    }
    let rest = rest.expect("it rests");
    // Nothing is published any more; what is on its way may still come.
    let is_gone = (0..5).any(|_| live.is_still(&rest).is_err());
    assert!(is_gone, "it was seen a moment ago, and is gone");
    // The last place again and again, and the last hundred of them.
    let now = Epoch::now().stamp(Instant::now());
    for places in [1, 100] {
        let next = AtomicU64::new(0);
        until(
            || {
                let place = next.fetch_add(1, Ordering::Relaxed) % places;
                let stamp = now - (100 - place) * 1_000_000;
                topic.send(&format!(
                    r#"{{"header":{{"stamp":{{"sec":{},"nanosec":{}}},"frame_id":"table"}},"point":{{"x":0.3,"y":0.0}}}}"#,
                    stamp / 1_000_000_000,
                    stamp % 1_000_000_000
                ));
                live.is_still(&rest)
            },
            says("stamps stand still or run backwards"),
        );
    }
}

#[test]
fn places_that_come_in_another_frame_than_before_are_no_places() {
    let frame = Arc::new(Mutex::new("table"));
    let shown = frame.clone();
    let (url, ends) = publishing("/object/centroid", move |topic, _| {
        topic.publish_in(*shown.lock().unwrap(), [0.3, 0.0, 0.0]);
    });
    let live = Live::connect(&url, &rig()).unwrap();
    let rest = live.wait_for_rest(HANGS, &never()).unwrap();
    let ended: Arc<Mutex<String>> = Arc::default();
    let told = ended.clone();
    live.watch(rest, move |_, why| *told.lock().unwrap() = why.into());
    *frame.lock().unwrap() = "camera";
    until(|| live.is_still(&rest), Result::is_err);
    let error = live.at_rest().unwrap_err();
    assert!(matches!(error, LiveError::Frames(..)), "{error}");
    let text = error.to_string();
    assert!(
        text.contains("`table`") && text.contains("`camera`"),
        "{text}"
    );
    // Whoever watches the run-up is told, too.
    let ended = ended.lock().unwrap().clone();
    assert!(
        ended.contains("`camera`") && ended.contains("run-up"),
        "{ended}"
    );
    // It does not come back by itself.
    *frame.lock().unwrap() = "table";
    thread::sleep(Duration::from_millis(100));
    assert!(live.wait_for_rest(PATIENCE, &never()).is_err());
    ends.store(true, Ordering::Relaxed);
}

#[test]
fn an_object_that_is_lifted_where_it_lies_is_not_on_the_table_and_any_constant_height_is() {
    for (height, frame) in [(0.0, "table"), (0.8, "world"), (-3.0, "")] {
        let z = Arc::new(Mutex::new(height));
        let shown = z.clone();
        let (url, ends) = publishing("/object/centroid", move |topic, _| {
            topic.publish_in(frame, [0.3, 0.0, *shown.lock().unwrap()]);
        });
        let live = Live::connect(&url, &rig()).unwrap();
        let rest = live.wait_for_rest(HANGS, &never()).unwrap();
        until(|| live.is_still(&rest), Result::is_ok);
        // The demo's object is 40 mm high.
        *z.lock().unwrap() = height + 0.03;
        until(|| live.at_rest(), says("30.0 mm higher"));
        *z.lock().unwrap() = height;
        until(|| live.is_still(&rest), Result::is_ok);
        ends.store(true, Ordering::Relaxed);
    }
}

#[test]
fn a_box_that_was_turned_where_it_lies_is_not_still_and_half_a_turn_is_none() {
    let yaw: Arc<Mutex<f64>> = Arc::new(Mutex::new(0.1));
    let shown = yaw.clone();
    let (url, ends) = publishing("/object/pose", move |topic, _| {
        let (z, w) = (0.5 * *shown.lock().unwrap()).sin_cos();
        let stamp = Epoch::now().stamp(Instant::now());
        let (seconds, rest_of_it) = (stamp / 1_000_000_000, stamp % 1_000_000_000);
        topic.send(&format!(
            r#"{{"header":{{"stamp":{{"sec":{seconds},"nanosec":{rest_of_it}}}}},"pose":{{"position":{{"x":0.3,"y":0.0}},"orientation":{{"x":0.0,"y":0.0,"z":{z},"w":{w}}}}}}}"#
        ));
    });
    let mut rig = rig();
    rig.object.solid = Rig::demo(Shape::Box).object.solid;
    let live = Live::connect(&url, &rig).unwrap();
    let rest = live.wait_for_rest(HANGS, &never()).unwrap();
    until(|| live.is_still(&rest), Result::is_ok);
    *yaw.lock().unwrap() = 0.16;
    until(|| live.is_still(&rest), says("turned by 0.060"));
    *yaw.lock().unwrap() = 0.1 - PI;
    until(|| live.is_still(&rest), Result::is_ok);
    ends.store(true, Ordering::Relaxed);
}

#[test]
fn a_clock_that_differs_is_reported_before_a_log_joins_both() {
    let topic = Topic::serve(([127, 0, 0, 1], 0).into(), "/object/centroid").unwrap();
    let live = Live::connect(&format!("ws://{}", topic.address), &rig()).unwrap();
    let sends = |message: &str, said: &str| {
        let sent = AtomicU32::new(0);
        until(
            || {
                let number = sent.fetch_add(1, Ordering::Relaxed);
                topic.send(&message.replace("NUMBER", &number.to_string()));
                live.at_rest()
            },
            says(said),
        );
    };
    sends(
        r#"{"header":{"stamp":{"sec":1000,"nanosec":NUMBER}},"point":{"x":0.3,"y":0.0}}"#,
        "behind this computer's clock",
    );
    // Messages that make no sense are reported beside what is missing.
    sends(
        r#"{"point":{"x":"far"}}"#,
        "a message of topic /object/centroid",
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

/// What a server asks whether the test is over: it ends nothing by the time that passed.
struct Over(Receiver<()>);

impl Over {
    fn is_over(&self) -> bool {
        self.0.try_recv() == Err(TryRecvError::Disconnected)
    }

    fn wait(&self) {
        let _ = self.0.recv();
    }
}

/// Whether connecting to a server that does this fails with a text that holds `said`.
fn fails(serve: impl FnOnce(TcpStream, &Over) + Send + 'static, said: &str) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("ws://{}", listener.local_addr().unwrap());
    let (goes_on, over) = mpsc::channel::<()>();
    thread::spawn(move || serve(listener.accept().unwrap().0, &Over(over)));
    let begun = Instant::now();
    let error = Live::connect(&url, &rig()).and_then(|live| live.wait_for_rest(PATIENCE, &never()));
    let text = error.unwrap_err().to_string();
    drop(goes_on);
    assert!(text.contains(said), "{said}: {text}");
    assert!(begun.elapsed() < HANGS, "{said}");
}

/// Whether connecting to a server that does this once the WebSocket is open fails with a text that holds `said`.
fn fails_then(serve: impl FnOnce(WebSocket<TcpStream>, &Over) + Send + 'static, said: &str) {
    fails(
        move |stream, over| {
            // A machine that is busy may have given up the handshake.
            if let Some(socket) = accept(stream) {
                serve(socket, over);
            }
        },
        said,
    );
}

#[test]
fn a_server_that_is_silent_or_slow_in_its_handshake_is_given_up() {
    fails(|_stream, over| over.wait(), "handshake was not over");
    fails(
        |mut stream, _| {
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
        |mut stream, _| drop(stream.write_all(b"HTTP/1.1 200 OK\r\n\r\n")),
        "reach the live topics",
    );
    fails(
        |mut stream, _| drop(stream.write_all(&[0xff; 4096])),
        "reach the live topics",
    );
    fails(|stream, _| drop(stream), "reach the live topics");
    // A header without end.
    fails(
        |mut stream, _| while stream.write_all(&[b'a'; 4096]).is_ok() {},
        "reach the live topics",
    );
}

#[test]
fn a_server_that_advertises_no_topics_or_others_is_reported() {
    fails_then(|_socket, over| over.wait(), "no topics at all");
    fails_then(
        |mut socket, over| {
            let others =
                r#"{"op":"advertise","channels":[{"id":1,"topic":"/tf","encoding":"cdr"}]}"#;
            socket.send(Message::text(others)).unwrap();
            over.wait();
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
            move |mut socket, over| {
                let _ = socket.send(Message::text(text));
                over.wait();
            },
            said,
        );
    }
}

#[test]
fn frames_that_are_half_empty_or_too_large_end_the_listening() {
    let half = vec![0x82, 100, 1, 1, 0];
    let cases: [(Vec<u8>, &str, bool); 6] = [
        // Whole messages without anything, and without all of a header.
        (vec![0x82, 0], "empty", true),
        (
            vec![0x82, 6, 1, 1, 0, 0, 0, 9],
            "fewer than its header",
            true,
        ),
        // A frame that says it has 2^63 bytes, and one of a kind that is not there.
        (
            vec![0x82, 127, 0x7f, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff],
            "reach the live topics",
            true,
        ),
        (vec![0xff; 32], "reach the live topics", true),
        // Half a frame, and then nothing; half a frame, and then the end.
        (half.clone(), "not seen it yet", true),
        (half, "reach the live topics", false),
    ];
    for (bytes, said, waits) in cases {
        fails_then(
            move |mut socket, over| {
                let advertise = format!(r#"{{"op":"advertise","channels":[{CENTROID}]}}"#);
                socket.send(Message::text(advertise)).unwrap();
                socket.get_mut().write_all(&bytes).unwrap();
                if waits {
                    over.wait();
                }
            },
            said,
        );
    }
}

#[test]
fn messages_of_subscriptions_that_nobody_made_are_passed_over() {
    fails_then(
        move |mut socket, over| {
            let advertise = format!(r#"{{"op":"advertise","channels":[{CENTROID}]}}"#);
            socket.send(Message::text(advertise)).unwrap();
            while !over.is_over() {
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
