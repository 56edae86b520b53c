//! Every arm: one guard, one watch, one order of motions. A maker's driver is an [`Arm`]; [`Guarded`] makes a [`crate::Robot`] of it.
//!
//! The arm is checked, made ready, moved at travel height and at most 100 mm/s to the start, down, along one straight line through the
//! strike point, and up. No error is cleared, no value clamped. While anything moves, every report is compared with the line that was
//! commanded ([`guard`]); what does not keep to it is stopped from the thread that reads the reports. None of this is safety-rated.

mod claim;
mod connection;
mod driver;
mod guard;
mod guarded;
mod line;
mod outlet;
mod setup;
mod signals;
mod turn;
mod watch;

pub(crate) use connection::{
    CONNECT, connect, connect_unread, garbage, is_nothing_yet, listen, read_frame, start,
    version_in, why_none,
};
pub use driver::{
    Arm, ArmLimits, Condition, Identity, LineRequest, Ports, Pose, Report, Reports, Said, Status,
    ports_of,
};
pub(crate) use driver::{distance, shown};
pub(crate) use guard::MARGIN;
pub use guarded::{Guarded, Look};
pub use outlet::Outlet;
pub(crate) use setup::Height;
pub use signals::{catch_signals, tell, told, unblock_signals};
pub use turn::Turn;
pub(crate) use watch::RunUp;
