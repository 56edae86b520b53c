//! Why a strike is not kept.

#![expect(missing_docs, reason = "the words beside each say what it is")]

use derive_more::Display;
use serde::{Deserialize, Serialize};
use values::RejectReason;

/// The reason, and what was seen.
#[derive(Clone, Debug)]
pub(crate) struct Rejection {
    pub(crate) reason: RejectReason,
    pub(crate) detail: Detail,
}

impl Rejection {
    pub(crate) fn new(reason: RejectReason, detail: Detail) -> Self {
        Self { reason, detail }
    }
}

/// What was seen of a strike that is not kept: lengths in m, times in s.
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
pub enum Detail {
    #[display("a command is ({x}, {y}) m/s")]
    CommandNotFinite { x: f64, y: f64 },
    #[display("all {commands} commands have the stamp {stamp} ns")]
    CommandsOfOneStamp { commands: usize, stamp: i64 },
    #[display("of {commands} commands in {seconds:.2} s up to {fastest:.3} m/s, no {alike} in a row are alike within {} %, and those at the top \
         cannot be separated from the ramps: hold the speed longer, or log the command more often", 100.0 * within)]
    NoPlateau {
        commands: usize,
        seconds: f64,
        fastest: f64,
        alike: usize,
        within: f64,
    },
    #[display(
        "the commanded speed is {speed:.3}, the robot's fastest is {fastest} m/s: are commands in mm/s?"
    )]
    CommandsInMillimetres { speed: f64, fastest: f64 },
    #[display("the command does not fall back to rest within {messages} messages")]
    CommandGoesOn { messages: usize },
    #[display("a command's stamp lies {by:.3} s before the last one's")]
    CommandSetBack { by: f64 },
    #[display("a centroid's stamp lies {by:.3} s before the last one's")]
    CentroidSetBack { by: f64 },
    #[display("the centroids' stamps stand still at zero")]
    StampsStandStill,
    #[display("the log is cut within its command: {why}")]
    CutInCommand { why: String },
    #[display("the log is cut within {after} s after its command: {why}")]
    CutAfterCommand { after: f64, why: String },
    #[display("{seen}; the log is cut here: {why}")]
    CutHere { seen: Box<Detail>, why: String },
    #[display("{seen}; {clock}")]
    ClockEndsHere {
        seen: Box<Detail>,
        clock: Box<Detail>,
    },
    #[display("no centroid is there; {clock}")]
    NoCentroid { clock: Box<Detail> },
    #[display("the log is damaged, at a place that is not known: {why}")]
    DamagedSomewhere { why: String },
    #[display(
        "{centroids} centroids come around one command, more than any camera gives: are stamps in another unit?"
    )]
    TooManyCentroids { centroids: usize },
    #[display("no centroid comes from half a second before the command to a second after")]
    NoCentroidNear,
    #[display("frames come every {:.1} ms, too seldom for a slide; the rig file says camera.rate = {rate}", 1e3 * period)]
    FramesTooSeldom { period: f64, rate: f64 },
    #[display("centroids lie around ({x:.1}, {y:.1}): are they in {}, not in m?", if *are_centimetres { "cm" } else { "mm, or in pixels" })]
    OtherUnit {
        x: f64,
        y: f64,
        are_centimetres: bool,
    },
    /// `table`: from where to where along x, then along y.
    #[display("a centroid is at ({x:.4}, {y:.4}) m, {after:.3} s after the command rises; the table is [{}, {}] × [{}, {}] m",
        table[0], table[1], table[2], table[3])]
    OffTable {
        x: f64,
        y: f64,
        after: f64,
        table: [f64; 4],
    },
    #[display("{centroids} centroids come in the {seconds} s before the command")]
    FewCentroidsBefore { centroids: usize, seconds: f64 },
    #[display("the object moves {:.1} mm in the {seconds} s before the command", 1e3 * by)]
    MovesBefore { by: f64, seconds: f64 },
    #[display("the object is struck {by:.3} s before the command rises")]
    StruckEarly { by: f64 },
    #[display("the object moves {by:.3} s before the command rises")]
    MovesEarly { by: f64 },
    #[display("the object moves before the arm does")]
    MovesBeforeArm,
    #[display("the object first moves {by:.3} s after the command fell back: {}",
        if *is_related { "clocks disagree, or something else moved it" } else { "something else moved it" })]
    MovesLate { by: f64, is_related: bool },
    #[display("in {seconds:.2} s after the command rises the object is never farther than {:.1} mm from its rest for {frames} frames", 1e3 * farthest)]
    NeverMoves {
        seconds: f64,
        farthest: f64,
        frames: usize,
    },
    #[display("{:.1} ms without a frame before first motion, and {frames} frames in the {seconds} s before; frames come every {:.1} ms",
        1e3 * gap, 1e3 * period)]
    GapBeforeMotion {
        gap: f64,
        frames: usize,
        seconds: f64,
        period: f64,
    },
    #[display("{:.1} ms without a frame after first motion; frames come every {:.1} ms", 1e3 * gap, 1e3 * period)]
    GapAfterMotion { gap: f64, period: f64 },
    #[display("{there} of {due:.0} frames of the slide are there")]
    FramesMissing { there: usize, due: f64 },
    #[display(
        "{frames} frames after first motion the object meets something, or leaves the table: too few to tell anything"
    )]
    EndsTooSoon { frames: usize },
    #[display(
        "{frames} frames after the impact the object meets something, or is seen no more: too few to tell anything"
    )]
    EndsAfterImpact { frames: usize },
    #[display("{after:.3} s after first motion, not yet at rest, the object jumps {:.1} mm from one frame to the next", 1e3 * by)]
    Jumps { after: f64, by: f64 },
    #[display("after the impact the object goes {:.0} mm where it would slide {:.0} mm unbraked, and does not rest: something holds it, or pushes it on",
        1e3 * gone, 1e3 * unbraked)]
    HeldOrPushed { gone: f64, unbraked: f64 },
    #[display("{seconds:.2} s of frames after first motion, up to {:.1} mm away, and nowhere {rest} s of rest", 1e3 * away)]
    NeverRests { seconds: f64, away: f64, rest: f64 },
    #[display("the tip meets the object {:.0} mm beside its centre, at {speed:.2} m/s: it only grazes it", 1e3 * aside)]
    Grazed { aside: f64, speed: f64 },
}
