//! The forms that the arm's laws may have: the library's effects of the striker, by what was commanded and by where the object lay.

use std::f64::consts::TAU;

use values::{Command, Conditions, Delivered, Point, Rig, Strike};
use world::WorldError;
use world::effects::{AddedEffect, Effect, Experiment, Origin, build, deliver, effect, library};

/// Shares of the delivered speeds at which a fit of a cap begins; the last ones over the fastest.
const CAPS: [f64; 6] = [0.6, 0.75, 0.85, 0.95, 1.05, 1.4];

/// The quantity of the launch that a law predicts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Quantity {
    Speed,
    Angle,
}

impl Quantity {
    pub(super) const ALL: [Self; 2] = [Self::Speed, Self::Angle];
}

/// One strike: what was commanded, what was delivered, and when.
pub(super) struct Pair<'a> {
    pub(super) command: Command,
    pub(super) delivered: Command,
    /// Where the object lay, in m.
    pub(super) from: Point,
    pub(super) conditions: &'a Conditions,
}

/// One form that a law may have, and where its fits begin.
#[derive(Clone)]
pub(super) struct Form {
    pub(super) name: &'static str,
    pub(super) free: Vec<String>,
    /// Parameters that are fixed, and their values.
    pub(super) fixed: Vec<(String, f64)>,
    pub(super) starts: Vec<Vec<f64>>,
}

impl<'a> Pair<'a> {
    /// A pair for each of these strikes whose delivered launch is known.
    pub(super) fn all(strikes: &[&'a Strike]) -> Vec<Self> {
        let each = strikes
            .iter()
            .map(|strike| Self::of(strike, strike.delivered));
        each.flatten().collect()
    }

    /// The pair of a strike; none where what it delivered is not known.
    pub(super) fn of(strike: &'a Strike, delivered: Option<Delivered>) -> Option<Self> {
        Some(Self {
            command: strike.command,
            delivered: delivered?.command(),
            from: strike.initial,
            conditions: &strike.conditions,
        })
    }

    /// This pair with the command that `effects`, which act before the law, make of the commanded one.
    pub(super) fn beside(&self, effects: &[Box<dyn Effect>]) -> Self {
        Self {
            command: deliver(effects, self.command, self.from, self.conditions),
            ..*self
        }
    }

    /// This pair with what `effects`, which act after the law, do to a command removed from what was delivered.
    pub(super) fn less(&self, effects: &[Box<dyn Effect>]) -> Self {
        let with = self.beside(effects).command;
        Self {
            delivered: Command {
                speed: self.delivered.speed * self.command.speed / with.speed.max(1e-9),
                angle: self.delivered.angle - (with.angle - self.command.angle),
            },
            ..*self
        }
    }

    /// Delivered less predicted: speed relative to the command's, or angle in rad.
    pub(super) fn difference(&self, quantity: Quantity, predicted: Command) -> f64 {
        match quantity {
            Quantity::Speed => {
                (self.delivered.speed - predicted.speed) / self.command.speed.max(1e-9)
            }
            Quantity::Angle => {
                let error = self.delivered.angle - predicted.angle;
                error - TAU * (error / TAU).round()
            }
        }
    }
}

/// An arm's errors by where the object lies.
pub(super) const BY_PLACE: &str = "striker_error_by_place";

/// The forms that the library has for a law by place, on these strikes: those of its starts that are of this quantity alone, with a constant
/// and without.
pub(super) fn forms_by_place(quantity: Quantity, rig: &Rig, strikes: &[&Strike]) -> Vec<Form> {
    let Ok(spec) = effect(BY_PLACE) else {
        return Vec::new();
    };
    let (prefix, constant) = match quantity {
        Quantity::Speed => ("speed_", "gain"),
        Quantity::Angle => ("angle_", "bias"),
    };
    let mut forms = Vec::new();
    for start in (spec.starts)(&Experiment { rig, strikes }) {
        let (slopes, others): (Vec<String>, Vec<String>) = start
            .free
            .into_iter()
            .partition(|name| name.starts_with(prefix));
        if slopes.is_empty() || others.iter().any(|name| name != constant) {
            continue;
        }
        let form = start.columns.into_iter().next().map(|column| column.form);
        let (begun, fixed): (Vec<_>, Vec<_>) = form
            .unwrap_or_default()
            .into_iter()
            .partition(|(name, _)| slopes.contains(name));
        let with_constant = [slopes.clone(), vec![constant.into()]].concat();
        for free in [slopes, with_constant] {
            let begins = free.iter().map(|name| {
                let begun = begun.iter().find(|(of, _)| of == name);
                begun.map_or(0.0, |(_, value)| *value)
            });
            forms.push(Form {
                name: spec.name,
                starts: vec![begins.collect()],
                fixed: fixed.clone(),
                free,
            });
        }
    }
    forms
}

/// The forms of the arm's effects that are written out neither in [`forms`] nor in [`forms_by_place`]: what each of their starts frees, where that
/// changes this quantity alone.
pub(super) fn forms_of_others(
    quantity: Quantity,
    rig: &Rig,
    strikes: &[&Strike],
) -> Result<Vec<Form>, WorldError> {
    const WRITTEN_OUT: [&str; 4] = [
        "striker_speed_error",
        "striker_angle_bias",
        "striker_angle_error",
        BY_PLACE,
    ];
    let is_other = |name| !WRITTEN_OUT.contains(&name);
    let pairs = Pair::all(strikes);
    let mut forms = Vec::new();
    for spec in library().filter(|spec| spec.origin == Origin::Arm && is_other(spec.name)) {
        for start in (spec.starts)(&Experiment { rig, strikes }) {
            let values = start.parameters(&spec.parameters, &vec![1.0; start.columns.len()]);
            let given: Vec<(&str, f64)> = values.iter().map(|(n, v)| (n.as_str(), *v)).collect();
            let effect = build(&AddedEffect::fixed(spec.name, &given), rig)?;
            let changes = |quantity| {
                pairs.iter().any(|pair| {
                    let by = effect.deliver(pair.command, pair.from, pair.conditions);
                    match quantity {
                        Quantity::Speed => by.speed != pair.command.speed,
                        Quantity::Angle => by.angle != pair.command.angle,
                    }
                })
            };
            if Quantity::ALL
                .iter()
                .any(|each| changes(*each) != (*each == quantity))
            {
                continue;
            }
            let begun = |name: &String| {
                let neutral = spec.parameter(name).map_or(0.0, |own| own.neutral);
                values.get(name).copied().unwrap_or(neutral)
            };
            let fixed = values.iter().filter(|(name, _)| !start.free.contains(name));
            forms.push(Form {
                name: spec.name,
                starts: vec![start.free.iter().map(begun).collect()],
                fixed: fixed.map(|(name, value)| (name.clone(), *value)).collect(),
                free: start.free,
            });
        }
    }
    Ok(forms)
}

/// The forms that the library has for a law by what was commanded, on these strikes.
pub(super) fn forms(quantity: Quantity, pairs: &[Pair<'_>]) -> Vec<Form> {
    let find = |name: &str| library().find(|spec| spec.name == name);
    let mut forms = Vec::new();
    let mut add = |name: &str, free: &[&str], starts: Vec<Vec<f64>>| {
        if let Some(spec) = find(name)
            && free
                .iter()
                .all(|parameter| spec.parameter(parameter).is_some())
        {
            forms.push(Form {
                name: spec.name,
                free: free.iter().map(|parameter| (*parameter).into()).collect(),
                fixed: Vec::new(),
                starts,
            });
        }
    };
    match quantity {
        Quantity::Speed => {
            let name = "striker_speed_error";
            for free in [&["slope"][..], &["offset"], &["offset", "slope"]] {
                let start = free.iter().map(|p| if *p == "slope" { 1.0 } else { 0.0 });
                add(name, free, vec![start.collect()]);
            }
            let fastest = pairs.iter().map(|p| p.delivered.speed).fold(0.0, f64::max);
            for free in [
                &["cap"][..],
                &["cap", "slope"],
                &["cap", "offset", "slope"],
                &["cap", "slope", "softness"],
            ] {
                let start = |cap: f64| {
                    let value = |parameter: &&str| match *parameter {
                        "cap" => cap,
                        "slope" => 1.0,
                        "softness" => 0.3,
                        _ => 0.0,
                    };
                    free.iter().map(value).collect()
                };
                add(
                    name,
                    free,
                    CAPS.map(|share| start(share * fastest)).to_vec(),
                );
            }
        }
        Quantity::Angle => {
            add("striker_angle_bias", &["bias"], vec![vec![0.0]]);
            for free in [
                &["bias", "gain"][..],
                &["bias", "slope"],
                &["bias", "gain", "slope"],
            ] {
                add("striker_angle_error", free, vec![vec![0.0; free.len()]]);
            }
            let mut sessions: Vec<&str> = pairs
                .iter()
                .map(|p| p.conditions.session.as_str())
                .collect();
            sessions.sort_unstable();
            sessions.dedup();
            if sessions.len() > 1 {
                let none = vec![0.0; sessions.len()];
                add("striker_angle_by_session", &sessions, vec![none]);
            }
        }
    }
    forms
}
