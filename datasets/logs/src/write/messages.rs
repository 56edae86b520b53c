//! The ROS 2 messages that a strike and its pictures leave in CDR, with the schema text that rosbag2 would embed.

use values::Point;

/// The frame that every stamp's header names.
const FRAME: &str = "table";
/// The frame of the tip in `nav_msgs/msg/Odometry`.
pub(super) const TIP_FRAME: &str = "tip";
pub(super) const NANOSECONDS: u64 = 1_000_000_000;

/// A part of a ROS 2 message, in the order of the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    /// `std_msgs/Header`.
    Header,
    /// The frame of the tip.
    Child,
    Triple(&'static str),
    /// x, y, z and w below this path.
    Quaternion(&'static str),
    /// 36 numbers.
    Covariance,
}

/// A ROS 2 message type that can be written.
#[derive(Debug)]
pub(super) struct RosType {
    pub(super) name: &'static str,
    pub(super) slots: &'static [Slot],
    pub(super) definition: &'static str,
    pub(super) parts: &'static [(&'static str, &'static str)],
}

/// The types that are written, the plainest that has a field first.
pub(super) const TYPES: &[RosType] = &[
    RosType {
        name: "geometry_msgs/msg/PointStamped",
        slots: &[Slot::Header, Slot::Triple("point")],
        definition: "std_msgs/Header header\nPoint point\n",
        parts: &[HEADER, TIME, POINT],
    },
    RosType {
        name: "geometry_msgs/msg/PoseStamped",
        slots: &[
            Slot::Header,
            Slot::Triple("pose.position"),
            Slot::Quaternion("pose.orientation"),
        ],
        definition: "std_msgs/Header header\nPose pose\n",
        parts: &[HEADER, TIME, POSE, POINT, QUATERNION],
    },
    RosType {
        name: "geometry_msgs/msg/TwistStamped",
        slots: &[
            Slot::Header,
            Slot::Triple("twist.linear"),
            Slot::Triple("twist.angular"),
        ],
        definition: "std_msgs/Header header\nTwist twist\n",
        parts: &[HEADER, TIME, TWIST, VECTOR3],
    },
    RosType {
        name: "geometry_msgs/msg/Vector3Stamped",
        slots: &[Slot::Header, Slot::Triple("vector")],
        definition: "std_msgs/Header header\nVector3 vector\n",
        parts: &[HEADER, TIME, VECTOR3],
    },
    RosType {
        name: "nav_msgs/msg/Odometry",
        slots: &[
            Slot::Header,
            Slot::Child,
            Slot::Triple("pose.pose.position"),
            Slot::Quaternion("pose.pose.orientation"),
            Slot::Covariance,
            Slot::Triple("twist.twist.linear"),
            Slot::Triple("twist.twist.angular"),
            Slot::Covariance,
        ],
        definition: "std_msgs/Header header\nstring child_frame_id\n\
            geometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n",
        parts: &[
            HEADER,
            TIME,
            POSE_WITH_COVARIANCE,
            POSE,
            POINT,
            QUATERNION,
            TWIST_WITH_COVARIANCE,
            TWIST,
            VECTOR3,
        ],
    },
    // Without a header: the reader takes log times.
    RosType {
        name: "geometry_msgs/msg/Twist",
        slots: &[Slot::Triple("linear"), Slot::Triple("angular")],
        definition: "Vector3  linear\nVector3  angular\n",
        parts: &[VECTOR3],
    },
    RosType {
        name: "geometry_msgs/msg/Pose",
        slots: &[Slot::Triple("position"), Slot::Quaternion("orientation")],
        definition: "Point position\nQuaternion orientation\n",
        parts: &[POINT, QUATERNION],
    },
    RosType {
        name: "geometry_msgs/msg/Point",
        slots: &[Slot::Triple("")],
        definition: "float64 x\nfloat64 y\nfloat64 z\n",
        parts: &[],
    },
];

/// A definition and those that it needs, as rosbag2 concatenates them.
pub(super) fn joined(own: &str, parts: &[(&str, &str)]) -> String {
    let separator = "=".repeat(80);
    parts
        .iter()
        .fold(own.to_owned(), |text, (name, definition)| {
            format!("{text}\n{separator}\nMSG: {name}\n{definition}")
        })
}

#[cfg(feature = "sqlite")]
pub(crate) fn known_definition(name: &str) -> Option<String> {
    let image = image_schema();
    let known = TYPES.iter().find(|ros| ros.name == name);
    known
        .map(|ros| joined(ros.definition, ros.parts))
        .or((image.0 == name).then_some(image.1))
}

/// The type of a centroid by default, and of a pose.
pub(super) const POINT_STAMPED: &RosType = &TYPES[0];
pub(super) const POSE_STAMPED: &RosType = &TYPES[1];

/// ROS 2's name of a compressed image, and its definition.
pub(super) fn image_schema() -> (&'static str, String) {
    let own = "std_msgs/Header header\nstring format\nuint8[] data\n";
    let name = "sensor_msgs/msg/CompressedImage";
    (name, joined(own, &[HEADER, TIME]))
}

const HEADER: (&str, &str) = (
    "std_msgs/Header",
    "builtin_interfaces/Time stamp\nstring frame_id\n",
);
const TIME: (&str, &str) = ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n");
const POINT: (&str, &str) = ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n");
const VECTOR3: (&str, &str) = ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n");
const TWIST: (&str, &str) = ("geometry_msgs/Twist", "Vector3  linear\nVector3  angular\n");
const QUATERNION: (&str, &str) = (
    "geometry_msgs/Quaternion",
    "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
);
const POSE: (&str, &str) = (
    "geometry_msgs/Pose",
    "Point position\nQuaternion orientation\n",
);
const POSE_WITH_COVARIANCE: (&str, &str) = (
    "geometry_msgs/PoseWithCovariance",
    "Pose pose\nfloat64[36] covariance\n",
);
const TWIST_WITH_COVARIANCE: (&str, &str) = (
    "geometry_msgs/TwistWithCovariance",
    "Twist twist\nfloat64[36] covariance\n",
);

/// `geometry_msgs/msg/PointStamped` of a centroid.
pub(super) fn point_stamped(buffer: &mut Vec<u8>, sample: &Stamped) {
    let mut cdr = Cdr::new(buffer);
    header(&mut cdr, sample.stamp);
    vector(&mut cdr, [sample.x, sample.y, 0.0]);
}

/// `geometry_msgs/msg/PoseStamped` of an object on the table with this yaw (rad).
pub(super) fn pose_stamped(buffer: &mut Vec<u8>, sample: &Stamped, yaw: f64) {
    let mut cdr = Cdr::new(buffer);
    header(&mut cdr, sample.stamp);
    vector(&mut cdr, [sample.x, sample.y, 0.0]);
    let (sin, cos) = (0.5 * yaw).sin_cos();
    vector(&mut cdr, [0.0, 0.0, sin]);
    cdr.float64(cos);
}

/// `sensor_msgs/msg/CompressedImage` of a JPEG.
pub(super) fn jpeg_image(buffer: &mut Vec<u8>, stamp: u64, jpeg: &[u8]) {
    let mut cdr = Cdr::new(buffer);
    header(&mut cdr, stamp);
    cdr.string("jpeg");
    cdr.bytes(jpeg);
}

/// `std_msgs/Header` of a stamp in ns.
pub(super) fn header(cdr: &mut Cdr<'_>, stamp: u64) {
    cdr.int32(i32::try_from(stamp / NANOSECONDS).unwrap_or(i32::MAX));
    cdr.uint32((stamp % NANOSECONDS) as u32);
    cdr.string(FRAME);
}

fn vector(cdr: &mut Cdr<'_>, values: [f64; 3]) {
    for value in values {
        cdr.float64(value);
    }
}

/// One stamped pair of coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamped {
    /// Nanoseconds since the epoch of the log's clock.
    pub stamp: u64,
    /// Along x: metres for a position, m/s for a velocity.
    pub x: f64,
    /// Along y: metres for a position, m/s for a velocity.
    pub y: f64,
}

impl Stamped {
    /// The coordinates of a place or a velocity, at a stamp in nanoseconds.
    pub const fn at(stamp: u64, Point { x, y }: Point) -> Self {
        Self { stamp, x, y }
    }
}

/// Measured pose and velocity of the striker's tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateSample {
    /// Nanoseconds since the epoch of the log's clock.
    pub stamp: u64,
    /// Position `[x, y]` of the tip's centre, in m.
    pub position: [f64; 2],
    /// Velocity `[x, y]`, in m/s.
    pub velocity: [f64; 2],
}

/// What one strike leaves in a log, each list in order of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Object centroids, in m.
    pub centroids: Vec<Stamped>,
    /// Commanded end-effector velocity, in m/s, zero when idle.
    pub commands: Vec<Stamped>,
    /// Measured end-effector state; empty where the robot does not log it.
    pub states: Vec<StateSample>,
}

/// Marks plain little-endian CDR; alignment counts from its end.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// Appends primitive values to a buffer, each aligned to its own size.
pub(super) struct Cdr<'a> {
    buffer: &'a mut Vec<u8>,
}

impl<'a> Cdr<'a> {
    /// Starts a message in an empty buffer.
    pub(super) fn new(buffer: &'a mut Vec<u8>) -> Self {
        buffer.extend_from_slice(&ENCAPSULATION);
        Self { buffer }
    }

    fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        while !(self.buffer.len() - ENCAPSULATION.len()).is_multiple_of(N) {
            self.buffer.push(0);
        }
        self.buffer.extend_from_slice(&bytes);
    }

    pub(super) fn int32(&mut self, value: i32) {
        self.put(value.to_le_bytes());
    }

    pub(super) fn uint32(&mut self, value: u32) {
        self.put(value.to_le_bytes());
    }

    pub(super) fn float64(&mut self, value: f64) {
        self.put(value.to_le_bytes());
    }

    /// A sequence of bytes: its length, and they.
    pub(super) fn bytes(&mut self, bytes: &[u8]) {
        self.uint32(u32::try_from(bytes.len()).unwrap_or(u32::MAX));
        self.buffer.extend_from_slice(bytes);
    }

    /// A string: its length with the closing zero, its bytes, the zero.
    pub(super) fn string(&mut self, text: &str) {
        self.uint32(u32::try_from(text.len() + 1).unwrap_or(u32::MAX));
        self.buffer.extend_from_slice(text.as_bytes());
        self.buffer.push(0);
    }
}
