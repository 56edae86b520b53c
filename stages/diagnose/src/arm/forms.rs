//! The forms that the arm's laws may have: the library's effects of the striker.

use std::f64::consts::TAU;

use values::{Command, Conditions, Strike};
use world::effects::library;

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

    /// As a covariate.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Angle => "angle",
        }
    }

    /// Of a command: m/s, or rad.
    pub(super) fn of(self, command: Command) -> f64 {
        match self {
            Self::Speed => command.speed,
            Self::Angle => command.angle,
        }
    }
}

/// One strike: what was commanded, what was delivered, and when.
pub(super) struct Pair<'a> {
    pub(super) command: Command,
    pub(super) delivered: Command,
    pub(super) conditions: &'a Conditions,
}

/// One form that a law may have, and where its fits begin.
pub(super) struct Form {
    pub(super) name: &'static str,
    pub(super) free: Vec<String>,
    pub(super) starts: Vec<Vec<f64>>,
}

impl<'a> Pair<'a> {
    /// Those of the strikes whose delivered launch is known.
    pub(super) fn all(strikes: &[&'a Strike]) -> Vec<Self> {
        let each = strikes.iter().filter_map(|strike| {
            Some(Self {
                command: strike.command,
                delivered: strike.delivered?.command(),
                conditions: &strike.conditions,
            })
        });
        each.collect()
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

/// The forms that the library has for a law, on these strikes.
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
