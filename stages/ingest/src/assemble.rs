//! All logs together: one row for each strike, in order of time; strikes are read one by one from where each log's were kept.

use std::collections::HashMap;

use stage::{Entries, ListAnswer, Reader, StageError};
use values::{End, Reject, RejectReason, Strike};

use crate::caught::{Braking, Caught, caught};
use crate::outcome::{LogOutcome, StrikeSummary};
use crate::settings::Ingest;
use crate::slide::FEWEST_CENSORED;

/// Joins what came out of the logs, in whatever order they come: strikes by time, then id, each with its rank in
/// `conditions.order`; rejects by log, then index.
///
/// Of a strike that several logs hold, the one with most frames is kept (logs may be cut differently), then that of the
/// first log by name; the others are rejected as duplicates. So is one that lies where an earlier one does, frame by frame, under other stamps.
/// What was braked to its stop as no table brakes the others of its log is rejected as well, and the track of what stood at once ends before (`caught`).
pub fn assemble(outcomes: Vec<LogOutcome>) -> (Vec<Strike>, Vec<Reject>) {
    let (found, mut held): (Vec<_>, Vec<Vec<_>>) = outcomes
        .into_iter()
        .map(|mut outcome| {
            let strikes = std::mem::take(&mut outcome.strikes);
            let found = outcome
                .with_strikes(|_: Vec<Strike>| strikes.iter().map(StrikeSummary::from).collect());
            (found, strikes.into_iter().map(Some).collect())
        })
        .unzip();
    let (places, rejects) = join(found);
    let strikes = places.iter().zip(0_u32..).filter_map(|(place, order)| {
        let strike: Strike = held[place.log][place.strike].take()?;
        Some(place.of_all(strike, order))
    });
    (strikes.collect(), rejects)
}

/// Where a strike lies: its log's place among all logs, and its own among the strikes kept of that log.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) log: usize,
    pub(crate) strike: usize,
    /// Number of its frames before something stopped the object, where that is.
    pub(crate) caught: Option<usize>,
}

impl Place {
    /// The strike that lies here, as one of all.
    fn of_all(&self, strike: Strike, order: u32) -> Strike {
        let strike = match self.caught {
            Some(frames) => strike.ended(frames, End::Contact),
            None => strike,
        };
        strike.among_all(order)
    }
}

/// The places of all strikes in order of time, and all rejects.
pub(crate) fn join(mut outcomes: Vec<LogOutcome<StrikeSummary>>) -> (Vec<Place>, Vec<Reject>) {
    let mut rejects: Vec<Reject> = outcomes
        .iter_mut()
        .flat_map(|outcome| std::mem::take(&mut outcome.rejects))
        .map(Reject::in_words)
        .collect();
    let strike = |place: &Place| &outcomes[place.log].strikes[place.strike];
    let log = |place: &Place| &outcomes[place.log];

    let mut places: Vec<Place> = outcomes
        .iter()
        .enumerate()
        .flat_map(|(log, outcome)| {
            (0..outcome.strikes.len()).map(move |strike| Place {
                log,
                strike,
                caught: None,
            })
        })
        .collect();
    places.sort_by(|a, b| {
        let (one, other) = (strike(a), strike(b));
        let by_log = (&log(a).log, one.index, &log(a).sha256).cmp(&(
            &log(b).log,
            other.index,
            &log(b).sha256,
        ));
        one.id
            .cmp(&other.id)
            .then(other.frames.cmp(&one.frames))
            .then(by_log)
    });
    let again = |place: &Place, kept: &Place, how: &str| {
        let (again, first) = (strike(place), strike(kept));
        Reject {
            log: log(place).log.clone(),
            index: again.index,
            t_start: again.t_start,
            reason: RejectReason::Duplicate,
            detail: format!(
                "it is strike {} of {} ({}){how}",
                first.index,
                log(kept).log,
                first.id
            ),
        }
    };
    places.dedup_by(|place, kept| {
        let is_same = strike(place).id == strike(kept).id;
        if is_same {
            rejects.push(again(place, kept, ""));
        }
        is_same
    });
    places.sort_by(|a, b| {
        let (one, other) = (strike(a), strike(b));
        let by_time = one.t_start.total_cmp(&other.t_start);
        by_time.then_with(|| one.id.cmp(&other.id))
    });
    // Played back and recorded once more, it has other stamps.
    let mut known: HashMap<&str, Place> = HashMap::new();
    places.retain(|place| {
        let first = strike(place)
            .places
            .as_deref()
            .map(|id| *known.entry(id).or_insert(*place));
        let first = first.filter(|first| (first.log, first.strike) != (place.log, place.strike));
        if let Some(first) = &first {
            rejects.push(again(place, first, ", with other stamps"));
        }
        first.is_none()
    });
    let mut of_logs: HashMap<usize, Vec<Option<Braking>>> = HashMap::new();
    for place in &places {
        let of_log = of_logs.entry(place.log).or_default();
        of_log.push(strike(place).braking);
    }
    let mut of_logs: HashMap<usize, _> = of_logs
        .into_iter()
        .map(|(log, brakings)| (log, caught(&brakings).into_iter()))
        .collect();
    places.retain_mut(|place| {
        let caught = of_logs.get_mut(&place.log).and_then(Iterator::next);
        let how = match caught.flatten() {
            None => return true,
            Some(Caught::AtOnce(frames)) if frames >= FEWEST_CENSORED => {
                place.caught = Some(frames);
                return true;
            }
            Some(Caught::AtOnce(frames)) => format!(
                "{frames} frames after first motion the object stands from one frame to the next, as no table stops those that stop nearest"
            ),
            Some(Caught::Slowly(times)) => format!(
                "before its stop the object brakes {times:.1} times as hard as those that stop nearest and those struck before and after it"
            ),
        };
        rejects.push(stopped(log(place), strike(place), &how));
        false
    });
    rejects.sort_by(|a, b| {
        (&a.log, a.index, a.reason.name(), &a.detail).cmp(&(
            &b.log,
            b.index,
            b.reason.name(),
            &b.detail,
        ))
    });
    (places, rejects)
}

/// The rejection of a strike whose object stopped as others do not.
fn stopped(log: &LogOutcome<StrikeSummary>, strike: &StrikeSummary, how: &str) -> Reject {
    Reject {
        log: log.log.clone(),
        index: strike.index,
        t_start: strike.t_start,
        reason: RejectReason::NoRestAfter,
        detail: format!("{how}: something stopped it; let objects come to rest by themselves"),
    }
}

/// The strikes of all logs, as [`assemble`](crate::assemble) joins them; a few bytes are held of each.
#[derive(Clone, Debug, Default)]
pub struct Strikes {
    logs: Vec<Entries<Strike>>,
    places: Vec<Place>,
    notes: Vec<String>,
}

impl Strikes {
    /// Joins logs, each with the strikes that were kept of it; also gives what was rejected.
    pub fn join(logs: Vec<ListAnswer<Ingest>>) -> (Self, Vec<Reject>) {
        let (outcomes, logs): (Vec<_>, _) = logs.into_iter().unzip();
        let names: Vec<String> = outcomes.iter().map(|outcome| outcome.log.clone()).collect();
        let (places, rejects) = join(outcomes);
        let note = |(log, name): (usize, &String)| {
            let caught = places.iter().filter(|p| p.log == log && p.caught.is_some());
            let count = caught.count();
            (count > 0).then(|| format!("{name}: objects that stand from one frame to the next, as no table stops the others of the log: {count}; something stopped them, and their tracks count up to there, without a stop"))
        };
        let notes = names.iter().enumerate().filter_map(note).collect();
        let strikes = Self {
            logs,
            places,
            notes,
        };
        (strikes, rejects)
    }

    /// What a person should know of strikes that only other strikes tell, each with the log's name.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Number of strikes.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there is no strike.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Reads the strikes, in order of time.
    pub fn iter(&self) -> impl Iterator<Item = Result<Strike, StageError>> {
        // Logs follow one another in time, most often.
        let mut open: Option<(usize, Reader<'_, Strike>)> = None;
        self.places.iter().zip(0_u32..).map(move |(place, order)| {
            let reader = match &mut open {
                Some((log, reader)) if *log == place.log => reader,
                open => &mut open.insert((place.log, self.logs[place.log].open()?)).1,
            };
            let strike: Strike = reader.entry(place.strike)?;
            Ok(place.of_all(strike, order))
        })
    }
}
