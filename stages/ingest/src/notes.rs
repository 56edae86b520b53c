//! What a person should know of a log, each with the words that say it.

#![expect(missing_docs, reason = "the words beside each say what it is")]

use derive_more::Display;
use serde::{Deserialize, Serialize};

/// Damage, messages that could not be decoded, frames that were left out, and how strikes were found.
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
pub enum Note {
    #[display("truncated at byte {offset}: {why}")]
    Truncated { offset: u64, why: String },
    #[display("damaged at byte {offset}: {why}")]
    Damaged { offset: u64, why: String },
    #[display("damaged before byte {offset}: {why}")]
    DamagedBefore { offset: u64, why: String },
    #[display("all messages were read, but the index is not whole: {why}")]
    IndexDamaged { why: String },
    #[display("damaged in {_0} more places")]
    DamagedInMore(usize),
    #[display("topic {topic} was not found: it may be in what is damaged")]
    NoTopic { topic: String },
    #[display("{count} messages of {topic} could not be decoded, the first because {why}")]
    Undecodable {
        count: u64,
        topic: String,
        why: String,
    },
    #[display("{topic} has no `{stamp}`: log times were taken")]
    Unstamped { topic: String, stamp: String },
    #[display(
        "{topic} moves its place and tells no velocity: velocities are taken from the places"
    )]
    NoVelocity { topic: String },
    #[display(
        "{_0} slides that no strike began, as after a hand's push, are kept: they teach how the table brakes, and nothing of the arm"
    )]
    Slides(usize),
    /// In s.
    #[display("the camera's stamps lie {:.1} ms behind the arm's, by {touches} touches: the tip is looked up so much earlier", 1e3 * delay)]
    CameraDelay { delay: f64, touches: usize },
    #[display("{}: strikes are found by the arm's measured state, and what it delivered stands for the command; no error of the arm can be named",
        if *are_in_tool_frame { "commands in the tool's frame tell no direction" } else { "no command is logged" })]
    ByState { are_in_tool_frame: bool },
    #[display(
        "{_0} frames are lost: the tracker wrote no number, zero, a place off the table to which no object gets from one frame to the next, for \
         a while the place of another object, or the last place again while the object moved on, and they are left out"
    )]
    FramesLost(u64),
    #[display("{_0} centroids repeat the stamp of the one before and are left out")]
    StampsRepeated(u64),
    #[display("{_0} centroids jump away for a single frame, and are left out of their tracks")]
    Outliers(u64),
    #[display("{_0} centroids came too long before the commands of their time and were let go")]
    CentroidsUnheld(u64),
    #[display(
        "{_0} commands slower than any strike lead away from where the arm strikes: they are its ways back, and no strikes"
    )]
    WaysBack(u64),
    #[display(
        "{_0} commands between others are no number, and are left out: what commands the arm wrote them"
    )]
    CommandsNotNumbers(u64),
    #[display("{_0} motions of the arm touched no object, and are no strikes")]
    IdleMotions(u64),
    #[display(
        "{_0} motions far from the arm do not brake as what slides does: they are taken for a hand's carrying, and teach nothing"
    )]
    Carried(u64),
    #[display(
        "{_0} objects slid though no command was logged near: hands pushed them, or their commands are missing; they teach nothing, for without the \
         arm's measured place it is not known where the arm was"
    )]
    Uncommanded(u64),
    #[display(
        "{_0} commands came too long before the centroids of their time and were judged without them"
    )]
    CommandsUnseen(u64),
    #[display(
        "{_0} strikes went on before the arm's states or the object's poses of their time came: in this log one topic lies far behind another"
    )]
    StatesLate(u64),
    /// By a median in s.
    #[display("in {count} of {of} strikes the object was seen to move {:.0} ms (median) after the arm began to brake: the camera is late, or the tip \
         meets objects as it brakes. What the arm delivered is read before it brakes; `frames.camera_delay` in the rig file says how late the camera \
         is", 1e3 * by)]
    MotionsLate { count: usize, of: usize, by: f64 },
    /// In Hz: of the log, and of the rig file.
    #[display(
        "frames come at {rate:.1} Hz, and the rig file says camera.rate = {stated}: set it to what the camera does; where that is right, the clock of the \
         stamps is not, and friction comes out wrong by twice as much"
    )]
    OtherRate { rate: f64, stated: f64 },
}
