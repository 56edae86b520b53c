//! Strikes of all logs, read one by one from where each log's were kept.

use stage::{Entries, ListAnswer, Reader, StageError};
use values::{Reject, Strike};

use crate::assemble::{Place, join};
use crate::settings::Ingest;

/// The strikes of all logs, as [`assemble`](crate::assemble) joins them; a few bytes are held of each.
#[derive(Clone, Debug, Default)]
pub struct Strikes {
    logs: Vec<Entries<Strike>>,
    places: Vec<Place>,
}

impl Strikes {
    /// Joins logs, each with the strikes that were kept of it; also gives what was rejected.
    pub fn join(logs: Vec<ListAnswer<Ingest>>) -> (Self, Vec<Reject>) {
        let (outcomes, logs) = logs.into_iter().unzip();
        let (places, rejects) = join(outcomes);
        (Self { logs, places }, rejects)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Reads them, in order of time.
    pub fn iter(&self) -> impl Iterator<Item = Result<Strike, StageError>> {
        // Logs follow one another in time, most often.
        let mut open: Option<(usize, Reader<'_, Strike>)> = None;
        self.places.iter().zip(0_u32..).map(move |(place, order)| {
            let reader = match &mut open {
                Some((log, reader)) if *log == place.log => reader,
                open => &mut open.insert((place.log, self.logs[place.log].open()?)).1,
            };
            let strike: Strike = reader.entry(place.strike)?;
            Ok(strike.among_all(order))
        })
    }
}
