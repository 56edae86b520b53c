//! Questions about the order of strikes, and the form of what depends on it.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use super::families::{REAL, Shuffles, Statistic};
use super::projection::{Basis, explained};
use super::table::{Column, cosines};
use super::wander::Wander;
use super::ways::most_explained;

/// Number of cosines over the order.
const COSINES: usize = 6;
/// Greatest number of rounds of wear, and phases at which the first strike may fall in one.
const ROUNDS: usize = 16;
const PHASES: u32 = 8;
/// Least number of strikes on each side of a step.
const SIDE: usize = 3;
/// Cycles over the order that are tried: up to `SLOW` turns by eighths, for then a quarter of a turn shows; up to `MOST_TURNS` by halves.
const SLOW: f64 = 6.0;
const MOST_TURNS: f64 = 40.0;
/// Step in turns by which a cycle that was found is refined, and the number of its harmonics.
const FINE: f64 = 0.03;
const HARMONICS: usize = 3;
/// Greatest number of objects, tips or people that may be used in turn.
const IN_TURN: usize = 6;
/// Times that what was done to a table may last, as a share of the strikes.
const LASTS: [f64; 3] = [0.06, 0.125, 0.25];
/// Share of the strikes for which both levels of a ramp last at the least: what rises from the first strike on is wear.
const AT_A_LEVEL: f64 = 0.25;
/// Share of the strikes over which wear that sets in later is seen at the least.
const LEAST_WORN: f64 = 0.1;
/// Number of strikes at which a beginning is tried.
const BEGINNINGS: usize = 40;
/// Places at which a table may have been cleaned, where forms are compared to those of wanders. Every strike would cost that test power.
const CLEANINGS: usize = 20;
/// Margin in −2 ln L by which a form for which the library has no effect must be better: odds of a hundred to one.
const EXCLUDED: f64 = 9.2;
/// Number of simulated wanders that the column is compared with.
const DRAWN: usize = 999;

/// How a column depends on the order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Form {
    /// Brownian noise: each strike near the one before.
    Wander,
    /// A wander that no other form describes nearly as well.
    WanderAlone,
    Drift,
    /// A step at the strike of this number, or between sessions beside it.
    Step(usize),
    /// A step at the strike of this number, far from where a session begins.
    StepInSession(usize),
    Wear,
    Cycle,
    Sessions,
    /// In each session the same wear, from the same level.
    WearInSessions,
    /// Sessions of their own levels, in each of which it changes by as much: a drift beside them does the same.
    DriftAndSessions,
    /// A step that wears off.
    WearsOff,
    /// A ramp from one level to another, over some strikes.
    Ramp,
    /// Wear that begins at a strike, as once a coating is rubbed through.
    SetsIn,
    /// Wear from a level that is made as new at a strike, as a table that is cleaned.
    MadeNew,
}

impl Form {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Wander | Self::WanderAlone => "wander",
            Self::Drift => "drift",
            Self::Step(_) | Self::StepInSession(_) => "step",
            Self::Wear => "wear",
            Self::Cycle => "cycle",
            Self::Sessions => "sessions",
            Self::WearInSessions => "wear within sessions",
            Self::DriftAndSessions => "a drift, or wear, within sessions that differ",
            Self::WearsOff => "a step that wears off",
            Self::Ramp => "from one level to another",
            Self::SetsIn => "wear that sets in later",
            Self::MadeNew => "wear, made as new once",
        }
    }

    /// Whether no effect of the library by the order or by session makes a column of this form: none makes launch speeds differ between sessions, or
    /// launch angles change little by little.
    pub(crate) fn has_no_name(self, of: Column) -> bool {
        match self {
            Self::Cycle | Self::WearInSessions | Self::WearsOff | Self::MadeNew => true,
            Self::Sessions => of == Column::Launch,
            Self::Drift | Self::Wear | Self::Ramp | Self::SetsIn => of == Column::Heading,
            _ => false,
        }
    }
}

/// A form, the functions that it takes, and how many values it has.
type Described = (Form, Vec<DVector<f64>>, f64);

/// One column, to be asked about its order.
pub(super) struct InOrder {
    /// Which column of the strike table it is.
    pub(super) of: Column,
    /// Its values, weighed, with the dependence on commands taken off.
    pub(super) values: DVector<f64>,
    pub(super) weights: DVector<f64>,
    /// Basis of what was taken off.
    pub(super) beside: Basis,
    /// The number of each strike: strikes that take no part count.
    pub(super) numbers: DVector<f64>,
    /// Which session each strike is of.
    pub(super) sessions: Vec<usize>,
}

impl InOrder {
    fn place(&self) -> DVector<f64> {
        let n = self.values.len();
        DVector::from_fn(n, |i, _| (i as f64 + 0.5) / n as f64)
    }

    /// Where among all numbers each strike's is, 0 to 1: a cycle goes on while strikes take no part.
    fn among_all(&self) -> DVector<f64> {
        let (first, last) = (self.numbers.min(), self.numbers.max());
        self.numbers
            .map(|number| (number - first + 0.5) / (last - first + 1.0))
    }

    fn of_sessions(&self) -> Vec<DVector<f64>> {
        let count = self.sessions.iter().max().map_or(0, |last| last + 1);
        let is_in =
            |s: usize| DVector::from_fn(self.values.len(), |i, _| f64::from(self.sessions[i] == s));
        (1..count).map(is_in).collect()
    }

    fn beside(&self, functions: Vec<DVector<f64>>) -> Vec<DVector<f64>> {
        self.beside
            .beside(functions.iter().map(|f| f.component_mul(&self.weights)))
    }

    /// How neighbours, steps, slow changes and sessions show, and how cycles do: of the column as it is, then in every order.
    pub(super) fn asked(&self, shuffles: &Shuffles) -> [Vec<(&'static str, Statistic)>; 2] {
        let mut all = shuffles.permuted(self.values.as_slice());
        // What is taken off stays with its place.
        for own in &self.beside.0 {
            let along = all.tr_mul(own);
            all.ger(-1.0, own, &along, 1.0);
        }
        let mut asked = vec![(
            "order",
            explained(&self.beside(cosines(&self.place(), COSINES)), &all),
        )];
        let sessions = self.of_sessions();
        if !sessions.is_empty() {
            asked.push(("session", explained(&self.beside(sessions), &all)));
        }
        let steps = self.steps();
        let best = |c: &[f64]| steps.best(c, &self.weights).map_or(0.0, |(_, gain)| gain);
        asked.push(("order", columns(&all).map(best).collect()));
        let alike = |c: &[f64]| c.windows(2).map(|pair| (pair[0] + pair[1]).powi(2)).sum();
        asked.push(("order", columns(&all).map(alike).collect()));
        let in_turn = self
            .in_turn()
            .map(|each| explained(&self.beside(each), &all));
        let mut cycles: Vec<_> = in_turn.map(|explained| ("order", explained)).collect();
        let turns = self.turns().map(|turns| self.turning(turns));
        let waved = most_explained(turns, &self.beside, &all);
        cycles.extend(waved.map(|waved| ("order", waved)));
        [asked, cycles]
    }

    /// Cycles over the order that are tried.
    fn turns(&self) -> impl Iterator<Item = f64> {
        let most = MOST_TURNS.min(0.25 * self.values.len() as f64);
        let next = |turns: &f64| Some(turns + if *turns < SLOW { 0.125 } else { 0.5 });
        std::iter::successors(Some(1.0), next).take_while(move |turns| *turns <= most)
    }

    /// Which of two, three and more each strike is, by its number, where they are used in turn.
    fn in_turn(&self) -> impl Iterator<Item = Vec<DVector<f64>>> {
        let most = IN_TURN.min(self.values.len() / (2 * SIDE));
        (2..=most).map(|all| {
            let is = |one| {
                self.numbers
                    .map(|number| f64::from(number as usize % all == one))
            };
            (1..all).map(is).collect()
        })
    }

    fn turning(&self, turns: f64) -> [DVector<f64>; 2] {
        let place = self.among_all();
        [f64::cos, f64::sin].map(|of| place.map(|t| of(TAU * turns * t)))
    }

    fn steps(&self) -> Steps {
        let n = self.values.len();
        let places = SIDE..=n.saturating_sub(SIDE);
        Steps(
            places
                .map(|k| {
                    let step =
                        DVector::from_fn(n, |i, _| if i < k { self.weights[i] } else { 0.0 });
                    (k, self.beside.off(step).norm_squared())
                })
                .collect(),
        )
    }

    /// The form: a wander, unless the column differs from wanders that are drawn with its own likeliest ratio. It may differ in how much
    /// better another form describes it, in how much likelier a smooth change is, or in the largest of its innovations (what a Kalman filter of
    /// that wander does not foresee): a wander makes no step.
    ///
    /// With it, functions of the strikes that hold what is of this form; none of a wander.
    pub(super) fn form(&self, wander: &Wander, seed: u64) -> (Form, Vec<DVector<f64>>) {
        let (mut forms, steps) = (self.forms(), self.steps());
        let n = self.values.len();
        let beside = wander.beside(&self.beside.0);
        let smooth = wander.smooth();
        let smooth = smooth.beside(&self.beside.0);
        let values = (n as f64).ln();
        // Bayes' information criterion of each other form, in the order of `forms`, and of the best step.
        let all = |column: &DVector<f64>, forms: &[Described]| -> Vec<(Form, f64)> {
            let whole = column.norm_squared();
            let criterion = |taken: f64, count: f64| {
                n as f64 * ((whole - taken).max(1e-300) / n as f64).ln() + count * values
            };
            let step = steps.best(column.as_slice(), &self.weights);
            let step = step.map(|(k, taken)| (Form::Step(k), criterion(taken, 2.0)));
            let others = forms.iter().map(|(form, questions, count)| {
                let taken = questions.iter().map(|q| q.dot(column).powi(2)).sum();
                (*form, criterion(taken, *count))
            });
            others.chain(step).collect()
        };
        let least = |all: &[(Form, f64)], counts: &dyn Fn(Form) -> bool| {
            let counted = all.iter().filter(|(form, _)| counts(*form)).copied();
            let best = counted.min_by(|a, b| a.1.total_cmp(&b.1));
            best.unwrap_or((Form::Drift, f64::INFINITY))
        };
        let compared = |column: &DVector<f64>, all: &[(Form, f64)]| {
            let (ratio, deviance) = beside.likeliest(column);
            let mut innovations = wander.innovations(ratio, column);
            // Sessions may differ by more than a wander, and the filter begins without a state.
            for (i, innovation) in innovations.iter_mut().enumerate() {
                if i < 2 || self.sessions[i] != self.sessions[i - 1] {
                    *innovation = 0.0;
                }
            }
            let by_form = deviance + values - least(all, &|_| true).1;
            let by_smooth = deviance - smooth.likeliest(column).1;
            (ratio, [by_form, by_smooth, largest(innovations.as_slice())])
        };
        let own = all(&self.values, &forms);
        let (ratio, statistics) = compared(&self.values, &own);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut rows = vec![statistics];
        rows.extend((0..DRAWN).map(|_| {
            let independent = DVector::from_fn(n, |_, _| StandardNormal.sample(&mut random));
            let drawn = self.beside.off(wander.drawn(ratio, &independent));
            compared(&drawn, &all(&drawn, &forms)).1
        }));
        if share_as_far(&rows) >= REAL {
            let [by_form, ..] = statistics;
            let form = match by_form < -EXCLUDED {
                true => Form::WanderAlone,
                false => Form::Wander,
            };
            return (form, Vec::new());
        }
        // It is none: now the strike at which it was made as new is sought among all.
        forms.extend(self.made_new(1));
        let own = all(&self.values, &forms);
        let best = least(&own, &|_| true);
        let named = least(&own, &|form| {
            !form.has_no_name(self.of) && form != Form::DriftAndSessions
        });
        let (form, criterion) = match named.1 - best.1 < EXCLUDED {
            true => named,
            false => best,
        };
        match form {
            Form::Step(k) => {
                let before = DVector::from_fn(n, |i, _| f64::from(i < k));
                let at = self.numbers[k] as usize;
                match (self.is_inside(k, &steps), self.of) {
                    (true, _) => (Form::StepInSession(at), vec![before]),
                    // Nothing at the tip is known to have changed where a day began.
                    (false, Column::Launch) => (Form::Sessions, self.of_sessions()),
                    (false, _) => (Form::Step(at), vec![before]),
                }
            }
            form => {
                let chosen = own.iter().position(|other| *other == (form, criterion));
                let chosen = chosen.and_then(|k| forms.get(k)).cloned();
                let mut functions = chosen
                    .map(|(_, functions, _)| functions)
                    .unwrap_or_default();
                match form {
                    Form::Cycle => functions = self.finer_cycle((functions, criterion)),
                    Form::WearInSessions => functions = self.beside(self.worn_in_sessions()),
                    _ => {}
                }
                let functions = functions.iter();
                (
                    form,
                    functions.map(|f| f.component_div(&self.weights)).collect(),
                )
            }
        }
    }

    /// Whether a step at this strike is so much likelier than one where a session begins that this is excluded.
    fn is_inside(&self, strike: usize, steps: &Steps) -> bool {
        let gain = |k: usize| steps.gain(self.values.as_slice(), &self.weights, k);
        let left = (self.values.norm_squared() - gain(strike)) / self.values.len() as f64;
        (1..self.sessions.len())
            .filter(|k| self.sessions[*k] != self.sessions[*k - 1])
            .all(|k| gain(strike) - gain(k) > EXCLUDED * left)
    }

    /// The forms other than a wander or a step.
    fn forms(&self) -> Vec<Described> {
        let place = self.place();
        let mut forms = Vec::new();
        // The library's effects go on while strikes take no part; what changes with those that do is as plain.
        for place in [self.among_all(), place.clone()] {
            forms.push((Form::Drift, self.beside(vec![place.clone()]), 1.0));
            for length in [0.06, 0.125, 0.25, 0.5] {
                let worn = place.map(|t| 1.0 - (-t / length).exp());
                forms.push((Form::Wear, self.beside(vec![worn]), 2.0));
            }
        }
        for turns in self.turns() {
            let cycle = self.turning(turns).into();
            forms.push((Form::Cycle, self.beside(cycle), 3.0));
        }
        let every = (self.values.len() / BEGINNINGS).max(1);
        for k in (SIDE..self.values.len() - SIDE).step_by(every) {
            let begins = place[k];
            if (AT_A_LEVEL..1.0 - LEAST_WORN).contains(&begins) {
                let late = place.map(|t| (t - begins).max(0.0));
                forms.push((Form::SetsIn, self.beside(vec![late]), 2.0));
            }
            for length in LASTS {
                let since = |t: f64| (t - begins).max(0.0) / length;
                let worn = |t: f64| f64::from(t >= begins) * (-since(t)).exp();
                forms.push((Form::WearsOff, self.beside(vec![place.map(worn)]), 3.0));
                if begins > AT_A_LEVEL && begins + length < 1.0 - AT_A_LEVEL {
                    let ramp = |t: f64| since(t).min(1.0);
                    forms.push((Form::Ramp, self.beside(vec![place.map(ramp)]), 3.0));
                }
            }
        }
        forms.extend(self.made_new((self.values.len() / CLEANINGS).max(1)));
        for each in self.in_turn() {
            let count = each.len() as f64 + 1.0;
            forms.push((Form::Cycle, self.beside(each), count));
        }
        // Wears, and is made as new again and again.
        for rounds in 2..=(self.values.len() / (2 * SIDE)).min(ROUNDS) {
            for phase in 0..PHASES {
                let since = self
                    .among_all()
                    .map(|t| (t * rounds as f64 + f64::from(phase) / f64::from(PHASES)).fract());
                forms.push((Form::Cycle, self.beside(vec![since]), 3.0));
            }
        }
        let sessions = self.of_sessions();
        if !sessions.is_empty() {
            let count = sessions.len() as f64;
            let since = self.since_session();
            let within = sessions.iter().cloned().chain([since.clone()]).collect();
            forms.push((Form::WearInSessions, self.beside(vec![since]), 1.0));
            forms.push((Form::DriftAndSessions, self.beside(within), count + 1.0));
            forms.push((Form::Sessions, self.beside(sessions), count));
        }
        forms
    }

    /// Wear that is made as new at one strike of so many.
    fn made_new(&self, every: usize) -> impl Iterator<Item = Described> {
        let place = self.place();
        let strikes = (SIDE..self.values.len() - SIDE).step_by(every);
        strikes.map(move |k| {
            let cleaned = place[k];
            let before = place.map(|t| if t < cleaned { t } else { 0.0 });
            let after = place.map(|t| (t - cleaned).max(0.0));
            (Form::MadeNew, self.beside(vec![before, after]), 3.0)
        })
    }

    /// Functions that hold more of a cycle than those by which it was found, of this criterion: waves and their harmonics, and wear that is made as
    /// new, at any period and phase.
    fn finer_cycle(&self, found: (Vec<DVector<f64>>, f64)) -> Vec<DVector<f64>> {
        let n = self.values.len() as f64;
        let place = self.among_all();
        let most = MOST_TURNS.min(0.25 * n);
        let turns = (0..)
            .map(|k| 1.0 + FINE * f64::from(k))
            .take_while(|turns| *turns <= most);
        let waves = turns.clone().flat_map(|turns| {
            (1..=HARMONICS)
                .filter(move |highest| turns * *highest as f64 <= 0.25 * n)
                .map(move |highest| {
                    let each = (1..=highest).flat_map(|k| self.turning(turns * k as f64));
                    (each.collect::<Vec<_>>(), 1.0 + 2.0 * highest as f64)
                })
        });
        let place = &place;
        let rounds = turns
            .take_while(|turns| *turns <= ROUNDS as f64)
            .flat_map(|turns| {
                (0..4 * PHASES).map(move |phase| {
                    let begins = f64::from(phase) / f64::from(4 * PHASES);
                    (vec![place.map(|t| (t * turns + begins).fract())], 3.0)
                })
            });
        let whole = self.values.norm_squared();
        let (mut best, mut least) = found;
        for (functions, count) in waves.chain(rounds) {
            let functions = self.beside(functions);
            let taken: f64 = functions.iter().map(|q| q.dot(&self.values).powi(2)).sum();
            let criterion = n * ((whole - taken).max(1e-300) / n).ln() + count * n.ln();
            if criterion < least {
                (best, least) = (functions, criterion);
            }
        }
        best
    }

    /// Wear that is the same in each session, fast or slow.
    fn worn_in_sessions(&self) -> Vec<DVector<f64>> {
        let since = self.since_session();
        let worn = LASTS.map(|length| since.map(|t| (-t / length).exp()));
        std::iter::once(since).chain(worn).collect()
    }

    /// How far into its session each strike is, 0 to 1.
    fn since_session(&self) -> DVector<f64> {
        let n = self.values.len();
        let first = |s: usize| {
            self.sessions
                .iter()
                .position(|other| *other == s)
                .unwrap_or(0)
        };
        let count = |s: usize| self.sessions.iter().filter(|other| **other == s).count();
        DVector::from_fn(n, |i, _| {
            let s = self.sessions[i];
            (i - first(s).min(i)) as f64 / count(s).max(1) as f64
        })
    }
}

/// Largest absolute value, in standard deviations.
fn largest(values: &[f64]) -> f64 {
    let squares = values.iter().map(|v| v * v).sum::<f64>();
    let largest = values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    largest / (squares / values.len() as f64).sqrt().max(1e-300)
}

/// Share of the rows whose most extreme statistic, by its rank among all rows, is at least as extreme as that of the first row.
fn share_as_far<const N: usize>(rows: &[[f64; N]]) -> f64 {
    let mut furthest = vec![rows.len(); rows.len()];
    for k in 0..N {
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_by(|a, b| rows[*b][k].total_cmp(&rows[*a][k]));
        for (rank, row) in order.into_iter().enumerate() {
            furthest[row] = furthest[row].min(rank);
        }
    }
    let as_far = furthest.iter().filter(|rank| **rank <= furthest[0]).count();
    as_far as f64 / rows.len() as f64
}

/// Strikes at which a step may be, each with the squared norm of the step's column beside what was taken off.
struct Steps(Vec<(usize, f64)>);

impl Steps {
    /// The step that explains most of a column (its strike and the sum of squares); what was taken off must be off the column.
    fn best(&self, column: &[f64], weights: &DVector<f64>) -> Option<(usize, f64)> {
        let mut sum = 0.0;
        let mut done = 0;
        let gains = self.0.iter().map(|(k, norm)| {
            while done < *k {
                sum += column[done] * weights[done];
                done += 1;
            }
            (*k, sum * sum / norm.max(1e-12))
        });
        gains.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Sum of squares that a step at this strike explains of a column; zero near the ends.
    fn gain(&self, column: &[f64], weights: &DVector<f64>, strike: usize) -> f64 {
        let found = self.0.iter().find(|(k, _)| *k == strike);
        found.map_or(0.0, |(_, norm)| {
            let sum: f64 = (0..strike).map(|i| column[i] * weights[i]).sum();
            sum * sum / norm.max(1e-12)
        })
    }
}

fn columns(all: &DMatrix<f64>) -> impl Iterator<Item = &[f64]> {
    all.as_slice().chunks_exact(all.nrows())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The form of scatter of 1 beside a wander of this ratio and what is hidden, by strike; sessions of `session` strikes.
    fn formed(
        seed: u64,
        ratio: f64,
        n: usize,
        session: usize,
        hidden: impl Fn(usize) -> f64,
    ) -> Form {
        let column = in_order(seed, ratio, n, session, &|i| i as f64, hidden);
        column.form(&Wander::new(&column.numbers), seed).0
    }

    /// A column for tests, of strikes with these numbers.
    fn in_order(
        seed: u64,
        ratio: f64,
        n: usize,
        session: usize,
        number: &dyn Fn(usize) -> f64,
        hidden: impl Fn(usize) -> f64,
    ) -> InOrder {
        let numbers = DVector::from_fn(n, |i, _| number(i));
        let wander = Wander::new(&numbers);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let independent = DVector::from_fn(n, |_, _| StandardNormal.sample(&mut random));
        let beside = Basis::new([DVector::repeat(n, 1.0)]);
        InOrder {
            of: Column::Friction,
            values: beside
                .off(wander.drawn(ratio, &independent) + DVector::from_fn(n, |i, _| hidden(i))),
            weights: DVector::repeat(n, 1.0),
            beside,
            numbers,
            sessions: (0..n).map(|i| i / session).collect(),
        }
    }

    #[test]
    fn what_holds_a_cycle_leaves_what_strikes_scatter_by() {
        let n = 90;
        let hidden: [&dyn Fn(usize) -> f64; 3] = [
            &|i| 4.0 * (TAU * i as f64 / 8.24).sin(),
            &|i| 10.0 * (i as f64 / 10.3).fract(),
            &|i| 8.0 * (-((i % 15) as f64) / 3.6).exp(),
        ];
        for hidden in hidden {
            for seed in 0..5 {
                let column = in_order(seed, 0.0, n, 15, &|i| i as f64, hidden);
                let (form, functions) = column.form(&Wander::new(&column.numbers), seed);
                assert!(form.has_no_name(Column::Friction), "{form:?}");
                let left = Basis::new(functions).off(column.values);
                let scatter = left.norm() / (n as f64).sqrt();
                assert!((0.8..1.2).contains(&scatter), "{form:?} {scatter}");
            }
        }
    }

    #[test]
    fn a_wander_is_one_and_a_step_in_it_is_none() {
        let wandering = |seed: u64, step: f64, at: usize| {
            formed(seed, 10.0, 60, 30, |i| if i < at { 0.0 } else { step })
        };
        let is_other = |seed: &u64| wandering(*seed, 0.0, 0) != Form::Wander;
        // At 1 %, three of thirty have a chance of 1 in 250.
        assert!((0..30).filter(is_other).count() < 3);
        for seed in 0..5 {
            let inside = wandering(seed, 15.0, 14);
            assert!(matches!(inside, Form::StepInSession(12..=16)), "{inside:?}");
            let between = wandering(seed, 15.0, 30);
            assert!(
                !matches!(between, Form::Wander | Form::StepInSession(_)),
                "{between:?}"
            );
        }
    }

    #[test]
    fn a_step_that_comes_soon_after_a_session_began_is_not_the_session_s() {
        let late = |seed: &u64| {
            let form = formed(*seed, 0.0, 90, 30, |i| if i < 63 { 0.0 } else { 4.0 });
            matches!(form, Form::StepInSession(_))
        };
        // In 19 of 20.
        assert!((0..10).filter(late).count() >= 8);
        for seed in 0..5 {
            let with_it = formed(seed, 0.0, 90, 30, |i| if i < 60 { 0.0 } else { 4.0 });
            assert!(!matches!(with_it, Form::StepInSession(_)), "{with_it:?}");
        }
    }

    #[test]
    fn a_drift_goes_on_while_strikes_take_no_part() {
        // Three sessions of twenty strikes; many more between them took no part. A wander of such numbers may go as far, but not as straight.
        let number = |i: usize| (i + 60 * (i / 20)) as f64;
        for seed in 0..5 {
            let drift = in_order(seed, 0.0, 60, 20, &number, |i| 0.15 * number(i));
            assert_eq!(
                drift.form(&Wander::new(&drift.numbers), seed).0,
                Form::Drift
            );
        }
    }

    #[test]
    fn what_rises_over_some_strikes_and_stays_is_no_wander() {
        for seed in 0..5 {
            let ramp = |i: usize| 12.0 * ((i as f64 - 90.0) / 25.0).clamp(0.0, 1.0);
            let form = formed(seed, 0.0, 200, 200, ramp);
            assert_eq!(form, Form::Ramp);
            // What begins with the first strike wears.
            let wear = |i: usize| 20.0 * (1.0 - (-(i as f64) / 30.0).exp());
            assert_eq!(formed(seed, 0.0, 90, 90, wear), Form::Wear);
        }
    }

    #[test]
    fn what_wears_and_is_made_as_new_once_has_no_name() {
        // Made as new in the first third or the middle of a session, it wears as fast as before, or less.
        let mut told = 0;
        for seed in 0..10 {
            for (at, later) in [(40, 1.0), (68, 0.3)] {
                let worn = |i: usize| 0.12 * i.min(if i < at { i } else { 0 }) as f64;
                let again = |i: usize| 0.12 * later * i.saturating_sub(at) as f64;
                let form = formed(seed, 0.0, 120, 60, |i| worn(i) + again(i));
                told += usize::from(form == Form::MadeNew);
            }
        }
        assert!(told >= 18, "{told} of 20");
    }

    #[test]
    fn a_step_of_launches_where_a_session_begins_is_the_sessions() {
        let launched = |seed, n: usize, hidden: &dyn Fn(usize) -> f64| {
            let column = in_order(seed, 0.0, n, 30, &|i| i as f64, hidden);
            let of = Column::Launch;
            let wander = Wander::new(&column.numbers);
            InOrder { of, ..column }.form(&wander, seed).0
        };
        for seed in 0..5 {
            let in_turn = launched(seed, 120, &|i| 4.0 * (i / 30 % 2) as f64);
            assert_eq!(in_turn, Form::Sessions);
            let changed_once = launched(seed, 60, &|i| 4.0 * (i / 30) as f64);
            assert_eq!(changed_once, Form::Sessions);
            let within = launched(seed, 120, &|i| 4.0 * (i / 45).min(1) as f64);
            assert!(matches!(within, Form::StepInSession(44..=46)), "{within:?}");
        }
    }

    #[test]
    fn what_cycles_slowly_or_wears_off_or_comes_back_each_session_has_no_name() {
        let cycle = |i: usize| 4.0 * (TAU * 2.3 * i as f64 / 120.0).sin();
        let worn_off = |i: usize| match i < 50 {
            true => 0.0,
            false => 6.0 * (-((i - 50) as f64) / 15.0).exp(),
        };
        let each_session = |i: usize| 0.15 * (i % 30) as f64;
        let mut worn_off_told = 0;
        for seed in 0..5 {
            assert_eq!(formed(seed, 0.0, 120, 60, cycle), Form::Cycle);
            let third = |i: usize| if i % 3 == 1 { 4.0 } else { 0.0 };
            assert_eq!(formed(seed, 0.0, 120, 60, third), Form::Cycle);
            let form = formed(seed, 0.0, 120, 30, each_session);
            assert!(form.has_no_name(Column::Friction), "{form:?}");
            // A wander may look like it.
            let form = formed(seed, 0.0, 120, 60, worn_off);
            assert!(matches!(form, Form::WearsOff | Form::Wander), "{form:?}");
            worn_off_told += usize::from(form == Form::WearsOff);
            for change in [0.02, 0.04, 0.08] {
                let drift = formed(seed, 0.0, 120, 30, |i| change * i as f64);
                assert!(!drift.has_no_name(Column::Friction), "{drift:?}");
            }
        }
        assert!(worn_off_told >= 4, "{worn_off_told} of 5");
    }
}
