//! The table as recent strikes show it, beside one of a version's models.

use serde::{Deserialize, Serialize};
use store::ResidualModel;
use values::Strike;
use world::{Filter, Observation, Observer, Simulator, TableChanged, Varies};

/// Time in s between two strikes from which they are of two sessions: a table is switched off, cleaned, set up anew.
pub const SESSION_GAP: f64 = 4.0 * 3600.0;

/// A table that is followed from strike to strike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recent {
    filter: Filter,
    /// Number of strikes seen, those included that show no free slide.
    seen: usize,
    /// Stamp of the last one's first motion, in s.
    last: Option<f64>,
}

/// A model as it acts: its world with what the arm delivers, and its world alone, for networks.
pub(crate) struct Acting<'a> {
    pub delivering: &'a Simulator,
    pub alone: &'a Simulator,
    pub residual: Option<&'a ResidualModel>,
    /// Number of strikes that the version knows: the order of the next one.
    pub order: f64,
}

impl Recent {
    /// A table before any strike was followed.
    pub fn new(varies: &Varies) -> Self {
        Self {
            filter: Filter::new(varies),
            seen: 0,
            last: None,
        }
    }

    /// The belief about the table.
    pub fn filter(&self) -> &Filter {
        &self.filter
    }

    /// Number of strikes seen, those included that show no free slide.
    pub fn seen(&self) -> usize {
        self.seen
    }

    /// Stamp of the last strike's first motion, in s; none before any.
    pub fn last(&self) -> Option<f64> {
        self.last
    }

    /// Begins a session before the next strike, whatever its stamp says.
    pub(crate) fn begin_session(&mut self) {
        self.filter.begin_session();
    }

    /// Follows strikes in the order of time.
    ///
    /// # Errors
    /// Where the table then is farther from the version's own than that believes possible.
    pub(crate) fn follow(
        &mut self,
        model: &Acting<'_>,
        strikes: &[Strike],
    ) -> Result<(), TableChanged> {
        for strike in strikes {
            let gap = self.last.map(|last| strike.t_start - last);
            if gap.is_none_or(|gap| gap.abs() > SESSION_GAP) {
                self.begin_session();
            }
            self.last = Some(strike.t_start);
            let order = model.order + self.seen as f64;
            self.seen += 1;
            let strike = strike.clone().among_all(order as u32);
            // Compared about what is known before it, then about what is known after: slopes change along the way.
            let about = |filter: &Filter| observe(model, &strike, filter);
            if let Some(first) = about(&self.filter) {
                let after = self.filter.after(&first, 1.0);
                let second = about(&after);
                self.filter = second.map_or(after, |second| self.filter.after(&second, 1.0));
            }
        }
        self.filter.check()
    }
}

fn observe(model: &Acting<'_>, strike: &Strike, filter: &Filter) -> Option<Observation> {
    let sent = match model.residual {
        Some(residual) => residual.without_added(
            model.alone,
            strike.initial,
            strike.command,
            &strike.conditions,
        )?,
        None => strike.command,
    };
    let here = model.delivering.shifted(filter.mean());
    Observer::about(&here).observe(strike, sent)
}
