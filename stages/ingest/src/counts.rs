//! What is counted over a whole log, for its notes.

use values::Rig;

use crate::robust::median;

/// Frames whose rate differs from the rig file's by more than this part come from another camera, or the file is wrong.
const OTHER_RATE: f64 = 0.1;

/// Centroids that were left out, and how often they came.
#[derive(Default)]
pub(crate) struct Counts {
    /// Frames in which the tracker saw nothing.
    pub(crate) lost: u64,
    /// Centroids that repeat the stamp of the one before.
    pub(crate) repeated: u64,
    /// Centroids that are left out of their tracks.
    pub(crate) outliers: usize,
    /// Centroids that came too long before the commands of their time.
    pub(crate) unheld: usize,
    /// Episodes that were judged before the centroids of their time came.
    pub(crate) unseen: u64,
    /// Motions far from the arm that no slide is.
    pub(crate) carried: u64,
    /// Slow commands away from where the arm strikes.
    pub(crate) ways_back: u64,
    /// Commands that are no number.
    pub(crate) not_numbers: usize,
    /// Motions of an arm without commands that met nothing.
    pub(crate) idle_motions: u64,
    /// Seconds from frame to frame around each command.
    pub(crate) periods: Vec<f64>,
}

impl Counts {
    /// A sentence for each count that is not zero.
    pub(crate) fn notes(&self) -> Vec<String> {
        let counts = [
            (
                self.lost,
                "frames are lost: the tracker wrote no number, zero, a place off the table to which no object gets from one frame to the next, for a while the place of another object, or the last place again while the object moved on, and they are left out",
            ),
            (
                self.repeated,
                "centroids repeat the stamp of the one before and are left out",
            ),
            (
                self.outliers as u64,
                "centroids jump away for a single frame, and are left out of their tracks",
            ),
            (
                self.unheld as u64,
                "centroids came too long before the commands of their time and were let go",
            ),
            (
                self.ways_back,
                "commands slower than any strike lead away from where the arm strikes: they are its ways back, and no strikes",
            ),
            (
                self.not_numbers as u64,
                "commands between others are no number, and are left out: what commands the arm wrote them",
            ),
            (
                self.idle_motions,
                "motions of the arm touched no object, and are no strikes",
            ),
            (
                self.carried,
                "motions far from the arm do not brake as what slides does: they are taken for a hand's carrying, and teach nothing",
            ),
            (
                self.unseen,
                "commands came too long before the centroids of their time and were judged without them",
            ),
        ];
        let seen = counts.into_iter().filter(|(count, _)| *count > 0);
        seen.map(|(count, text)| format!("{count} {text}"))
            .collect()
    }

    /// What is to be said of frames that come at another rate than the rig file's.
    pub(crate) fn other_rate(&self, rig: &Rig) -> Option<String> {
        let rate = 1.0 / median(self.periods.iter().copied());
        let stated = rig.camera.rate;
        ((rate / stated).ln().abs() > OTHER_RATE).then(|| {
            format!("frames come at {rate:.0} Hz, and the rig file says camera.rate = {stated}: set it to what the camera does")
        })
    }
}
