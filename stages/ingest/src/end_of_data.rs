//! Where a log ends, or is cut: what that says of the episodes that have begun.

use values::RejectReason;

use crate::episode::Episode;
use crate::identity::AFTER;
use crate::rejection::Rejection;
use crate::time::seconds;

/// Why no more samples that belong to the present ones will come.
pub(crate) enum EndOfData {
    /// The log ends.
    End,
    /// Messages are missing from here on.
    Lost(String),
    /// A clock was set back.
    Clock(String),
}

impl EndOfData {
    /// Whether all that a strike's id is made of is there: one that is cut off before would be another strike than the whole one.
    pub(crate) fn leaves_whole(
        ending: Option<&Self>,
        episode: &Episode,
        last_centroid: Option<i64>,
    ) -> Result<(), Rejection> {
        let needed = episode.end().saturating_add(AFTER);
        match ending {
            Some(Self::Lost(why)) if last_centroid.is_none_or(|last| last <= needed) => {
                let after = seconds(AFTER);
                let detail = format!("the log is cut within {after} s after its command: {why}");
                Err(Rejection::new(RejectReason::Truncated, detail))
            }
            _ => Ok(()),
        }
    }

    /// What has not been seen to its end is the fault of what ended it.
    pub(crate) fn blame(ending: Option<&Self>, rejection: Rejection) -> Rejection {
        let unseen = matches!(
            rejection.reason,
            RejectReason::NoRestAfter | RejectReason::NoMotion | RejectReason::FramesMissing
        );
        match ending {
            Some(Self::Lost(why)) if unseen => Rejection::new(
                RejectReason::Truncated,
                format!("{}; the log is cut here: {why}", rejection.detail),
            ),
            Some(Self::Clock(why)) if unseen => Rejection::new(
                RejectReason::ClockBackwards,
                format!("{}; {why}", rejection.detail),
            ),
            _ => rejection,
        }
    }
}
