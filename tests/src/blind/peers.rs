//! What else one could do with the same strikes: free every parameter, or sweep each effect over end points alone.
//!
//! Cheap forms of both, in the planar world: least squares in which every strike weighs the same and launches do not scatter, as
//! the paper and common practice have it. The third peer, a sparse regression on accelerations, is `tests/peers/sindy.py`.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use values::{Point, Rig, Split, Strike};
use world::effects::{self, Effect};
use world::launch::{Launch, launches};
use world::planar::{Kick, Planar, Shot, gyration};
use world::{AddedEffect, Estimate, World};

use super::cases::{Case, Kind};
use super::hide;
use super::outcome::strikes;

/// What the peers make of a set.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Peers {
    /// The set.
    pub id: String,
    /// Held-out strikes, and their rms stop error in m with every parameter freed; none where the set cannot be fitted.
    pub freed: Option<(usize, f64)>,
    /// The effect that BIC prefers over end points; none where it prefers none.
    pub swept: Option<String>,
    /// The terms that the regression keeps beside friction, the largest first.
    pub regressed: Option<Vec<String>>,
}

/// The tracks of a set, as `sindy.py` reads them.
#[derive(Serialize)]
struct Tracks<'s> {
    id: &'s str,
    tracks: Vec<&'s values::Track>,
    order: Vec<f64>,
    session: Vec<usize>,
}

/// Friction, restitution and a turn common to all launches (rad).
const BASE: usize = 3;
/// Where they start, steps of differences, and ranges.
const START: [f64; BASE] = [0.25, 0.5, 0.0];
const STEP: [f64; BASE] = [0.002, 0.01, 0.003];
const RANGE: [(f64, f64); BASE] = [(0.03, 1.0), (-0.3, 0.95), (-0.4, 0.4)];
const ITERATIONS: usize = 10;

/// Values of an effect's parameters, by name.
type Begin = &'static [(&'static str, f64)];

/// Where a sweep of each effect begins; it fits all parameters that are listed.
const SWEPT: &[(&str, &[Begin])] = &[
    ("viscous_drag", &[&[("rate", 0.2)]]),
    ("quadratic_drag", &[&[("coefficient", 0.2)]]),
    (
        "speed_weakening_friction",
        &[
            &[("rise", 0.2), ("speed", 0.2)],
            &[("rise", 0.2), ("speed", 0.5)],
        ],
    ),
    (
        "anisotropic_friction",
        &[
            &[("contrast", 0.05), ("direction", 0.0)],
            &[("contrast", 0.05), ("direction", 0.8)],
            &[("contrast", 0.05), ("direction", -0.8)],
        ],
    ),
    (
        "friction_patch",
        &[
            &[
                ("center_x", 0.45),
                ("center_y", -0.08),
                ("radius", 0.08),
                ("change", 0.1),
            ],
            &[
                ("center_x", 0.45),
                ("center_y", 0.08),
                ("radius", 0.08),
                ("change", 0.1),
            ],
            &[
                ("center_x", 0.55),
                ("center_y", -0.08),
                ("radius", 0.08),
                ("change", 0.1),
            ],
            &[
                ("center_x", 0.55),
                ("center_y", 0.08),
                ("radius", 0.08),
                ("change", 0.1),
            ],
        ],
    ),
    ("friction_drift", &[&[("rate", 0.05)]]),
    ("table_tilt", &[&[("tilt_x", 0.001), ("tilt_y", 0.001)]]),
    (
        "table_bowl",
        &[
            &[("curvature", 0.02), ("center_x", 0.45), ("center_y", 0.0)],
            &[("curvature", -0.02), ("center_x", 0.45), ("center_y", 0.0)],
        ],
    ),
    (
        "striker_speed_error",
        &[&[("offset", -0.02)], &[("offset", 0.0), ("cap", 0.8)]],
    ),
    ("striker_angle_bias", &[&[("bias", 0.01)]]),
    ("speed_dependent_restitution", &[&[("slope", 0.1)]]),
    ("off_centre_contact", &[&[("offset", 0.001)]]),
    ("camera_rotation", &[&[("angle", 0.01)]]),
    ("camera_distortion", &[&[("k1", 0.05)]]),
];

struct Bench<'s> {
    rig: &'s Rig,
    strikes: Vec<(&'s Strike, Launch)>,
}

/// A fit: values, sum of squares, residuals' number.
struct Fitted {
    values: Vec<f64>,
    square: f64,
}

/// An effect with free parameters beside the base.
struct Candidate {
    name: String,
    parameters: Vec<(String, f64)>,
}

impl Candidate {
    fn effects(&self, rig: &Rig, values: &[f64]) -> Option<Vec<Box<dyn Effect>>> {
        if self.name.is_empty() {
            return Some(Vec::new());
        }
        let parameters: BTreeMap<String, Estimate> = self
            .parameters
            .iter()
            .zip(values)
            .map(|((name, _), value)| (name.clone(), Estimate::fixed(*value)))
            .collect();
        let name = self.name.clone();
        Some(vec![
            effects::build(&AddedEffect { name, parameters }, rig).ok()?,
        ])
    }

    /// Range and scale of its parameters.
    fn ranges(&self) -> Vec<(f64, f64, f64)> {
        let spec = effects::effect(&self.name);
        self.parameters
            .iter()
            .filter_map(|(name, _)| spec.as_ref().ok()?.parameter(name))
            .map(|p| (p.low, p.high, p.scale))
            .collect()
    }
}

impl Bench<'_> {
    /// Residuals of stops, or of all frames, in m.
    fn residuals(
        &self,
        candidate: &Candidate,
        values: &[f64],
        whole: bool,
    ) -> Option<DVector<f64>> {
        let (base, own) = values.split_at(BASE);
        let effects = candidate.effects(self.rig, own)?;
        let planar = Planar::of(
            [base[0], base[1]],
            world::Base::of(&self.rig.object),
            gyration(self.rig),
            &effects,
        );
        let kick = Kick {
            angle: base[2],
            delay: 0.5 / self.rig.camera.rate,
            ..Kick::default()
        };
        let mut all = Vec::new();
        for (strike, launch) in &self.strikes {
            let times = if whole { &strike.track.t[..] } else { &[] };
            let shot = Shot {
                times,
                ..Shot::from(*strike)
            };
            let frames = planar.strike(&shot, launch, &kick)?;
            let mut add = |a: Point, b: Point| all.extend([a.x - b.x, a.y - b.y]);
            for (i, at) in frames.at.iter().enumerate() {
                add(strike.track.point(i), *at);
            }
            add(strike.stop, frames.stop);
        }
        Some(all.into())
    }

    /// Levenberg and Marquardt from a candidate's start.
    fn fit(&self, candidate: &Candidate, is_turned: bool, whole: bool) -> Option<Fitted> {
        let own = candidate.ranges();
        let mut values: Vec<f64> = START.to_vec();
        values.extend(candidate.parameters.iter().map(|(_, value)| *value));
        let ranges: Vec<(f64, f64)> = RANGE
            .into_iter()
            .chain(own.iter().map(|(low, high, _)| (*low, *high)))
            .collect();
        let steps: Vec<f64> = STEP
            .into_iter()
            .chain(own.iter().map(|(_, _, scale)| 0.05 * scale))
            .collect();
        let free: Vec<usize> = (0..values.len()).filter(|i| is_turned || *i != 2).collect();
        let mut residual = self.residuals(candidate, &values, whole)?;
        let mut damping = 1e-3;
        for _ in 0..ITERATIONS {
            let mut slopes = DMatrix::zeros(residual.len(), free.len());
            for (column, i) in free.iter().enumerate() {
                let mut beside = values.clone();
                let step = if beside[*i] + steps[*i] > ranges[*i].1 {
                    -steps[*i]
                } else {
                    steps[*i]
                };
                beside[*i] += step;
                let there = self.residuals(candidate, &beside, whole)?;
                slopes.set_column(column, &((there - &residual) / step));
            }
            let mut normal = slopes.tr_mul(&slopes);
            for i in 0..free.len() {
                normal[(i, i)] *= 1.0 + damping;
            }
            let by = normal.cholesky()?.solve(&slopes.tr_mul(&residual));
            let mut trial = values.clone();
            for (column, i) in free.iter().enumerate() {
                trial[*i] = (trial[*i] - by[column]).clamp(ranges[*i].0, ranges[*i].1);
            }
            match self.residuals(candidate, &trial, whole) {
                Some(there) if there.norm_squared() < residual.norm_squared() => {
                    let gained = 1.0 - there.norm_squared() / residual.norm_squared();
                    (values, residual) = (trial, there);
                    damping *= 0.2;
                    if gained < 1e-5 {
                        break;
                    }
                }
                _ => damping = (damping * 10.0).max(1e-2),
            }
        }
        Some(Fitted {
            square: residual.norm_squared(),
            values,
        })
    }

    /// The effect that BIC prefers over end points.
    fn swept(&self, by_session: &[Candidate]) -> Option<String> {
        let rows = 2.0 * self.strikes.len() as f64;
        let bic = |fitted: &Fitted, freed: usize| {
            rows * (fitted.square / rows).ln() + freed as f64 * rows.ln()
        };
        let null = Candidate {
            name: String::new(),
            parameters: Vec::new(),
        };
        let mut best = (bic(&self.fit(&null, false, false)?, 2), None);
        let listed = SWEPT.iter().flat_map(|(name, starts)| {
            starts.iter().map(|start| Candidate {
                name: name.to_string(),
                parameters: start.iter().map(|(n, v)| (n.to_string(), *v)).collect(),
            })
        });
        for candidate in listed.collect::<Vec<_>>().iter().chain(by_session) {
            let Some(fitted) = self.fit(candidate, false, false) else {
                continue;
            };
            let found = bic(&fitted, 2 + candidate.parameters.len());
            if found < best.0 {
                best = (found, Some(candidate.name.clone()));
            }
        }
        best.1
    }

    /// Held-out strikes and their rms stop error with all freed that a round object's tracks depend on: friction, restitution,
    /// drag of the air, a turn of all launches.
    fn freed(&self, judges: &Bench<'_>) -> Option<(usize, f64)> {
        let candidate = Candidate {
            name: "quadratic_drag".into(),
            parameters: vec![("coefficient".into(), 0.01)],
        };
        let fitted = self.fit(&candidate, true, true)?;
        let left = judges.residuals(&candidate, &fitted.values, false)?;
        let count = judges.strikes.len();
        Some((count, (left.norm_squared() / count.max(1) as f64).sqrt()))
    }
}

/// Sets that the peers are tried on: plain controls, and single effects at twice the floor and more.
pub fn is_for_peers(case: &Case) -> bool {
    match case.kind {
        Kind::Control => case.variant == "plain",
        Kind::Single => case.magnitude >= 2.0 && !case.is_box(),
        Kind::Pair | Kind::Foreign => false,
    }
}

/// What the peers make of a set, and a line for `sindy.py`.
pub fn peers(case: &Case) -> (Peers, Option<String>) {
    let mut found = Peers {
        id: case.id.clone(),
        freed: None,
        swept: None,
        regressed: None,
    };
    let tracks = fill(case, &mut found);
    (found, tracks)
}

fn fill(case: &Case, found: &mut Peers) -> Option<String> {
    let folder = tempfile::tempdir().ok()?;
    let truth = hide::truth(case)?;
    let (rig, all) = strikes(&truth, case.strikes, None, folder.path())?;
    let world = World::nominal(&rig);
    let commands: Vec<_> = all.iter().map(|strike| strike.command).collect();
    let launched: Vec<(&Strike, Launch)> = all
        .iter()
        .zip(launches(&rig, &world, &commands).ok()?)
        .filter_map(|(strike, launch)| Some((strike, launch?)))
        .collect();
    let (judging, learning) = launched
        .into_iter()
        .partition(|(s, _)| s.split == Split::Test);
    let bench = Bench {
        rig: &rig,
        strikes: learning,
    };
    let judges = Bench {
        rig: &rig,
        strikes: judging,
    };
    let mut sessions: Vec<&str> = all.iter().map(|s| s.conditions.session.as_str()).collect();
    sessions.dedup();
    let others = || sessions.iter().skip(1).map(|name| (name.to_string(), 0.0));
    let by_session = (sessions.len() > 1).then(|| Candidate {
        name: "friction_by_session".into(),
        parameters: others().collect(),
    });
    let learn: Vec<&Strike> = bench.strikes.iter().map(|(strike, _)| *strike).collect();
    let tracks = Tracks {
        id: &case.id,
        tracks: learn.iter().map(|strike| &strike.track).collect(),
        order: learn.iter().map(|strike| strike.conditions.order).collect(),
        session: learn
            .iter()
            .map(|s| {
                sessions
                    .iter()
                    .position(|name| *name == s.conditions.session)
                    .unwrap_or(0)
            })
            .collect(),
    };
    found.freed = bench.freed(&judges);
    found.swept = bench.swept(by_session.as_slice());
    serde_json::to_string(&tracks).ok()
}
