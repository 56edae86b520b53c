//! Where an object is at one time.

/// Where an object is: its centre on the table (m) and its yaw (rad).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Along x, in m.
    pub x: f64,
    /// Along y, in m.
    pub y: f64,
    /// Yaw in rad.
    pub yaw: f64,
}
