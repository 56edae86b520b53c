//! What a strike leaves in a log.

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
