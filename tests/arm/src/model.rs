//! What an arm is, and what it is set to.

use std::sync::atomic::{AtomicU32, Ordering};

#[derive(Clone, Debug)]
pub struct Model {
    pub version: String,
    /// Where the tip is at first: mm and rad.
    pub pose: [f64; 6],
    /// mm and rad.
    pub tool_offset: [f64; 6],
    /// kg.
    pub payload: f64,
    /// Error and warning code at first.
    pub codes: [u8; 2],
    pub sensitivity: u8,
    /// Gravity in the base's frame.
    pub gravity: [f64; 3],
    /// mm and rad.
    pub world_offset: [f64; 6],
    /// Whether reduced mode, the fence and simulation are on.
    pub modes: [bool; 3],
    /// x high and low, y high and low, z high and low, in mm.
    pub fence: [i16; 6],
    pub is_stopped: bool,
    pub is_enabled: bool,
    /// Whether switching its motors on or off leaves its state: by the maker's protocol that is the same as a stop.
    pub keeps_state: bool,
    /// By how much, in mm, the arm sags when its motors are enabled and its brakes open.
    pub sag: f64,
    /// Motors that stay off, a bit each.
    pub off: u8,
    /// Whether its pendant has it: scripts are not taken.
    pub is_local: bool,
    /// Beyond this x, in mm, the controller says that it cannot move.
    pub wall: f64,
}

/// Arms made so far: each has a serial number of its own.
static ARMS: AtomicU32 = AtomicU32::new(0);

impl Default for Model {
    fn default() -> Self {
        Self {
            version: format!(
                "7,7,XI{:06}{:04},AC1305,v2.4.0",
                std::process::id(),
                ARMS.fetch_add(1, Ordering::Relaxed)
            ),
            pose: [200.0, 0.0, 100.0, std::f64::consts::PI, 0.0, 0.0],
            tool_offset: [0.0, 0.0, 100.0, 0.0, 0.0, 0.0],
            payload: 0.3,
            codes: [0, 0],
            sensitivity: 3,
            gravity: [0.0, 0.0, -1.0],
            world_offset: [0.0; 6],
            modes: [false; 3],
            fence: [0; 6],
            is_stopped: false,
            is_enabled: false,
            keeps_state: false,
            sag: 0.0,
            off: 0,
            is_local: false,
            wall: f64::INFINITY,
        }
    }
}
