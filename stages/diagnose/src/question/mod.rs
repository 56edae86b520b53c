//! One question asked of everything: does what the world would need for a strike depend on its command, its start, its place in the
//! order, or differ from none where the world says none?
//!
//! The strike table ([`table`]) has what each strike needs. Each of its columns is asked by permutations, which believe no noise model, in
//! four families (commands, order, cycles over the order, levels); a fifth asks whether strikes fall into two groups ([`groups`]). Each has a
//! fifth of the level. The strongest answer of a family is calibrated by what the same
//! questions answer to the same 1999 permutations, so that the many looks count ([`families`]). Commands and starts are the only
//! covariates: what was realised holds the errors that it would be asked about. CameBefore commands are asked, a wander of launch or friction
//! over the order is taken off, the greatest that the strikes do not exclude; sessions are projected out (Freedman and Lane 1983). What
//! depends on the order in no other form than a wander is noise, and told as such. What moves stops by little beside what repeats scatter by
//! is no gap. The same is asked again beside the effects that would be named.

mod components;
mod families;
mod groups;
mod order;
mod place;
mod projection;
mod table;
mod wander;
mod ways;

pub(crate) use components::{Components, StandardDeviation, Variation};
pub(crate) use families::{PERMUTED, REAL};
pub use order::Form;
pub use table::Column;

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use values::Command;

use self::families::{Calibrated, Shuffles, Statistic, calibrated};
use self::groups::Groups;
use self::order::InOrder;
use self::place::{Pushes, Weighed, weighed};
use self::projection::{Basis, explained};
use self::table::{COLUMNS, Cell, Covariates, Row, Wave, column as column_of, table};
use self::wander::{Wander, WanderBeside};
use crate::{before::CameBefore, fit::Fitted, strikes::PreparedStrikes};

/// Ratio to the scatter of repeats below which motion of stops is no gap: it adds less than 5 % to a stop's error.
const LITTLE: f64 = 1.0 / 3.0;
/// Motion of stops (m) below which it is no gap, where repeats scatter by this much and less than `resolved` is none.
pub(crate) fn little(repeats: f64, resolved: f64) -> f64 {
    (LITTLE * repeats).max(resolved)
}

/// Least share of the strikes' variance that is taken for that of repeats, whatever else is found in it.
const LEAST_FLOOR: f64 = 0.1;
/// Covariates that come from before the strike, not from its own command.
const BEFORE: [&str; 4] = ["command before", "start before", "commands before", "pause"];
/// Columns of whole strikes, which may change with the order.
const NEEDS: [Column; 4] = [
    Column::Launch,
    Column::Heading,
    Column::Friction,
    Column::Stop,
];
/// Number of families of questions; each gets an equal share of the level [`REAL`].
const FAMILIES: f64 = 6.0;
/// Covariate of strikes that fall into two groups, which nothing that was logged tells apart.
const GROUP: &str = "group";
/// Squared correlation with the order above which commands run with it: then what depends on them is not taken off.
const RUNS_WITH_ORDER: f64 = 0.5;

/// What a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum What {
    Column(Column),
    /// Pushes along or across the way, by place.
    Along,
    Across,
}

/// A dependence that is no chance.
#[derive(Clone, Debug)]
pub(crate) struct Finding {
    pub(crate) what: What,
    pub(crate) covariate: &'static str,
    /// Probability by chance, corrected for all questions.
    pub(crate) p_value: f64,
    /// By how much it moves stops, root mean square, in m.
    pub(crate) size: f64,
    /// Whether it is left where smooth functions of the strikes' commands are taken off.
    is_unsmooth: bool,
    /// How it depends on the order, where the order is what it depends on.
    pub(crate) form: Option<Form>,
}

impl Finding {
    /// Whether it changes with the order as no effect of the library does.
    fn has_no_name(&self) -> bool {
        match (self.what, self.form) {
            (What::Column(of), Some(form)) => form.has_no_name(of),
            _ => false,
        }
    }
}

/// Dependences that no smooth function of a command or of two holds.
struct Unsmooth {
    /// On commands, as they change with the order or from session to session.
    by_time: Vec<(&'static str, Vec<DVector<f64>>)>,
    /// On commands, or on where joints stand: waves of one period.
    ripples: Vec<(&'static str, Vec<Wave>)>,
    /// On the places that strikes slide over, in all sessions or in one: roots of covariances.
    ways: Vec<Vec<DVector<f64>>>,
    /// Waves over the table.
    waves: Vec<Wave>,
}

/// What the question answers of a world.
#[derive(Clone, Debug, Default)]
pub(crate) struct Answer {
    /// Dependences that are neither chance nor a wander, the largest first.
    pub(crate) findings: Vec<Finding>,
    /// Scatter of the stops of repeats of these commands, in m.
    pub(crate) floor: f64,
    /// Motion of stops, in m, that is none.
    resolved: f64,
    is_box: bool,
    has_sessions: bool,
    /// Whether commands or starts follow the order of strikes.
    pub(crate) runs_with_order: bool,
    /// Functions of the strikes that hold what was found in a column to depend on the order, or on the strikes before.
    by_order: Vec<(Column, Vec<DVector<f64>>)>,
}

/// Which effects by the order of strikes there are.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EffectsByOrder {
    pub(crate) by_session: bool,
    /// Whether an effect changes with the number of strikes before.
    pub(crate) drift: bool,
}

impl Answer {
    pub(crate) fn is_gap(&self) -> bool {
        self.findings
            .iter()
            .any(|found| found.size > self.least_of(found))
    }

    /// Whether a gap is left beside names that move stops by `by` (m): a finding that moves them by more than repeats scatter, or has more than half of
    /// the names' variance.
    pub(crate) fn is_beyond(&self, by: f64) -> bool {
        let least = self.floor.min(FRAC_1_SQRT_2 * by);
        self.findings
            .iter()
            .any(|found| found.size > least.max(self.least_of(found)))
    }

    /// Whether a gap is one of launches.
    pub(crate) fn is_of_launches(&self) -> bool {
        let is_of_launch = |what| matches!(what, What::Column(column) if column.is_of_launch());
        let mut findings = self.findings.iter();
        findings.any(|found| found.size > self.least_of(found) && is_of_launch(found.what))
    }

    /// How far a finding must move stops to be a gap. How a box leaves the tip by the angle at which it is met is
    /// the contact's own, which is modelled no better than that.
    fn least_of(&self, finding: &Finding) -> f64 {
        let is_of_contact = matches!(finding.what, What::Column(column) if column.is_of_launch());
        match self.is_box && is_of_contact && finding.covariate == "angle" {
            true => self.floor.max(self.resolved),
            false => little(self.floor, self.resolved),
        }
    }

    /// A finding left beside the effects so large that no name explains the gap: it moves stops by more than repeats scatter, and has more than half
    /// of the variance of the greatest finding `before`, or moves them by more than `great` times what repeats scatter; or that greatest finding
    /// itself, where half of its variance is left. A form that is nearly right leaves less.
    pub(crate) fn great_beside(&self, before: &Self, great: f64) -> Option<&Finding> {
        let greatest = before.findings.first();
        let half = greatest.map_or(0.0, |most| FRAC_1_SQRT_2 * most.size);
        let least = self.floor.max(half).min(great * self.floor);
        let is_same = |found: &&Finding| {
            let of = |most: &Finding| most.what == found.what && most.covariate == found.covariate;
            greatest.is_some_and(of) && found.size > half
        };
        let largest = self.findings.first();
        let largest = largest.filter(|found| found.size > least);
        largest.or_else(|| self.findings.iter().find(is_same))
    }

    /// Two groups of strikes, where nothing else moves stops by more.
    pub(crate) fn groups_above_all(&self) -> Option<&Finding> {
        self.findings
            .first()
            .filter(|found| found.covariate == GROUP)
    }

    /// A push that depends on the place on the table and moves stops by more than `least` (m); an object's own motion would show alike everywhere.
    pub(crate) fn push_by_place(&self, least: f64) -> Option<&Finding> {
        let is_push = |found: &&Finding| matches!(found.what, What::Along | What::Across);
        let by_place = |found: &&Finding| found.covariate == "position" && found.size > least;
        self.findings.iter().filter(is_push).find(by_place)
    }

    /// A push on the way of a round object, where nothing moves stops by more. A box may tip and turn in its own way.
    pub(crate) fn push_above_all(&self) -> Option<&Finding> {
        let is_push = |found: &&Finding| matches!(found.what, What::Along | What::Across);
        self.findings
            .first()
            .filter(is_push)
            .filter(|_| !self.is_box)
    }

    /// Whether objects are pushed by where they are, by more than repeats scatter.
    pub(crate) fn is_pushed_by_place(&self) -> bool {
        self.push_by_place(self.floor).is_some()
    }

    /// Whether something depends on the order in a form that an effect of the library has. Beside levels of the sessions, a drift changes in each.
    pub(crate) fn has_form_of_an_effect(&self, beside_sessions: bool) -> bool {
        self.findings.iter().any(|found| match found.form {
            Some(Form::WearInSessions) => beside_sessions,
            Some(Form::WanderAlone) | None => false,
            Some(_) => !found.has_no_name(),
        })
    }

    /// A finding that contradicts these effects by the order: it changes with the order in a form that the library lacks, by at least half as much as
    /// anything else does; or within a session where only sessions are said to differ.
    pub(crate) fn contradicts(&self, effects: EffectsByOrder) -> Option<&Finding> {
        let by_sessions_alone = effects.by_session && !effects.drift;
        let by_order = self.findings.iter().filter(|found| found.form.is_some());
        let most = by_order.map(|found| found.size).fold(0.0, f64::max);
        let is_other = |found: &&Finding| match found.form {
            Some(Form::StepInSession(_)) => by_sessions_alone,
            // Sessions of a wander differ, too.
            Some(Form::WanderAlone) => effects.by_session,
            Some(Form::DriftAndSessions) => {
                let is_of_launch = found.what == What::Column(Column::Launch);
                is_of_launch || !(effects.drift && effects.by_session)
            }
            // A change of level is a form of a drift, of friction's within one session.
            Some(Form::Ramp) => {
                let is_of_friction = found.what == What::Column(Column::Friction);
                by_sessions_alone || self.has_sessions && is_of_friction
            }
            _ => found.has_no_name() && 2.0 * found.size >= most,
        };
        self.findings
            .iter()
            .filter(|found| found.size > little(self.floor, self.resolved))
            .find(is_other)
    }
}

/// Tests what a fitted model leaves for dependence on commands, starts, places and order.
pub(crate) fn ask(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
    before: &[CameBefore],
    seed: u64,
) -> Answer {
    Asking::new(prepared, fitted, before, seed).answer()
}

/// How the stops of these strikes vary about a fitted model, of which this was answered.
pub(crate) fn variation(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
    answer: &Answer,
) -> Variation {
    let before = vec![CameBefore::default(); prepared.strikes.len()];
    let variation = Asking::new(prepared, fitted, &before, 0).variation(&answer.by_order);
    match answer.floor > 0.0 {
        true => Variation {
            repeats: variation
                .repeats
                .times(answer.floor / variation.repeats.value),
            ..variation
        },
        false => variation,
    }
}

/// What repeats scatter by (m), less what was found to move stops by this much and stands in it. What moves them by more than repeats scatter does not.
fn floor_beside(repeats: f64, unseen: f64) -> f64 {
    match unseen < repeats {
        true => (repeats * repeats - unseen * unseen)
            .max(LEAST_FLOOR * repeats * repeats)
            .sqrt(),
        false => repeats,
    }
}

/// Whether commands were repeated so often that what repeats scatter by is measured; otherwise it is what no smooth part takes.
pub(crate) fn has_repeats(prepared: &PreparedStrikes<'_>) -> bool {
    are_repeated(&commands(prepared))
}

fn are_repeated(commands: &[usize]) -> bool {
    let distinct = commands.iter().max().map_or(0, |last| last + 1);
    commands.len() - distinct >= components::REPEATS
}

/// Numbers of the sessions, by their first strikes.
pub(crate) fn sessions(prepared: &PreparedStrikes<'_>) -> Vec<usize> {
    let mut names: Vec<&str> = Vec::new();
    let each = prepared.strikes.iter().map(|strike| {
        let name = strike.conditions.session.as_str();
        names
            .iter()
            .position(|other| *other == name)
            .unwrap_or_else(|| {
                names.push(name);
                names.len() - 1
            })
    });
    each.collect()
}

/// The number of each strike.
fn numbers(prepared: &PreparedStrikes<'_>) -> DVector<f64> {
    let each = prepared.strikes.iter();
    let each = each.map(|strike| strike.conditions.order);
    DVector::from_iterator(prepared.strikes.len(), each)
}

/// Numbers of the commands, by their first strikes: repeats differ by less than `SAME` (m/s, rad).
fn commands(prepared: &PreparedStrikes<'_>) -> Vec<usize> {
    const SAME: f64 = 1e-3;
    let mut seen: Vec<Command> = Vec::new();
    let each = prepared.strikes.iter().map(|strike| {
        let own = strike.command;
        let is_same = |other: &Command| {
            (other.speed - own.speed).abs() < SAME && (other.angle - own.angle).abs() < SAME
        };
        seen.iter().position(is_same).unwrap_or_else(|| {
            seen.push(own);
            seen.len() - 1
        })
    });
    each.collect()
}

/// A question of a family.
struct Asked {
    what: What,
    covariate: &'static str,
    /// Whether smooth functions of commands were taken off.
    is_unsmooth: bool,
    statistic: Statistic,
    /// Sum of squared weights, by which a statistic is a mean square.
    weight: f64,
}

struct Asking {
    rows: Vec<Row>,
    covariates: Covariates,
    sessions: Vec<usize>,
    /// The number of each strike: strikes that take no part count.
    numbers: DVector<f64>,
    shuffles: Shuffles,
    wander: Wander,
    /// Where each is expected to slide.
    ways: Vec<ways::Way>,
    seed: u64,
    /// Numbers of the commands: those of repeats are the same.
    commands: Vec<usize>,
    /// Standard deviation of a resting place, in m.
    resting: f64,
    is_box: bool,
    /// Motion of stops, in m, that is none.
    resolved: f64,
}

impl Asking {
    fn new(
        prepared: &PreparedStrikes<'_>,
        fitted: &Fitted,
        before: &[CameBefore],
        seed: u64,
    ) -> Self {
        let rows = table(prepared, fitted);
        let resting = fitted.estimated.components.nuisance[3];
        let numbers = numbers(prepared);
        Self {
            covariates: Covariates::new(prepared, resting, before),
            sessions: sessions(prepared),
            wander: Wander::new(&numbers),
            numbers,
            shuffles: Shuffles::new(rows.len(), seed),
            ways: ways::commanded(&prepared.strikes, &rows),
            seed,
            commands: commands(prepared),
            is_box: !prepared.rig.object.shape().is_round(),
            resolved: prepared.resolved,
            resting,
            rows,
        }
    }

    fn variation(&self, by_order: &[(Column, Vec<DVector<f64>>)]) -> Variation {
        // How far an object slides depends on the order as its launch and its friction do.
        let of = |column| {
            let is_of = |other: &Column| (column == Column::Heading) == (*other == Column::Heading);
            let found: Vec<_> = by_order.iter().filter(|(of, _)| is_of(of)).collect();
            let functions = found.iter().flat_map(|(_, functions)| functions).cloned();
            self.components(column, &functions.collect::<Vec<_>>(), !found.is_empty())
        };
        let (stop, heading) = (of(Column::Stop), of(Column::Heading));
        let of = |part: fn(&Components) -> StandardDeviation| part(&stop).hypot(part(&heading));
        // A start and a stop are seen, each in two coordinates.
        let seen = StandardDeviation::known(2.0 * self.resting);
        // Few sessions leave their standard deviation open: nothing varies by more than all stops do.
        let total = self.total();
        Variation {
            repeats: of(|c| c.repeats).hypot(seen),
            wander: of(|c| c.wander).min(total),
            sessions: of(|c| c.sessions).min(total),
        }
    }

    /// By how much stops differ from the world's, root mean square in m. What pushes all strikes alike at the same part of their way is mostly
    /// taken up by launch and friction: it moves stops by no more than this shows beyond what repeats scatter by.
    fn total(&self) -> f64 {
        let square =
            |of| column_of(&self.rows, of).0.norm_squared() / self.rows.len().max(1) as f64;
        let squares: f64 = square(Column::Stop) + square(Column::Heading);
        self.moves(What::Column(Column::Stop)) * squares.sqrt()
    }

    fn answer(&self) -> Answer {
        let is_of_before = |asked: &Asked| BEFORE.contains(&asked.covariate);
        let (came_before, commands): (Vec<Asked>, Vec<Asked>) =
            self.commands().into_iter().partition(is_of_before);
        let [order, cycles] = self.order();
        let levels = self.levels();
        let mut findings = self.found(&commands);
        findings.extend(self.found(&came_before));
        findings.extend(self.found(&levels));
        let mut ordered = self.found(&order);
        ordered.extend(self.found(&cycles));
        let mut forms = Vec::new();
        let mut by_order = Vec::new();
        ordered.retain_mut(|finding| {
            let What::Column(column) = finding.what else {
                return true;
            };
            let known = forms.iter().find(|(of, _)| *of == column);
            let form = match known {
                Some((_, form)) => *form,
                None => {
                    let found = self.in_order(column);
                    let found = found.map(|(_, at)| at.form(&self.wander, self.seed));
                    let form = found.map(|(form, functions)| {
                        by_order.push((column, functions));
                        form
                    });
                    forms.push((column, form));
                    form
                }
            };
            finding.form = form;
            match form {
                Some(Form::Wander) => false,
                // A table's friction wanders; a tip that points elsewhere for some strikes is loose.
                Some(Form::WanderAlone) => column == Column::Heading,
                _ => true,
            }
        });
        by_order.extend(self.by_those_before(&findings));
        findings.extend(ordered);
        findings.extend(self.in_groups(&by_order));
        let total = self.total();
        for finding in &mut findings {
            finding.size = finding.size.min(total);
        }
        // What strikes share that no smooth function of commands holds, repeats do not scatter by; only repeats themselves show it apart. By
        // groups that nothing tells apart they do.
        let are_repeated = are_repeated(&self.commands);
        let is_unseen = |found: &&Finding| {
            found.is_unsmooth && !are_repeated && !BEFORE.contains(&found.covariate)
        };
        let unseen = findings.iter().filter(is_unseen).map(|found| found.size);
        let unseen = unseen.fold(0.0, f64::max);
        let repeats = self.variation(&by_order).repeats.value;
        let floor = floor_beside(repeats, unseen);
        let most = (total * total - floor * floor).max(0.0).sqrt();
        findings.retain_mut(|finding| {
            let is_of_all = finding.covariate == "phase";
            if is_of_all {
                finding.size = finding.size.min(most);
            }
            let is_great = finding.size > floor;
            is_great || !(is_of_all || finding.form == Some(Form::WanderAlone))
        });
        findings.sort_by(|a, b| b.size.total_cmp(&a.size));
        Answer {
            floor,
            findings,
            resolved: self.resolved,
            is_box: self.is_box,
            has_sessions: self.sessions.iter().any(|session| *session > 0),
            runs_with_order: self.runs_with_order(),
            by_order,
        }
    }

    /// Functions that hold what was found to depend on the strikes before.
    fn by_those_before(&self, findings: &[Finding]) -> Vec<(Column, Vec<DVector<f64>>)> {
        let found = findings.iter().filter_map(|found| match found.what {
            What::Column(of) if BEFORE.contains(&found.covariate) => Some((of, found.covariate)),
            _ => None,
        });
        let functions = found.flat_map(|(of, covariate)| {
            let scatter = self.weighed(of, true).scatter;
            let groups = self.covariates.groups(&self.rows, of as usize, scatter);
            let own = groups
                .into_iter()
                .filter(move |group| group.name == covariate);
            own.map(move |group| {
                let functions = group.functions.column_iter();
                // Of mean square 1.
                let scale = (group.functions.nrows() as f64).sqrt();
                (of, functions.map(|f| f * scale).collect())
            })
        });
        functions.collect()
    }

    /// The findings of a family that are significant at its share of the level.
    fn found(&self, family: &[Asked]) -> Vec<Finding> {
        let statistics: Vec<Statistic> =
            family.iter().map(|asked| asked.statistic.clone()).collect();
        let all: Calibrated = calibrated(&statistics);
        let mut found: Vec<Finding> = Vec::new();
        for (k, asked) in family.iter().enumerate() {
            if all.p_values[k] >= REAL / FAMILIES {
                continue;
            }
            let square =
                (asked.statistic[0] - all.by_chance[k]).max(0.0) / asked.weight.max(1e-300);
            let finding = Finding {
                what: asked.what,
                covariate: asked.covariate,
                p_value: (FAMILIES * all.p_values[k]).min(1.0),
                size: square.sqrt() * self.moves(asked.what),
                is_unsmooth: asked.is_unsmooth,
                form: None,
            };
            let same =
                |f: &&mut Finding| f.what == finding.what && f.covariate == finding.covariate;
            match found.iter_mut().find(same) {
                Some(other) if other.size >= finding.size => {}
                Some(other) => *other = finding,
                None => found.push(finding),
            }
        }
        found
    }

    /// By how much one unit moves a stop, root mean square, in m.
    fn moves(&self, what: What) -> f64 {
        let each = self.rows.iter().map(|row| match what {
            What::Column(Column::Launch) => row.gains[0] * row.slide,
            What::Column(Column::Friction) => row.gains[1] * row.slide,
            What::Column(Column::Heading | Column::Stop) => row.slide,
            What::Column(Column::Fade) => row.reach[0],
            What::Column(Column::Curve) | What::Along | What::Across => row.reach[1],
        });
        let squares: f64 = each.map(|moved| moved * moved).sum();
        (squares / self.rows.len().max(1) as f64).sqrt()
    }

    fn weighed(&self, of: Column, is_centred: bool) -> Weighed {
        let (values, errors) = column_of(&self.rows, of);
        let cells: Vec<Cell> = values
            .iter()
            .zip(&errors)
            .map(|(value, error)| Cell {
                value: *value,
                error: *error,
            })
            .collect();
        weighed(&cells, &self.sessions, is_centred)
    }

    /// Indicator columns: one of all strikes, and one of each session but the first.
    fn sessions(&self) -> Vec<DVector<f64>> {
        let n = self.rows.len();
        let count = self.sessions.iter().max().map_or(1, |last| last + 1);
        let is_in = |s: usize| DVector::from_fn(n, |i, _| f64::from(self.sessions[i] == s));
        std::iter::once(DVector::repeat(n, 1.0))
            .chain((1..count).map(is_in))
            .collect()
    }

    /// Wanders of a column beside its sessions and what is smooth over commands.
    fn beside_commands(&self, column: &Weighed) -> WanderBeside<'_> {
        let beside = self.sessions().into_iter().chain(self.covariates.smooth());
        let beside: Vec<DVector<f64>> = beside.map(|c| c.component_mul(&column.weights)).collect();
        self.wander.beside(&beside)
    }

    /// Variance ratio of the largest wander of a column that the strikes do not exclude.
    fn wander_of(&self, of: Column, column: &Weighed) -> f64 {
        match of {
            Column::Fade | Column::Curve => 0.0,
            Column::Launch | Column::Heading | Column::Friction | Column::Stop => {
                self.beside_commands(column).greatest(&column.values)
            }
        }
    }

    fn components(&self, of: Column, by_order: &[DVector<f64>], is_ordered: bool) -> Components {
        let column = self.weighed(of, true);
        let (raw, errors) = column_of(&self.rows, of);
        let slides = self.rows.iter().map(|row| row.slide);
        let measured = components::Measured {
            clipped: column.values.component_div(&column.weights),
            raw,
            errors,
            slides: DVector::from_iterator(self.rows.len(), slides),
            is_ordered,
        };
        components::components(
            &measured,
            &self.covariates.linear(),
            by_order,
            &self.sessions,
            &self.commands,
        )
    }

    fn commands(&self) -> Vec<Asked> {
        let mut asked = Vec::new();
        let unsmooth = Unsmooth {
            by_time: self.covariates.by_time(&self.sessions()),
            ripples: self.covariates.ripples(),
            ways: self.ways(),
            waves: ways::waves(&self.ways),
        };
        for of in COLUMNS {
            let column = self.weighed(of, true);
            let ratio = self.wander_of(of, &column);
            let whitened = |c: &DVector<f64>| {
                self.wander
                    .whitened(ratio, &c.component_mul(&column.weights))
            };
            let basis = Basis::new(self.sessions().iter().map(whitened));
            let left = basis.off(self.wander.whitened(ratio, &column.values));
            let all = self.shuffles.permuted(left.as_slice());
            let weight = column.weights.norm_squared();
            for group in self
                .covariates
                .groups(&self.rows, of as usize, column.scatter)
            {
                let functions: Vec<DVector<f64>> = group
                    .functions
                    .column_iter()
                    .map(|c| whitened(&c.into_owned()))
                    .collect();
                let questions = basis.beside(functions);
                if questions.is_empty() {
                    continue;
                }
                asked.push(Asked {
                    what: What::Column(of),
                    covariate: group.name,
                    is_unsmooth: BEFORE.contains(&group.name),
                    statistic: explained(&questions, &all),
                    weight,
                });
            }
            if NEEDS.contains(&of) {
                asked.extend(self.beside_smooth(of, &column, ratio, &unsmooth));
            }
        }
        let places: Vec<_> = self.rows.iter().map(|row| row.places).collect();
        for (what, pushes) in self.pushes() {
            for statistic in pushes.asked(&places, &self.shuffles) {
                asked.push(Asked {
                    what,
                    covariate: "position",
                    is_unsmooth: false,
                    statistic,
                    weight: pushes.weight,
                });
            }
        }
        asked
    }

    /// Asks about dependences that smooth functions of one or two commands do not explain.
    fn beside_smooth(
        &self,
        of: Column,
        column: &Weighed,
        ratio: f64,
        unsmooth: &Unsmooth,
    ) -> Vec<Asked> {
        let Unsmooth {
            by_time,
            ripples,
            ways,
            waves,
        } = unsmooth;
        let n = self.rows.len();
        let whitened = |c: &DVector<f64>| {
            self.wander
                .whitened(ratio, &c.component_mul(&column.weights))
        };
        let beside = self.sessions().into_iter().chain(self.covariates.smooth());
        let beside = beside.chain(self.covariates.products());
        let basis = Basis::new(beside.map(|c| whitened(&c)));
        if 3 * basis.0.len() > n {
            return Vec::new();
        }
        let left = basis.off(self.wander.whitened(ratio, &column.values));
        // Exchanged, what is left of n values beside p columns spreads over all n directions again, of which questions see the n − p others.
        let spread = (n as f64 / (n - basis.0.len()) as f64).sqrt();
        let mut all = self.shuffles.permuted(left.as_slice());
        all.columns_mut(1, PERMUTED).scale_mut(spread);
        let weight = column.weights.norm_squared();
        let changes = by_time
            .iter()
            .map(|(name, functions)| (*name, basis.beside(functions.iter().map(whitened))));
        // What places do to headings is asked of pushes.
        let is_braked = matches!(of, Column::Friction | Column::Stop);
        let places = ways.iter().filter(|_| is_braked).map(|root| {
            let root = root.iter().map(whitened).collect();
            ("position", ways::score(root, &basis, weight))
        });
        let most = |waves: &[Wave]| {
            let waves = waves.iter().map(|wave| wave.each_ref().map(whitened));
            ways::most_explained(waves, &basis, &all)
        };
        let waved = is_braked.then(|| most(waves));
        let rippled = ripples
            .iter()
            .map(|(name, waves)| Some((*name, most(waves)?)));
        changes
            .chain(places)
            .filter(|(_, questions)| !questions.is_empty())
            .map(|(covariate, questions)| (covariate, explained(&questions, &all)))
            .chain(waved.flatten().map(|waved| ("position", waved)))
            .chain(rippled.flatten())
            .map(|(covariate, statistic)| Asked {
                what: What::Column(of),
                covariate,
                is_unsmooth: true,
                statistic,
                weight,
            })
            .collect()
    }

    /// Roots of how much of their ways strikes share: in all sessions, and within each.
    fn ways(&self) -> Vec<Vec<DVector<f64>>> {
        let shared = ways::shared(&self.ways);
        let is_same = |i: usize, j: usize| self.sessions[i] == self.sessions[j];
        let mut within = shared.clone();
        for (at, each) in within.iter_mut().enumerate() {
            *each *= f64::from(is_same(at % shared.nrows(), at / shared.nrows()));
        }
        let covariances = match self.sessions.iter().any(|s| *s > 0) {
            true => vec![shared, within],
            false => vec![shared],
        };
        covariances.into_iter().map(ways::root).collect()
    }

    fn pushes(&self) -> [(What, Pushes); 2] {
        [
            (
                What::Along,
                Pushes::new(&self.rows, &self.sessions, |row| &row.along),
            ),
            (
                What::Across,
                Pushes::new(&self.rows, &self.sessions, |row| &row.across),
            ),
        ]
    }

    /// Whether commands or starts follow the order of strikes.
    fn runs_with_order(&self) -> bool {
        let n = self.rows.len();
        let place = DVector::from_fn(n, |i, _| (i as f64 + 0.5) / n as f64);
        let mean = Basis::new([DVector::repeat(n, 1.0)]);
        let slow = mean.beside(table::cosines(&place, 3));
        self.covariates.linear().into_iter().any(|command| {
            let command = mean.off(command);
            let shared: f64 = slow.iter().map(|q| q.dot(&command).powi(2)).sum();
            shared > RUNS_WITH_ORDER * command.norm_squared()
        })
    }

    /// A column without what depends on commands; they are left in where they run with the order.
    fn in_order(&self, of: Column) -> Option<(f64, InOrder)> {
        let column = self.weighed(of, true);
        let n = self.rows.len();
        let smooth = match self.runs_with_order() {
            true => Vec::new(),
            false => self.covariates.smooth(),
        };
        let beside = std::iter::once(DVector::repeat(n, 1.0)).chain(smooth);
        let beside = Basis::new(beside.map(|c| c.component_mul(&column.weights)));
        if beside.0.len() + 4 > n {
            return None;
        }
        let values = beside.off(column.values);
        Some((
            column.weights.norm_squared(),
            InOrder {
                of,
                values,
                weights: column.weights,
                beside,
                numbers: self.numbers.clone(),
                sessions: self.sessions.clone(),
            },
        ))
    }

    /// The questions about the order, and about cycles over it.
    fn order(&self) -> [Vec<Asked>; 2] {
        let mut both = [Vec::new(), Vec::new()];
        for of in NEEDS {
            let Some((weight, at)) = self.in_order(of) else {
                continue;
            };
            for (family, asked) in both.iter_mut().zip(at.asked(&self.shuffles)) {
                family.extend(asked.into_iter().map(|(covariate, statistic)| Asked {
                    what: What::Column(of),
                    covariate,
                    is_unsmooth: false,
                    statistic,
                    weight,
                }));
            }
        }
        both
    }

    /// The columns whose strikes fall into two groups, beside what depends on commands and order.
    fn in_groups(&self, by_order: &[(Column, Vec<DVector<f64>>)]) -> Vec<Finding> {
        let finding = |of: &Column| {
            let (weight, at) = self.in_order(*of)?;
            let found = by_order.iter().filter(|(other, _)| other == of);
            let found = found.flat_map(|(_, functions)| functions);
            let beside = at.beside.with(found.map(|f| f.component_mul(&at.weights)));
            let left = beside.off(at.values);
            let (ratio, _) = self.wander.beside(&beside.0).likeliest(&left);
            let values = left + self.weighed(*of, true).clipped;
            let groups = Groups::of(&values)?;
            let p_value = groups.p_value(&self.wander, ratio, &beside, self.seed);
            let what = What::Column(*of);
            let unit = (weight / values.len() as f64).sqrt();
            Some(Finding {
                what,
                covariate: GROUP,
                p_value: (FAMILIES * NEEDS.len() as f64 * p_value).min(1.0),
                size: groups.apart(&values) / unit * self.moves(what),
                is_unsmooth: false,
                form: None,
            })
        };
        let found = NEEDS.iter().filter_map(finding);
        found.filter(|found| found.p_value < REAL).collect()
    }

    fn levels(&self) -> Vec<Asked> {
        let mut asked = Vec::new();
        let signs = &self.shuffles.signs;
        // Σ over columns of (Σ over strikes)², as it is and with the signs of whole strikes flipped.
        let level = |columns: &[DVector<f64>]| {
            let mut statistic = vec![0.0; 1 + PERMUTED];
            for column in columns {
                statistic[0] += column.sum().powi(2) / column.len() as f64;
                let flipped = signs.tr_mul(column);
                for (to, sum) in statistic[1..].iter_mut().zip(flipped.iter()) {
                    *to += sum * sum / column.len() as f64;
                }
            }
            statistic
        };
        let heading = self.weighed(Column::Heading, false);
        // A walk as great as the strikes do not exclude would leave the first of them alone to show a level.
        let (ratio, _) = self.beside_commands(&heading).likeliest(&heading.values);
        let level_of_one = self.wander.whitened(ratio, &heading.weights);
        let level_of_one =
            &level_of_one / (level_of_one.norm() / (level_of_one.len() as f64).sqrt()).max(1e-300);
        let whitened = self
            .wander
            .whitened(ratio, &heading.values)
            .component_mul(&level_of_one);
        asked.push(Asked {
            what: What::Column(Column::Heading),
            covariate: "level",
            is_unsmooth: false,
            statistic: level(&[whitened]),
            weight: heading.weights.norm_squared(),
        });
        for (what, pushes) in self.pushes() {
            let fifth = |k: usize| {
                DVector::from_iterator(pushes.whole.len(), pushes.whole.iter().map(|row| row[k]))
            };
            let fifths: Vec<DVector<f64>> = (0..table::HATS).map(fifth).collect();
            asked.push(Asked {
                what,
                covariate: "phase",
                is_unsmooth: false,
                statistic: level(&fifths),
                weight: pushes.weight,
            });
        }
        asked
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(what: What, covariate: &'static str, size: f64, form: Option<Form>) -> Finding {
        Finding {
            what,
            covariate,
            p_value: 0.002,
            size,
            is_unsmooth: false,
            form,
        }
    }

    fn answer(finding: Finding) -> Answer {
        Answer {
            findings: vec![finding],
            floor: 0.004,
            ..Answer::default()
        }
    }

    #[test]
    fn what_a_box_s_launch_does_by_its_angle_is_a_gap_beyond_what_repeats_scatter_by() {
        let launch = What::Column(Column::Launch);
        let is_gap = |what, covariate, size, is_box| {
            let asked = answer(found(what, covariate, size, None));
            Answer { is_box, ..asked }.is_gap()
        };
        assert!(is_gap(launch, "angle", 0.003, false) && !is_gap(launch, "angle", 0.003, true));
        assert!(is_gap(launch, "angle", 0.005, true) && is_gap(launch, "speed", 0.003, true));
        assert!(is_gap(What::Column(Column::Friction), "angle", 0.003, true));
    }

    /// Whether a finding of this form contradicts effects by the order.
    fn contradicts(asked: Answer, effects: EffectsByOrder) -> bool {
        asked.contradicts(effects).is_some()
    }

    fn by_order(column: Column, size: f64, form: Form) -> Answer {
        answer(found(What::Column(column), "order", size, Some(form)))
    }

    #[test]
    fn a_floor_holds_nothing_that_was_found_in_it_and_loses_nothing_that_never_was() {
        assert!((floor_beside(5.0, 4.0) - 3.0).abs() < 1e-12);
        assert!((floor_beside(5.0, 4.99).powi(2) - 2.5).abs() < 1e-12);
        assert_eq!(floor_beside(2.2, 4.9), 2.2);
    }

    #[test]
    fn a_change_of_level_contradicts_friction_by_order_in_several_sessions_alone() {
        let contradicts = |column, has_sessions, by_session| {
            let asked = by_order(column, 0.01, Form::Ramp);
            let effects = EffectsByOrder {
                by_session,
                ..EffectsByOrder::default()
            };
            contradicts(
                Answer {
                    has_sessions,
                    ..asked
                },
                effects,
            )
        };
        assert!(contradicts(Column::Friction, true, false));
        assert!(!contradicts(Column::Friction, false, false));
        assert!(!contradicts(Column::Launch, true, false));
        assert!(contradicts(Column::Launch, true, true));
    }

    #[test]
    fn what_changes_within_sessions_contradicts_sessions_alone() {
        for form in [Form::StepInSession(20), Form::DriftAndSessions] {
            let asked = || by_order(Column::Friction, 0.01, form);
            let sessions = EffectsByOrder {
                by_session: true,
                drift: false,
            };
            let drift = true;
            assert!(contradicts(asked(), sessions));
            assert!(!contradicts(asked(), EffectsByOrder { drift, ..sessions }));
        }
    }

    #[test]
    fn a_launch_angle_that_drifts_contradicts_angles_by_session() {
        let sessions = EffectsByOrder {
            by_session: true,
            drift: false,
        };
        for form in [Form::Drift, Form::Wear] {
            assert!(contradicts(by_order(Column::Heading, 0.01, form), sessions));
        }
        assert!(!contradicts(
            by_order(Column::Heading, 0.01, Form::Sessions),
            sessions
        ));
    }

    #[test]
    fn launches_that_differ_by_session_contradict_what_changes_with_the_order() {
        for form in [Form::Sessions, Form::DriftAndSessions] {
            for by_session in [false, true] {
                let drift = true;
                let effects = EffectsByOrder { by_session, drift };
                assert!(contradicts(by_order(Column::Launch, 0.01, form), effects));
            }
            let both = EffectsByOrder {
                by_session: true,
                drift: true,
            };
            assert!(!contradicts(by_order(Column::Friction, 0.01, form), both));
        }
    }

    #[test]
    fn a_form_without_a_name_contradicts_where_it_is_not_little_beside_another() {
        let both = EffectsByOrder {
            by_session: true,
            drift: true,
        };
        let mut asked = by_order(Column::Friction, 0.01, Form::WearInSessions);
        assert!(contradicts(asked.clone(), both));
        let step = by_order(Column::Launch, 0.03, Form::Step(20));
        asked.findings.extend(step.findings);
        assert!(!contradicts(asked, both));
    }
}
