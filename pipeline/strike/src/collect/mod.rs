//! Gathering data: strikes that fill speed, angle and table evenly and stay on it, each in a log of its own before the next is made.
//!
//! What was gathered is what lies in the folder: a collection that was ended by anything goes on where it was.

mod error;
mod filling;
mod gathered;
mod station;
mod wish;

use std::path::Path;

pub use error::CollectError;
use filling::{choose, wish};
use gathered::Gathered;
pub use gathered::SESSION;
pub use station::{ArmStation, Recorded, SimStation, Station, Unfinished};
pub use wish::Wish;

use crate::{CommandPlanner, Destination, OpenLog, Refusal};

/// So many strikes in a row that are made and cannot be used end the collection: something is wrong with the camera or the table.
const MOST_USELESS: usize = 5;

/// What came of one strike of a collection, for a person.
#[derive(Clone, Debug)]
pub enum News {
    /// Where the object is to be put, in m.
    Put(Wish),
    /// What is waited for until it lies ready.
    Waiting(String),
    /// A wished command that cannot be struck from where the object lies: it is left out.
    LeftOut(Refusal),
    /// A strike that can be used.
    Kept {
        /// Usable strikes so far.
        strikes: usize,
        /// What a person should look at.
        warning: Option<String>,
    },
    /// A strike whose log cannot be used, and why.
    Useless(String),
}

/// What came of a collection.
#[derive(Clone, Debug, PartialEq)]
pub struct Collected {
    /// Usable strikes in the folder.
    pub strikes: usize,
    /// Of these, made now.
    pub made: usize,
    /// Strikes made now whose logs cannot be used.
    pub useless: usize,
    /// The log that all strikes since the last one were joined in; none where there were none.
    pub session: Option<std::path::PathBuf>,
}

/// Strikes until the folder holds so many usable strikes; those wished for first. `is_over` ends it before the next strike.
pub fn collect(
    station: &mut dyn Station,
    planner: &CommandPlanner,
    folder: &Path,
    strikes: usize,
    wished: &[Wish],
    is_over: &dyn Fn() -> bool,
    tell: &mut dyn FnMut(News),
) -> Result<Collected, CollectError> {
    let rig = planner.rig();
    let mut gathered = Gathered::open(folder, rig)?;
    let mut wished = gathered.left_of(wished);
    let (mut made, mut useless, mut in_a_row) = (0, 0, 0);
    while gathered.len() < strikes && !is_over() {
        station.goes_on(gathered.strikes_made(), gathered.last_stop());
        let next = wished.first().copied();
        let put = match next {
            Some(wish) => wish,
            None => wish(planner, &gathered)?,
        };
        tell(News::Put(put));
        let log = OpenLog::open(Destination::Next(folder.into()))?;
        let from = station.object(put.from, &mut |what| tell(News::Waiting(what)))?;
        let farther = gathered.farther(planner);
        let plan = match next {
            Some(wish) => {
                wished.remove(0);
                match planner.plan(from, wish.command, farther) {
                    Ok(plan) => plan,
                    Err(refusal) => {
                        tell(News::LeftOut(refusal));
                        continue;
                    }
                }
            }
            None => match choose(planner, from, &gathered.made(), farther) {
                Err(CollectError::NoStrike(why)) if station.is_by_hand() => {
                    tell(News::Waiting(why));
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
        }) = recorded
        {
            let kept = log.write_with(&samples, &received, &rig.topics)?;
            if let Some(error) = kept.moved {
                return Err(error.into());
            }
            made += 1;
            match gathered.take(&kept.path, rig)? {
                Ok(()) => {
                    in_a_row = 0;
                    tell(News::Kept {
                        strikes: gathered.len(),
                        warning,
                    });
                }
                Err(why) => {
                    (useless, in_a_row) = (useless + 1, in_a_row + 1);
                    tell(News::Useless(why.clone()));
                    if in_a_row == MOST_USELESS && failed.is_none() {
                        return Err(CollectError::Useless {
                            strikes: in_a_row,
                            why,
                        });
                    }
                }
            }
        }
        if let Some(error) = failed {
            return Err(error.into());
        }
    }
    Ok(Collected {
        strikes: gathered.len(),
        made: made - useless,
        useless,
        session: if gathered.len() >= strikes {
            gathered.join()?
        } else {
            None
        },
    })
}
