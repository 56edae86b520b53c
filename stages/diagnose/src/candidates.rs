//! The candidates: for each effect of the library, where a search for it starts.
//!
//! Near no effect most parameters act linearly. Those that do not (where a patch lies, how fast friction weakens) are tried on
//! a grid; each grid point is a set of columns, the derivatives of every track by the parameters of strength.

use std::collections::{BTreeMap, BTreeSet};

use values::{Point, Rig, Strike};

use crate::model::{Part, specification};

/// A small amount of an effect: parameters of form, and one of strength.
#[derive(Clone, Debug)]
pub(crate) struct Column {
    pub(crate) form: Vec<(String, f64)>,
    pub(crate) strength: (String, f64),
    /// Where it acts on the table, if not everywhere: middle and radius in m.
    pub(crate) region: Option<(Point, f64)>,
    /// Whether it acts all or nothing: its strength stays as it is.
    pub(crate) is_kept: bool,
}

/// How coefficients of a bundle's columns become parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Join {
    /// Each column's strength, times its coefficient.
    Scale,
    /// A sum of paraboloids is one.
    Bowl,
    /// Grains along x and along the diagonal make one in between.
    Grain,
    /// A cap at a commanded speed and an offset: min(v, knee) + offset is min(v + offset, knee + offset).
    Knee,
}

/// Columns that are tried together.
#[derive(Clone, Debug)]
pub(crate) struct Bundle {
    pub(crate) columns: Vec<Column>,
    pub(crate) join: Join,
    /// Parameters that a fit from here frees.
    pub(crate) free: Vec<String>,
    /// Ranges that a fit keeps them in, where narrower than the library's.
    pub(crate) within: BTreeMap<String, (f64, f64)>,
}

/// One effect.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub(crate) name: &'static str,
    pub(crate) bundles: Vec<Bundle>,
}

impl Column {
    fn new(form: &[(&str, f64)], strength: (&str, f64)) -> Self {
        Self {
            form: form.iter().map(|(n, v)| (n.to_string(), *v)).collect(),
            strength: (strength.0.to_string(), strength.1),
            region: None,
            is_kept: false,
        }
    }

    /// The effect with this column's parameters.
    pub(crate) fn part(&self, name: &'static str) -> Part {
        Part {
            name,
            parameters: self.form.iter().chain([&self.strength]).cloned().collect(),
            free: Vec::new(),
            strengths: Vec::new(),
            within: BTreeMap::new(),
        }
    }
}

impl Bundle {
    fn new(columns: Vec<Column>, free: &[&str]) -> Self {
        Self {
            columns,
            join: Join::Scale,
            free: free.iter().map(|name| name.to_string()).collect(),
            within: BTreeMap::new(),
        }
    }

    /// Its middle stays about where strikes went: one far away is a slope by another name.
    fn about(mut self, strikes: &[&Strike]) -> Self {
        let points = || {
            strikes.iter().flat_map(|strike| {
                let track = (0..strike.track.len()).map(|i| strike.track.point(i));
                track.chain([strike.initial])
            })
        };
        for (name, along) in [
            ("center_x", (|p: Point| p.x) as fn(Point) -> f64),
            ("center_y", |p: Point| p.y),
        ] {
            let (low, high) = points()
                .map(along)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                    (l.min(v), h.max(v))
                });
            let beyond = BEYOND * (high - low);
            self.within
                .insert(name.into(), (low - beyond, high + beyond));
        }
        self
    }

    /// Which of its columns act all or nothing.
    pub(crate) fn is_kept(&self) -> Vec<bool> {
        self.columns.iter().map(|column| column.is_kept).collect()
    }

    /// Where a fit starts, given the coefficients of the columns.
    pub(crate) fn start(&self, name: &'static str, coefficients: &[f64]) -> Part {
        let mut parameters = BTreeMap::new();
        for (column, coefficient) in self.columns.iter().zip(coefficients) {
            parameters.extend(column.form.iter().cloned());
            let (strength, value) = &column.strength;
            let neutral = specification(name, strength).neutral;
            let scaled = if column.is_kept {
                *value
            } else {
                neutral + coefficient * (value - neutral)
            };
            parameters.insert(strength.clone(), scaled);
        }
        let strength = |i: usize| coefficients[i] * self.columns[i].strength.1;
        match self.join {
            Join::Scale => {}
            Join::Bowl => {
                let total: f64 = (0..self.columns.len()).map(strength).sum();
                let safe = if total.abs() < 1e-6 { 1e-6 } else { total };
                for place in ["center_x", "center_y"] {
                    let moment: f64 = self
                        .columns
                        .iter()
                        .enumerate()
                        .map(|(i, column)| {
                            let at = column.form.iter().find(|(n, _)| n == place);
                            strength(i) * at.map_or(0.0, |(_, v)| *v)
                        })
                        .sum();
                    parameters.insert(place.into(), moment / safe);
                }
                parameters.insert("curvature".into(), total);
            }
            Join::Knee => {
                parameters.insert("cap".into(), self.columns[0].strength.1 + strength(1));
            }
            Join::Grain => {
                let (along, diagonal) = (strength(0), strength(1));
                parameters.insert("contrast".into(), along.hypot(diagonal));
                parameters.insert("direction".into(), 0.5 * diagonal.atan2(along));
            }
        }
        for (parameter, value) in &mut parameters {
            let spec = specification(name, parameter);
            let (low, high) = self
                .within
                .get(parameter)
                .copied()
                .unwrap_or((spec.low, spec.high));
            *value = value.clamp(low, high);
        }
        Part {
            name,
            parameters,
            free: self.free.clone(),
            strengths: self
                .columns
                .iter()
                .filter(|column| !column.is_kept)
                .map(|column| column.strength.0.clone())
                .collect(),
            within: self.within.clone(),
        }
    }
}

/// How far a middle may lie beyond the strikes, as a share of their extent.
const BEYOND: f64 = 0.25;

/// Width in m of the cells on which patches are tried, and their radii.
const CELL: f64 = 0.05;
const RADII: [f64; 3] = [0.04, 0.08, 0.14];
/// Frames that a cell must hold to be tried.
const FRAMES: usize = 12;

/// Middles of the cells that tracks pass.
pub(crate) fn cells(strikes: &[&Strike], width: f64, frames: usize) -> Vec<Point> {
    let mut counts: BTreeMap<(i64, i64), usize> = BTreeMap::new();
    for strike in strikes {
        for i in 0..strike.track.len() {
            let p = strike.track.point(i);
            *counts
                .entry(((p.x / width).floor() as i64, (p.y / width).floor() as i64))
                .or_default() += 1;
        }
    }
    counts
        .into_iter()
        .filter(|(_, count)| *count >= frames)
        .map(|((i, j), _)| Point::new((i as f64 + 0.5) * width, (j as f64 + 0.5) * width))
        .collect()
}

fn patches(rig: &Rig, strikes: &[&Strike]) -> Vec<Bundle> {
    let reach = rig.object.radius.unwrap_or_else(|| {
        let [x, y, _] = rig.object.half_size.unwrap_or_default();
        x.hypot(y)
    });
    let within = Bundle::new(Vec::new(), &[]).about(strikes).within;
    let mut bundles = Vec::new();
    for centre in cells(strikes, CELL, FRAMES) {
        for radius in RADII {
            let mut column = Column::new(
                &[
                    ("center_x", centre.x),
                    ("center_y", centre.y),
                    ("radius", radius),
                ],
                ("change", 0.1),
            );
            column.region = Some((centre, radius + reach));
            let mut bundle =
                Bundle::new(vec![column], &["center_x", "center_y", "radius", "change"]);
            bundle.within = within.clone();
            bundles.push(bundle);
        }
    }
    bundles
}

fn sessions(strikes: &[&Strike]) -> Vec<Bundle> {
    let names: BTreeSet<&str> = strikes
        .iter()
        .map(|strike| strike.conditions.session.as_str())
        .filter(|name| !name.is_empty())
        .collect();
    if names.len() < 2 {
        return Vec::new();
    }
    let free: Vec<&str> = names.iter().copied().collect();
    // One session is the friction that all have: the columns of the others tell the differences.
    let columns = free[1..]
        .iter()
        .map(|name| Column::new(&[], (name, 0.02)))
        .collect();
    vec![Bundle::new(columns, &free[1..])]
}

/// The speed at this share of the commanded ones.
fn speed_at(strikes: &[&Strike], share: f64) -> f64 {
    let mut speeds: Vec<f64> = strikes.iter().map(|s| s.command.speed).collect();
    speeds.sort_by(f64::total_cmp);
    speeds[((speeds.len() - 1) as f64 * share) as usize]
}

/// Shares of the commanded speeds at which a cap is tried: a start a little beside it shows none of its sharp bend.
const CAPS: [f64; 8] = [0.3, 0.45, 0.58, 0.68, 0.76, 0.84, 0.9, 0.95];

fn speed_errors(strikes: &[&Strike]) -> Vec<Bundle> {
    // The slope is restitution's by another name.
    let offset = || Column::new(&[], ("offset", 0.01));
    let mut bundles = vec![Bundle::new(vec![offset()], &["offset"])];
    for share in CAPS {
        let mut cap = Column::new(&[], ("cap", speed_at(strikes, share)));
        cap.is_kept = true;
        bundles.push(Bundle::new(vec![cap.clone()], &["cap"]));
        let mut knee = Bundle::new(vec![cap, offset()], &["cap", "offset"]);
        knee.join = Join::Knee;
        bundles.push(knee);
    }
    bundles
}

/// All candidates of the library for these strikes.
pub(crate) fn candidates(rig: &Rig, strikes: &[&Strike]) -> Vec<Candidate> {
    let one = |name, strength: (&str, f64)| Candidate {
        name,
        bundles: vec![Bundle::new(vec![Column::new(&[], strength)], &[strength.0])],
    };
    let mut bowl = Bundle::new(
        [(0.0, 0.0), (0.5, 0.0), (0.0, 0.5)]
            .iter()
            .map(|(x, y)| Column::new(&[("center_x", *x), ("center_y", *y)], ("curvature", 0.02)))
            .collect(),
        &["curvature", "center_x", "center_y"],
    )
    .about(strikes);
    bowl.join = Join::Bowl;
    let mut grain = Bundle::new(
        [0.0, std::f64::consts::FRAC_PI_4]
            .iter()
            .map(|direction| Column::new(&[("direction", *direction)], ("contrast", 0.03)))
            .collect(),
        &["contrast", "direction"],
    );
    grain.join = Join::Grain;
    let weakening = [0.1, 0.2, 0.35, 0.6, 1.0]
        .iter()
        .map(|speed| {
            Bundle::new(
                vec![Column::new(&[("speed", *speed)], ("rise", 0.05))],
                &["rise", "speed"],
            )
        })
        .collect();
    let many = |name, bundles| Candidate { name, bundles };
    let tilt = Bundle::new(
        vec![
            Column::new(&[], ("tilt_x", 0.002)),
            Column::new(&[], ("tilt_y", 0.002)),
        ],
        &["tilt_x", "tilt_y"],
    );
    vec![
        one("viscous_drag", ("rate", 0.05)),
        one("quadratic_drag", ("coefficient", 0.05)),
        many("speed_weakening_friction", weakening),
        many("anisotropic_friction", vec![grain]),
        many("friction_patch", patches(rig, strikes)),
        one("friction_drift", ("rate", 0.02)),
        many("friction_by_session", sessions(strikes)),
        many("table_tilt", vec![tilt]),
        many("table_bowl", vec![bowl]),
        many("striker_speed_error", speed_errors(strikes)),
        one("striker_angle_bias", ("bias", 0.005)),
        one("speed_dependent_restitution", ("slope", 0.05)),
        one("off_centre_contact", ("offset", 0.0005)),
        one("camera_rotation", ("angle", 0.005)),
        one("camera_distortion", ("k1", 0.02)),
    ]
    .into_iter()
    .filter(|candidate| {
        world::effects::effect(candidate.name).is_ok() && !candidate.bundles.is_empty()
    })
    .collect()
}
