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
    /// Times in s of slides of which no state tells where the arm was, and the number of those that no command began.
    pub(crate) untold: Vec<f64>,
    pub(crate) uncommanded: u64,
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
        let counts: [Told; 10] = [
            (self.lost, Note::FramesLost),
            (self.repeated, Note::StampsRepeated),
            (self.outliers as u64, Note::Outliers),
            (self.unheld as u64, Note::CentroidsUnheld),
            (self.ways_back, Note::WaysBack),
            (self.not_numbers as u64, Note::CommandsNotNumbers),
            (self.idle_motions, Note::IdleMotions),
            (self.carried, Note::Carried),
            (self.uncommanded, Note::Uncommanded),
            (self.unseen, Note::CommandsUnseen),
        ];
        let seen = counts.into_iter().filter(|(count, _)| *count > 0);
        seen.map(|(count, note)| note(count))
    }

    /// Counts the slides that began so long before or after any of these rises of commands, in order, that none of them began them; where all did, or
    /// none, the clocks tell.
    pub(crate) fn count_uncommanded(&mut self, rises: &[f64]) {
        /// Time in s by which a slide may come before its command, and after.
        const EARLY: f64 = 0.5;
        const LATE: f64 = 3.0;
        let is_commanded = |slide: &f64| {
            let next = rises.partition_point(|rise| *rise <= slide + EARLY);
            next > 0 && slide - rises[next - 1] < LATE
        };
        let commanded = self
            .untold
            .iter()
            .filter(|slide| is_commanded(slide))
            .count();
        if 2 * commanded > self.untold.len() {
            self.uncommanded = (self.untold.len() - commanded) as u64;
        }
    }

    /// That frames come at another rate than the rig file's.
    pub(crate) fn other_rate(&self, rig: &Rig) -> Option<Note> {
        let rate = 1.0 / median(self.periods.iter().copied());
        let stated = rig.camera.rate;
        let is_other = (rate / stated).ln().abs() > OTHER_RATE;
        is_other.then_some(Note::OtherRate { rate, stated })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slides_without_a_command_are_counted_where_most_have_one() {
        let count = |slides: &[f64], rises: &[f64]| {
            let mut counts = Counts {
                untold: slides.to_vec(),
                ..Counts::default()
            };
            counts.count_uncommanded(rises);
            counts.uncommanded
        };
        assert_eq!(count(&[10.3, 20.4, 30.2], &[10.0, 20.0, 30.0]), 0);
        assert_eq!(count(&[10.3, 20.4, 30.2, 35.0], &[10.0, 20.0, 30.0]), 1);
        // A clock that is late by as much as strikes lie apart is told otherwise.
        assert_eq!(count(&[15.3, 25.4, 35.2], &[10.0, 20.0, 30.0]), 0);
        assert_eq!(count(&[15.3], &[]), 0);
    }
}
