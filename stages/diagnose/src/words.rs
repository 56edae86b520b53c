//! What the smooth dependences say, in words.

use crate::{
    diagnosis::Where,
    evidence::REAL,
    smooth::{Covariate, Dependence},
};

impl Covariate {
    /// Its name in `diagnosis.json`.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Surface => "surface",
            Self::SlidingSpeed => "sliding_speed",
            Self::Phase => "phase",
            Self::Speed => "speed",
            Self::Angle => "angle",
            Self::Order => "order",
        }
    }
}

fn launch(d: &Dependence) -> String {
    format!(
        "{:+.1} % of speed and {:+.1}° of angle",
        100.0 * d.peak.x,
        d.peak.y.to_degrees()
    )
}

fn description(d: &Dependence) -> String {
    let here = format!("({:.2}, {:.2}) m", d.at.x, d.at.y);
    let slower = if d.peak.x > 0.0 {
        "slowed more"
    } else {
        "slowed less"
    };
    match d.covariate {
        Covariate::Position => format!(
            "the object is pushed by up to {:.2} m/s² towards {:.0}°, around {here}",
            d.peak.norm(),
            d.peak.bearing().to_degrees()
        ),
        Covariate::Surface => format!(
            "the object is {slower}, by up to {:.2} m/s², around {here}",
            d.peak.norm()
        ),
        Covariate::SlidingSpeed => format!(
            "the object is {slower}, by up to {:.2} m/s², when it slides at {:.2} m/s",
            d.peak.norm(),
            d.at.x
        ),
        Covariate::Phase => format!(
            "the object is pushed by up to {:.2} m/s² towards {:.0}°, {:.2} s after the blow",
            d.peak.norm(),
            d.peak.bearing().to_degrees(),
            d.at.x
        ),
        Covariate::Speed => format!(
            "launches are off by {} at a commanded {:.2} m/s",
            launch(d),
            d.at.x
        ),
        Covariate::Angle => format!(
            "launches are off by {} at a commanded {:.0}°",
            launch(d),
            d.at.x.to_degrees()
        ),
        Covariate::Order => format!("launches are off by {} at strike {:.0}", launch(d), d.at.x),
    }
}

/// The dependences that are no chance, the strongest first.
pub(crate) fn r#where(dependences: &[Dependence]) -> Vec<Where> {
    let looks = dependences.len() as f64;
    let mut real: Vec<&Dependence> = dependences
        .iter()
        .filter(|d| d.p_value * looks < REAL)
        .collect();
    real.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let all: f64 = real.iter().map(|d| d.gain).sum();
    real.into_iter()
        .map(|d| Where {
            covariate: d.covariate.name().into(),
            description: description(d),
            p_value: (d.p_value * looks).min(1.0),
            share: d.gain / all,
        })
        .collect()
}
