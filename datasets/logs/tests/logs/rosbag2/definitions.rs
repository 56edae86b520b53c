//! Message definitions as the installed packages have them, comments and all.

pub const POINT_STAMPED: &str = "\
# This represents a Point with reference coordinate frame and timestamp

std_msgs/Header header
Point point
";
pub const TWIST_STAMPED: &str = "\
# A twist with reference coordinate frame and timestamp

std_msgs/Header header
Twist twist
";
pub const ODOMETRY: &str = "\
# This represents an estimate of a position and velocity in free space.

# Includes the frame id of the pose parent.
std_msgs/Header header

# Frame id the pose points to. The twist is in this coordinate frame.
string child_frame_id

# Estimated pose that is typically relative to a fixed world frame.
geometry_msgs/PoseWithCovariance pose

# Estimated linear and angular velocity relative to child_frame_id.
geometry_msgs/TwistWithCovariance twist
";
/// A message of one's own, of all that the interface language has; what is wanted stands in the middle.
pub const TRACKED: &str = "\
# constants
byte    UNKNOWN=0
int32 LIMIT = -5  # a comment behind
string NAME=\"a = # b\"
string OTHER='it''s'
float32 HALF= 0.5

uint8[<=4] mask [1, 2]
string<=8 label \"none # of it\"
string<=16[<=3] aliases
string[2] pair
bool\tvalid true
Pixel[] corners
Pixel[2] ends
std_msgs/Header header
float32 u 1.5 # with default
float64 v
wstring<=4 remark \"wide\"
wstring[] remarks
";

/// Definitions that others use, in the order of their names, as the recorder sets them.
const PARTS: [(&str, &str); 12] = [
    (
        "builtin_interfaces/Time",
        "# This message communicates ROS Time defined here:\n# https://design.ros2.org/articles/clock_and_time.html\n\n# The seconds component, valid over all int32 values.\nint32 sec\n\n# The nanoseconds component, valid in the range [0, 1e9), to be added to the seconds component. \n# e.g.\n# The time -1.7 seconds is represented as {sec: -2, nanosec: 3e8}\nuint32 nanosec\n",
    ),
    ("demo_msgs/Pixel", "uint16 row 0\nuint8 column\n"),
    (
        "geometry_msgs/Point",
        "# This contains the position of a point in free space\nfloat64 x\nfloat64 y\nfloat64 z\n",
    ),
    (
        "geometry_msgs/Pose",
        "# A representation of pose in free space, composed of position and orientation.\n\nPoint position\nQuaternion orientation\n",
    ),
    (
        "geometry_msgs/PoseWithCovariance",
        "Pose pose\n\n# (x, y, z, rotation about X axis, rotation about Y axis, rotation about Z axis)\nfloat64[36] covariance\n",
    ),
    (
        "geometry_msgs/Quaternion",
        "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
    ),
    (
        "geometry_msgs/Twist",
        "# This expresses velocity in free space broken into its linear and angular parts.\n\nVector3  linear\nVector3  angular\n",
    ),
    (
        "geometry_msgs/TwistWithCovariance",
        "Twist twist\n\nfloat64[36] covariance\n",
    ),
    (
        "geometry_msgs/Vector3",
        "# This represents a vector in free space.\n\nfloat64 x\nfloat64 y\nfloat64 z\n",
    ),
    (
        "std_msgs/Header",
        "# Standard metadata for higher-level stamped data types.\n\n# Two-integer timestamp that is expressed as seconds and nanoseconds.\nbuiltin_interfaces/Time stamp\n\n# Transform frame with which this data is associated.\nstring frame_id\n",
    ),
    (
        "rcl_interfaces/ParameterEvent",
        "builtin_interfaces/Time stamp\nstring node\n",
    ),
    ("test_msgs/Empty", ""),
];

/// What `get_full_text` gives: the text, then that of every type below it.
pub fn full_text(own: &str) -> String {
    let separator = "=".repeat(80);
    PARTS.iter().fold(own.to_owned(), |text, (name, part)| {
        format!("{text}\n{separator}\nMSG: {name}\n{part}")
    })
}
