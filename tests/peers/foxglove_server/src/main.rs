//! `foxglove-server ENCODING`: a server of the `foxglove` crate that publishes an object's place 60 times a second, as `json`, `cdr` or
//! `protobuf`. It prints its port and ends with its standard input. `watch.py` holds what the executor reads of it against the place.

use std::error::Error;
use std::io::Read;
use std::thread;
use std::time::{Duration, SystemTime};

use foxglove::messages::{Pose, PoseInFrame, Quaternion, Vector3};
use foxglove::{ChannelBuilder, Schema, WebSocketServer};

/// Where the object is, in m and rad; the same numbers are in `watch.py`.
const PLACE: [f64; 2] = [0.31, -0.07];
const YAW: f64 = 0.02;
const POINT_STAMPED: &str = "std_msgs/Header header
geometry_msgs/Point point
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
";

type Publish = Box<dyn FnMut(Duration) + Send>;

fn main() -> Result<(), Box<dyn Error>> {
    let encoding = std::env::args()
        .nth(1)
        .ok_or("give json, cdr or protobuf")?;
    let mut publish = publisher(&encoding)?;
    let server = WebSocketServer::new()
        .name("a lab")
        .bind("127.0.0.1", 0)
        .start_blocking()?;
    println!("{}", server.port());
    thread::spawn(move || {
        loop {
            let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
            publish(now.unwrap_or_default());
            thread::sleep(Duration::from_secs(1) / 60);
        }
    });
    std::io::stdin().read_to_end(&mut Vec::new())?;
    Ok(())
}

fn publisher(encoding: &str) -> Result<Publish, Box<dyn Error>> {
    Ok(match encoding {
        "json" => {
            let schema = Schema::new("PointStamped", "jsonschema", br#"{"type": "object"}"#);
            let channel = ChannelBuilder::new("/object/centroid")
                .schema(schema)
                .message_encoding("json")
                .build_raw()?;
            Box::new(move |now| {
                let stamp = format!(
                    r#"{{"sec":{},"nanosec":{}}}"#,
                    now.as_secs(),
                    now.subsec_nanos()
                );
                let header = format!(r#"{{"stamp":{stamp},"frame_id":"table"}}"#);
                let point = format!(r#"{{"x":{},"y":{},"z":0.0}}"#, PLACE[0], PLACE[1]);
                channel.log(format!(r#"{{"header":{header},"point":{point}}}"#).as_bytes());
            })
        }
        "cdr" => {
            let schema = Schema::new(
                "geometry_msgs/msg/PointStamped",
                "ros2msg",
                POINT_STAMPED.as_bytes(),
            );
            let channel = ChannelBuilder::new("/object/centroid")
                .schema(schema)
                .message_encoding("cdr")
                .build_raw()?;
            Box::new(move |now| {
                let mut message = vec![0, 1, 0, 0];
                message.extend((now.as_secs() as u32).to_le_bytes());
                message.extend(now.subsec_nanos().to_le_bytes());
                message.extend(6_u32.to_le_bytes());
                // The name of the frame ends with a zero; numbers of 8 bytes are aligned.
                message.extend(b"table\0\0\0\0\0\0\0");
                for number in [PLACE[0], PLACE[1], 0.0] {
                    message.extend(number.to_le_bytes());
                }
                channel.log(&message);
            })
        }
        "protobuf" => {
            let channel = ChannelBuilder::new("/object/pose").build::<PoseInFrame>();
            Box::new(move |_| {
                channel.log(&PoseInFrame {
                    timestamp: None,
                    frame_id: "table".into(),
                    pose: Some(Pose {
                        position: Some(Vector3 {
                            x: PLACE[0],
                            y: PLACE[1],
                            z: 0.0,
                        }),
                        orientation: Some(Quaternion {
                            x: 0.0,
                            y: 0.0,
                            z: (YAW / 2.0).sin(),
                            w: (YAW / 2.0).cos(),
                        }),
                    }),
                });
            })
        }
        other => return Err(format!("{other}: give json, cdr or protobuf").into()),
    })
}
