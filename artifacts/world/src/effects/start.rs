//! Where fits of an effect begin.
//!
//! Near no effect most parameters act linearly. Those that do not (where a patch lies, how fast friction weakens) are tried
//! on a grid. Each point of it is a [`FitStart`]: a few columns (derivatives of every track by a parameter of strength),
//! whose coefficients a linear step finds, and how these coefficients become parameters.

use std::collections::{BTreeMap, BTreeSet};

use values::{Point, Rig, Strike};

use super::parameters::Parameters;

/// Distance that a place may lie beyond the strikes, as a share of their extent: one far away is a slope by another name.
const BEYOND: f64 = 0.25;

/// Standard deviation of commanded angles (rad) below which all strikes go one way.
const ONE_WAY: f64 = 0.02;

/// Frames that a cell must hold for an effect to be tried there ([`FitStart::at_places`]).
const FRAMES: usize = 12;

/// The strikes that an effect is looked for in.
#[derive(Clone, Copy)]
pub struct Experiment<'a> {
    /// The rig.
    pub rig: &'a Rig,
    /// Its strikes.
    pub strikes: &'a [&'a Strike],
}

/// A small amount of an effect.
#[derive(Clone, Debug)]
pub struct Column {
    /// Parameters of form.
    pub form: Vec<(String, f64)>,
    /// The parameter of strength, and a small value of it.
    pub strength: (String, f64),
    /// Where it acts on the table, if not everywhere: middle and radius in m.
    pub region: Option<(Point, f64)>,
    /// Whether its strength is held at its value, not scaled by a coefficient.
    pub is_kept: bool,
}

/// Parameters from the coefficients of a start's columns, where these are not the columns' own strengths.
pub type Combine = fn(&FitStart, &[f64]) -> Vec<(String, f64)>;

/// Where one fit begins: columns that are tried together.
#[derive(Clone, Debug)]
pub struct FitStart {
    /// The columns.
    pub columns: Vec<Column>,
    /// How their coefficients become parameters, beyond scaling each column's strength.
    pub combine: Option<Combine>,
    /// Parameters that a fit from here frees.
    pub free: Vec<String>,
    /// Ranges that a fit keeps them in, where narrower than the effect's own.
    pub within: BTreeMap<String, (f64, f64)>,
    /// Standard deviation about neutral that its strengths are drawn towards, for an effect of many; none: free.
    pub shrinks_to: Option<f64>,
}

impl Column {
    /// A column of this strength everywhere, with these parameters of form.
    pub fn new(form: &[(&str, f64)], strength: (&str, f64)) -> Self {
        Self {
            form: form.iter().map(|(n, v)| (n.to_string(), *v)).collect(),
            strength: (strength.0.to_string(), strength.1),
            region: None,
            is_kept: false,
        }
    }

    /// A parameter of form; 0 where it has none of that name.
    pub fn form_of(&self, name: &str) -> f64 {
        let found = self.form.iter().find(|(known, _)| known == name);
        found.map_or(0.0, |(_, value)| *value)
    }
}

impl FitStart {
    /// A start with these columns, which frees these parameters.
    pub fn new(columns: Vec<Column>, free: &[&str]) -> Self {
        Self {
            columns,
            combine: None,
            free: free.iter().map(|name| name.to_string()).collect(),
            within: BTreeMap::new(),
            shrinks_to: None,
        }
    }

    /// The one start of an effect that acts linearly in one parameter, with a small value of it.
    pub fn linear(strength: (&str, f64)) -> Vec<Self> {
        vec![Self::new(vec![Column::new(&[], strength)], &[strength.0])]
    }

    /// The one start of an effect that has a parameter of one kind for each of several names: a column each, in which all others are 0, for one that
    /// is left out would have their mean.
    pub fn each(names: &[&str], strength: f64) -> Vec<Self> {
        let column = |name: &&str| {
            let others = names.iter().filter(|other| *other != name);
            let none: Vec<(&str, f64)> = others.map(|other| (*other, 0.0)).collect();
            Column::new(&none, (*name, strength))
        };
        vec![Self::new(names.iter().map(column).collect(), names)]
    }

    /// A start that is linear in the strength of an effect that goes one way, its strength kept between none and `most`.
    pub fn linear_up_to(strength: (&str, f64), most: f64) -> Vec<Self> {
        let starts = Self::linear(strength).into_iter();
        starts
            .map(|start| start.kept_in(strength.0, (0.0, most)))
            .collect()
    }

    /// This start, with `combine` making parameters of its columns' coefficients.
    pub fn combined_by(mut self, combine: Combine) -> Self {
        self.combine = Some(combine);
        self
    }

    /// Starts about the places that strikes went over, `cell` (m) apart, of each of these reaches (m): an effect that `center_x`, `center_y` and
    /// `reach` place, a column for each of its strengths.
    pub fn at_places(
        experiment: &Experiment<'_>,
        cell: f64,
        reaches: &[f64],
        strengths: &[(&str, f64)],
    ) -> Vec<Self> {
        let strong = strengths.iter().map(|(name, _)| *name);
        let free: Vec<&str> = ["center_x", "center_y", "reach"]
            .into_iter()
            .chain(strong)
            .collect();
        let start = |centre: Point, reach: f64| {
            let form = [
                ("center_x", centre.x),
                ("center_y", centre.y),
                ("reach", reach),
            ];
            let columns = strengths
                .iter()
                .map(|strength| Column::new(&form, *strength));
            Self::new(columns.collect(), &free).about(experiment)
        };
        let cells = experiment.cells(cell, FRAMES).into_iter();
        cells
            .flat_map(|centre| reaches.iter().map(move |reach| (centre, *reach)))
            .map(|(centre, reach)| start(centre, reach))
            .collect()
    }

    /// This start, its parameters `center_x` and `center_y` kept about where strikes went.
    pub fn about(mut self, experiment: &Experiment<'_>) -> Self {
        let [x, y] = experiment.extent();
        for (name, (low, high)) in [("center_x", x), ("center_y", y)] {
            let beyond = BEYOND * (high - low);
            self.within
                .insert(name.into(), (low - beyond, high + beyond));
        }
        self
    }

    /// This start, a parameter kept in `range`: an effect that goes the other way has another name.
    pub fn kept_in(mut self, parameter: &str, range: (f64, f64)) -> Self {
        self.within.insert(parameter.into(), range);
        self
    }

    /// For each column, whether its strength is held.
    pub fn is_kept(&self) -> Vec<bool> {
        self.columns.iter().map(|column| column.is_kept).collect()
    }

    /// Names of the columns' strengths, held ones left out.
    pub fn strengths(&self) -> Vec<String> {
        let free = self.columns.iter().filter(|column| !column.is_kept);
        free.map(|column| column.strength.0.clone()).collect()
    }

    /// Range of a parameter in a fit from here.
    pub fn range(&self, parameters: &Parameters, parameter: &str) -> (f64, f64) {
        let own = parameters.get(parameter);
        self.within.get(parameter).copied().unwrap_or_else(|| {
            own.map_or((f64::NEG_INFINITY, f64::INFINITY), |own| {
                (own.low, own.high)
            })
        })
    }

    /// Values of the effect's parameters at which a fit begins, given the coefficients of the columns.
    pub fn parameters(
        &self,
        parameters: &Parameters,
        coefficients: &[f64],
    ) -> BTreeMap<String, f64> {
        // A column may hold still what another one changes.
        let forms = self.columns.iter().flat_map(|column| &column.form);
        let mut values: BTreeMap<String, f64> = forms.cloned().collect();
        for (column, coefficient) in self.columns.iter().zip(coefficients) {
            let (strength, value) = &column.strength;
            let neutral = parameters.get(strength).map_or(0.0, |own| own.neutral);
            let scaled = if column.is_kept {
                *value
            } else {
                neutral + coefficient * (value - neutral)
            };
            values.insert(strength.clone(), scaled);
        }
        if let Some(combine) = self.combine {
            values.extend(combine(self, coefficients));
        }
        for (parameter, value) in &mut values {
            let (low, high) = self.range(parameters, parameter);
            *value = value.clamp(low, high);
        }
        values
    }
}

impl Experiment<'_> {
    /// The point that the camera looks down on, as parameters of form.
    pub fn camera_centre(&self) -> [(&'static str, f64); 2] {
        let centre = self.rig.camera.centre;
        [("center_x", centre.x), ("center_y", centre.y)]
    }

    /// The middle of the starts, and their standard deviation along x and y, in m.
    pub fn starts(&self) -> (Point, Point) {
        let share = 1.0 / self.strikes.len().max(1) as f64;
        let starts = || self.strikes.iter().map(|strike| strike.initial);
        let middle = starts().fold(Point::default(), |sum, start| sum + start * share);
        let squares = starts().fold(Point::default(), |sum, start| {
            let off = start - middle;
            sum + Point::new(off.x * off.x, off.y * off.y) * share
        });
        (middle, Point::new(squares.x.sqrt(), squares.y.sqrt()))
    }

    /// Least and greatest x and y in m of all that was seen.
    pub fn extent(&self) -> [(f64, f64); 2] {
        let points = || {
            self.strikes.iter().flat_map(|strike| {
                let track = (0..strike.track.len()).map(|i| strike.track.point(i));
                track.chain([strike.initial])
            })
        };
        [(|p: Point| p.x) as fn(Point) -> f64, |p: Point| p.y].map(|along| {
            points()
                .map(along)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                    (low.min(v), high.max(v))
                })
        })
    }

    /// Whether all strikes go one way, so that a force across it does not tell what it acts by.
    pub fn is_one_way(&self) -> bool {
        let angles = self.strikes.iter().map(|strike| strike.command.angle);
        let count = self.strikes.len().max(1) as f64;
        let mean = angles.clone().sum::<f64>() / count;
        let variance = angles.map(|angle| (angle - mean).powi(2)).sum::<f64>() / count;
        variance < ONE_WAY * ONE_WAY
    }

    /// Middles of the cells of this width (m) in which at least so many frames were seen.
    pub fn cells(&self, width: f64, frames: usize) -> Vec<Point> {
        let mut counts: BTreeMap<(i64, i64), usize> = BTreeMap::new();
        for strike in self.strikes {
            for i in 0..strike.track.len() {
                let p = strike.track.point(i);
                let cell = ((p.x / width).floor() as i64, (p.y / width).floor() as i64);
                *counts.entry(cell).or_default() += 1;
            }
        }
        counts
            .into_iter()
            .filter(|(_, count)| *count >= frames)
            .map(|((i, j), _)| Point::new((i as f64 + 0.5) * width, (j as f64 + 0.5) * width))
            .collect()
    }

    /// The speed in m/s at this share of the commanded ones, in their order; 0 where there are no strikes.
    pub fn speed_at(&self, share: f64) -> f64 {
        let mut speeds: Vec<f64> = self.strikes.iter().map(|s| s.command.speed).collect();
        speeds.sort_by(f64::total_cmp);
        let place = (speeds.len().saturating_sub(1) as f64 * share) as usize;
        speeds.get(place).copied().unwrap_or(0.0)
    }

    /// Names of the sessions, in their order; strikes without one count for none.
    pub fn sessions(&self) -> Vec<&str> {
        let names: BTreeSet<&str> = self
            .strikes
            .iter()
            .map(|strike| strike.conditions.session.as_str())
            .filter(|name| !name.is_empty())
            .collect();
        names.into_iter().collect()
    }

    /// Strikes from the first to the last, those between that take no part counted too.
    pub fn span(&self) -> f64 {
        let orders = self.strikes.iter().map(|s| s.conditions.order);
        let (low, high) = orders.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        (high - low).max(0.0)
    }
}
