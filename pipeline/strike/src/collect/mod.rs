//! Gathering data: strikes that fill speed, angle and table evenly and stay on it, each in a log of its own before the next is made.
//!
//! The folder's logs are the state of a collection: whatever ended it, the next call continues from them.

mod collection;
mod error;
mod filling;
mod request;
mod station;

use std::path::Path;

use collection::Collection;
pub use collection::SESSION;
pub use error::CollectError;
use filling::{choose, request};
pub use request::{CollectEvent, StrikeRequest};
#[cfg(feature = "sim")]
pub use station::SimStation;
pub use station::{ArmStation, Recorded, Station, Unfinished};

use crate::{CommandPlanner, Destination, OpenLog};

/// Greatest size in bytes of a strike's log without live topics.
const ROOM: u64 = 8 << 20;
/// Number of strikes in a row that cannot be used that end the collection: something is wrong with the camera or the table.
const MOST_USELESS: usize = 5;

/// The outcome of a collection.
#[derive(Clone, Debug, PartialEq)]
pub struct Collected {
    /// Usable strikes in the folder.
    pub strikes: usize,
    /// Usable strikes made in this call.
    pub made: usize,
    /// Strikes made now whose logs cannot be used.
    pub useless: usize,
    /// The log that all strikes since the last one were joined in; none where there were none.
    pub session: Option<std::path::PathBuf>,
}

/// Makes strikes until the folder holds `strikes` usable ones, the requested ones first. `is_over` ends it before the next strike.
pub fn collect(
    station: &mut dyn Station,
    planner: &CommandPlanner,
    folder: &Path,
    strikes: usize,
    requested: &[StrikeRequest],
    is_over: &dyn Fn() -> bool,
    report: &mut dyn FnMut(CollectEvent),
) -> Result<Collected, CollectError> {
    let rig = planner.rig();
    let mut collection = Collection::open(folder, rig)?;
    let mut requested = collection.left_of(requested);
    let (mut made, mut useless, mut in_a_row) = (0, 0, 0);
    while collection.len() < strikes && !is_over() {
        station.goes_on(collection.strikes_made());
        let next = requested.first().copied();
        let put = match next {
            Some(request) => request,
            None => request(planner, &collection, is_over)?,
        };
        report(CollectEvent::Put(put));
        let log = OpenLog::open(Destination::Next(folder.into()))?;
        let log = log.reserve(ROOM + station.room())?;
        let rest = station.object(put.from, report)?;
        let farther = collection.farther(planner);
        let plan = match next {
            Some(request) => {
                requested.remove(0);
                let yaw = rest.yaw.unwrap_or(0.0);
                match planner.plan_turned(rest.point, request.command, farther, yaw) {
                    Ok(plan) => plan,
                    Err(refusal) => {
                        report(CollectEvent::LeftOut(refusal));
                        continue;
                    }
                }
            }
            None => match choose(planner, &rest, &collection.made(), farther) {
                Err(CollectError::NoStrike(why)) if station.is_by_hand() => {
                    report(CollectEvent::Waiting(why));
                    continue;
                }
                chosen => chosen?,
            },
        };
        let outcome = station.strike(&plan);
        let (recorded, failed) = match outcome {
            Ok(recorded) => (Some(recorded), None),
            Err(unfinished) => (unfinished.recorded, Some(unfinished.error)),
        };
        if let Some(Recorded {
            samples,
            received,
            warning,
            unmoved,
        }) = recorded
        {
            let answered = match (&failed, &warning) {
                (Some(failed), _) => failed.to_string(),
                (None, Some(warning)) => format!("struck, with a warning: {warning}"),
                (None, None) => "struck".into(),
            };
            let mut lineage = plan.lineage(match station.is_by_hand() {
                true => "arm",
                false => "sim",
            });
            lineage.insert("robot_answered".into(), answered);
            let log = log.about(lineage);
            let kept = log.write_with(&samples, &received, &rig.topics);
            station.recorded();
            let kept = kept?;
            if let Some(why) = kept.moved {
                return Err(CollectError::Moved {
                    path: kept.path,
                    why,
                });
            }
            made += 1;
            match collection.take(&kept.path, rig)? {
                Ok(()) => {
                    in_a_row = 0;
                    report(CollectEvent::Kept {
                        strikes: collection.len(),
                        warning,
                    });
                }
                Err(why) => {
                    let why = warning.map_or(why.clone(), |warning| format!("{why}; {warning}"));
                    (useless, in_a_row) = (useless + 1, in_a_row + 1);
                    report(CollectEvent::Useless(why.clone()));
                    if in_a_row == MOST_USELESS && failed.is_none() {
                        return Err(CollectError::Useless {
                            strikes: in_a_row,
                            why,
                        });
                    }
                }
            }
            // The next one would pass beside the object, too, and might meet something else.
            if let Some(why) = unmoved {
                return Err(CollectError::Unmoved(why));
            }
        }
        if let Some(error) = failed {
            return Err(error.into());
        }
    }
    Ok(Collected {
        strikes: collection.len(),
        made: made - useless,
        useless,
        session: if collection.len() >= strikes {
            collection.join()?
        } else {
            None
        },
    })
}
