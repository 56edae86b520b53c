//! What is counted over a whole log, for its notes.

use values::Rig;

use crate::notes::Note;
use crate::robust::median;

/// Frames whose rate differs from the rig file's by more than this part come from another camera, or their clock or the file is wrong.
const OTHER_RATE: f64 = 0.03;

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
    /// A note for each count that is not zero.
    pub(crate) fn notes(&self) -> impl Iterator<Item = Note> + use<> {
        type Told = (u64, fn(u64) -> Note);
        let counts: [Told; 9] = [
            (self.lost, Note::FramesLost),
            (self.repeated, Note::StampsRepeated),
            (self.outliers as u64, Note::Outliers),
            (self.unheld as u64, Note::CentroidsUnheld),
            (self.ways_back, Note::WaysBack),
            (self.not_numbers as u64, Note::CommandsNotNumbers),
            (self.idle_motions, Note::IdleMotions),
            (self.carried, Note::Carried),
            (self.unseen, Note::CommandsUnseen),
        ];
        let seen = counts.into_iter().filter(|(count, _)| *count > 0);
        seen.map(|(count, note)| note(count))
    }

    /// That frames come at another rate than the rig file's.
    pub(crate) fn other_rate(&self, rig: &Rig) -> Option<Note> {
        let rate = 1.0 / median(self.periods.iter().copied());
        let stated = rig.camera.rate;
        let is_other = (rate / stated).ln().abs() > OTHER_RATE;
        is_other.then_some(Note::OtherRate { rate, stated })
    }
}
