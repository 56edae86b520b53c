//! The ROS 2 messages that a strike and its pictures leave, with the schema text that rosbag2 would embed.

use super::cdr::Cdr;
use super::samples::{Stamped, StateSample};

/// The frame that every stamp's header names.
const FRAME: &str = "table";
/// The frame of the tip in `nav_msgs/msg/Odometry`.
const TIP_FRAME: &str = "tip";
const NANOSECONDS: u64 = 1_000_000_000;

/// The messages, in the order in which equal stamps are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Centroid = 0,
    Command = 1,
    State = 2,
    Pose = 3,
}

impl Kind {
    /// ROS 2's name of the type.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Centroid => "geometry_msgs/msg/PointStamped",
            Self::Command => "geometry_msgs/msg/TwistStamped",
            Self::State => "nav_msgs/msg/Odometry",
            Self::Pose => "geometry_msgs/msg/PoseStamped",
        }
    }

    /// The type's definition followed by those it needs, as rosbag2 concatenates them.
    pub(super) fn schema(self) -> String {
        let (own, parts): (&str, &[(&str, &str)]) = match self {
            Self::Centroid => (POINT_STAMPED, &[HEADER, TIME, POINT]),
            Self::Pose => (POSE_STAMPED, &[HEADER, TIME, POSE, POINT, QUATERNION]),
            Self::Command => (TWIST_STAMPED, &[HEADER, TIME, TWIST, VECTOR3]),
            Self::State => (
                ODOMETRY,
                &[
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
            ),
        };
        joined(own, parts)
    }
}

/// A definition and those that it needs, as rosbag2 concatenates them.
fn joined(own: &str, parts: &[(&str, &str)]) -> String {
    let separator = "=".repeat(80);
    parts
        .iter()
        .fold(own.to_owned(), |text, (name, definition)| {
            format!("{text}\n{separator}\nMSG: {name}\n{definition}")
        })
}

/// ROS 2's name of a compressed image, and its definition.
pub(super) fn image_schema() -> (&'static str, String) {
    let own = "std_msgs/Header header\nstring format\nuint8[] data\n";
    let name = "sensor_msgs/msg/CompressedImage";
    (name, joined(own, &[HEADER, TIME]))
}

const POSE_STAMPED: &str = "std_msgs/Header header\nPose pose\n";
const POINT_STAMPED: &str = "std_msgs/Header header\nPoint point\n";
const TWIST_STAMPED: &str = "std_msgs/Header header\nTwist twist\n";
const ODOMETRY: &str = "std_msgs/Header header\nstring child_frame_id\n\
    geometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n";
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

/// `geometry_msgs/msg/TwistStamped` of a commanded velocity.
pub(super) fn twist_stamped(buffer: &mut Vec<u8>, sample: &Stamped) {
    let mut cdr = Cdr::new(buffer);
    header(&mut cdr, sample.stamp);
    vector(&mut cdr, [sample.x, sample.y, 0.0]);
    vector(&mut cdr, [0.0; 3]);
}

/// `nav_msgs/msg/Odometry` of the tip: upright, velocity in frame `table`, covariances unknown (zero).
pub(super) fn odometry(buffer: &mut Vec<u8>, sample: &StateSample) {
    let mut cdr = Cdr::new(buffer);
    header(&mut cdr, sample.stamp);
    cdr.string(TIP_FRAME);
    vector(&mut cdr, [sample.position[0], sample.position[1], 0.0]);
    vector(&mut cdr, [0.0; 3]);
    cdr.float64(1.0);
    covariance(&mut cdr);
    vector(&mut cdr, [sample.velocity[0], sample.velocity[1], 0.0]);
    vector(&mut cdr, [0.0; 3]);
    covariance(&mut cdr);
}

fn header(cdr: &mut Cdr<'_>, stamp: u64) {
    cdr.int32(i32::try_from(stamp / NANOSECONDS).unwrap_or(i32::MAX));
    cdr.uint32((stamp % NANOSECONDS) as u32);
    cdr.string(FRAME);
}

fn vector(cdr: &mut Cdr<'_>, values: [f64; 3]) {
    for value in values {
        cdr.float64(value);
    }
}

fn covariance(cdr: &mut Cdr<'_>) {
    for _ in 0..36 {
        cdr.float64(0.0);
    }
}
