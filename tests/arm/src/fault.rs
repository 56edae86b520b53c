//! What can go wrong, and when.

/// When in a strike a fault is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    Connect,
    /// When the error code is requested.
    Check,
    /// When the motors are enabled.
    Enable,
    /// In the middle of the n-th line since then, from 1.
    Line(u32),
}

/// The faults, and all of them; of one with a code, with this one.
macro_rules! faults {
    ($($(#[$about:meta])* $fault:ident $(($code:ty = $one:literal))?,)*) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Fault {
            $($(#[$about])* $fault $(($code))?,)*
        }

        impl Fault {
            pub const ALL: &[Self] = &[$(Self::$fault $(($one))?,)*];
        }
    };
}

faults! {
    /// All connections are reset; new ones are taken.
    Reset,
    /// All connections are reset, and none is taken any more.
    Gone,
    /// What is connected stays open, and nothing is read or answered on it; new connections are taken.
    HalfOpen,
    Silent,
    Garbage,
    /// A report ends in its middle, and its connection with it.
    ShortFrame,
    /// Replies to requests come after three seconds.
    SlowReplies,
    GarbageReply,
    Error(u8 = 31),
    EmergencyStop,
    /// Another program sets the mode to manual.
    OtherController,
    /// Another program pauses the motion.
    Paused,
    OffLine,
    /// A report says that the arm is elsewhere.
    Jump,
    /// Reports come later and later.
    Lag,
    /// Reports hold no numbers.
    NotANumber,
    /// The arm moves at 80 % of the speed that it was commanded.
    TooSlow,
    /// The arm comes to rest on its line, and nothing shows why.
    Stuck,
    NeverReady,
    /// Reports are 300 ms old, all along.
    Late,
    /// Pose and speed of the reports stay as they were; their clock runs.
    Frozen,
    /// Reports stay as they were in all but their clock.
    Stale,
    /// One report comes again and again, unchanged.
    Repeated,
    /// The clock of the reports goes back by a second.
    ClockBack,
    /// The line begins 1.5 s after it is accepted.
    Delayed,
    /// The maker's own Stop is pressed: another client sets state 4.
    OperatorStop,
    /// Another client switches the motors off.
    MotorsOff,
    /// The arm leaves its line, and the first two stops are lost.
    LostStop,
    /// The arm was jogged up to its base.
    Jogged,
    /// Asked for its pose, the controller answers another one.
    WrongPose,
    Turned,
    /// The controller finds that a line cannot be moved.
    CannotMove,
    /// Another client sends a line.
    OtherLine,
    /// Another program that only waits takes the place of the one that waits for lines.
    OtherProgram,
    /// Somebody turns the speed down to a half: the slider of a pendant, or reduced mode.
    SlowedDown,
    /// Another tool is set, 50 mm longer.
    ToolChanged,
    /// The arm is led by hand.
    FreeDrive,
    /// No sign of life of the computer comes to the controller any more.
    Deaf,
    /// The controller starts anew: connections are reset, the motors are off, and its clock begins at zero.
    Rebooted,
    /// Reports are held for 300 ms, and then come all at once.
    Burst,
    /// Connections stay open and new ones are taken; nothing is read or answered on any, and no report comes.
    Dead,
    /// The arm leaves its line, and no stop arrives any more.
    NoStop,
    /// Connections that requests and stops go over are closed; reports go on.
    ControlClosed,
}
