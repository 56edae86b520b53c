//! What is told beside a fit, each with the words that say it. Angles are in rad, lengths in m, each value with half of its 95 % interval.

#![expect(missing_docs, reason = "the words beside each say what it is")]

use derive_more::Display;
use serde::{Deserialize, Serialize};

/// What to look at on the rig, what the data cannot determine, and what a world does not model.
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
pub enum Note {
    #[display(
        "objects go as they were commanded to, and not as the arm's logged state says: it is wrong, or noisier than the arm errs. Launches were taken \
         as they were commanded; compare the state's speeds and angles with the commands"
    )]
    StateNotFollowed,
    #[display(
        "restitution is {value:.2} [{low:.2}, {high:.2}], which cannot be below 0: objects leave slower than the tip goes, as commanded or as its logged \
         state says. The arm delivers less (a speed override, a limit), the object is heavy beside what strikes it, or a unit or scale is wrong; what was \
         identified holds while that stays"
    )]
    NegativeRestitution { value: f64, low: f64, high: f64 },
    #[display("in {count} of {of} strikes the arm pushes the object on after the impact, or it speeds up again as if the arm or the table did: {}",
        if *are_left_out { "left out" } else { "kept, for they are most, or too few others are there" })]
    PushedAgain {
        count: usize,
        of: usize,
        are_left_out: bool,
    },
    #[display(
        "{count} of {of} strikes were left out of the identification: their tracks end more than five times as far off in it as the others scatter"
    )]
    Strays { count: usize, of: usize },
    #[display(
        "{slides} slides that no strike began teach alone: no strike tells whether they slid, or whether a hand carried what moved"
    )]
    SlidesAlone { slides: usize },
    #[display(
        "{slides} slides that no strike began are left out: {strikes} strikes are too few to tell whether they slid as the table brakes, or \
         whether a hand carried what moved"
    )]
    TooFewToJudgeSlides { slides: usize, strikes: usize },
    /// Decelerations in m/s²: of strikes, and from where to where those of slides agree with it.
    #[display("{} slides that no strike began are left out{}: strikes slide with a deceleration of {usual:.2} m/s², so that {:.2} to {:.2} is a \
         slide; they are taken for what a hand carried",
        if *are_all { format!("{of}") } else { format!("{} of {of}", of - agree) },
        if *are_all { format!(", {agree} of which agree with the strikes by chance") } else { String::new() },
        agreeing[0], agreeing[1])]
    CarriedByHand {
        agree: usize,
        of: usize,
        are_all: bool,
        usual: f64,
        agreeing: [f64; 2],
    },
    /// The rig file's sizes, and how far the ratio of the tip's radius to half a side is off, as a logarithm; an arm that does as much.
    #[display("the strikes want another size than the rig file's: object.half_size {}, or striker.radius {} (95 %, where the other is right); \
         measure both, correct the rig file and run again{}",
        sides(*half_sides, -ratio, *half), size(*radius, *ratio, *half),
        arm.map_or(String::new(), |by| format!("; an arm that strikes at {by:.2} times the commanded angle looks alike, and so does a box that is turned to each strike and whose yaw is not logged")))]
    WrongSizes {
        half_sides: [f64; 2],
        radius: f64,
        ratio: f64,
        half: f64,
        arm: Option<f64>,
    },
    #[display(
        "{name} ended at the bound of its range, {value:.4}: the model lacks something, or the rig file is off"
    )]
    AtBound { name: String, value: f64 },
    #[display("{of} scatters from strike to strike by as much as is allowed for, {}: the model lacks something",
        if let Scattering::Angle = of { format!("{:.0}°", bound.to_degrees()) } else { format!("{:.0} %", 100.0 * bound) })]
    ScatterAtBound { of: Scattering, bound: f64 },
    #[display("strikes leave {:.2}° ± {:.2}° beside their angles on average (commanded, or delivered where the arm's state is logged), which this \
         world does not model: an effect or a residual model has to", turn.to_degrees(), half.to_degrees())]
    Turned { turn: f64, half: f64 },
    #[display("these strikes say nothing of {}: kept as they were", _0.join(", "))]
    Blind(Vec<String>),
    #[display("these strikes do not distinguish {} from {}: kept as they were", kept.join(", "), freed.join(" and "))]
    Aliased {
        kept: Vec<String>,
        freed: Vec<String>,
    },
    #[display(
        "{name} was raised to {value:.2}: the strikes' bearings need a tip that holds the box at least so well"
    )]
    TipHolds { name: String, value: f64 },
    #[display("{slides} slides that no strike began teach friction beside {strikes} strikes")]
    SlidesTeach { slides: usize, strikes: usize },
}

/// What scatters from strike to strike.
#[derive(Clone, Copy, Debug, Display, Serialize, Deserialize)]
pub enum Scattering {
    #[display("launch speed")]
    Speed,
    #[display("launch angle")]
    Angle,
    #[display("friction")]
    Friction,
}

fn sides([x, y]: [f64; 2], ratio: f64, half: f64) -> String {
    match x == y {
        true => size(x, ratio, half),
        false => format!("{} and {}", size(x, ratio, half), size(y, ratio, half)),
    }
}

fn size(given: f64, ratio: f64, half: f64) -> String {
    let wanted = 1e3 * given * ratio.exp();
    format!(
        "{wanted:.1} ± {:.1} mm for {:.1} mm",
        wanted * half,
        1e3 * given
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_sizes_name_every_number_that_may_be_wrong() {
        let said = |half_sides| {
            let (radius, ratio) = (0.012, 1.1f64.ln());
            let note = Note::WrongSizes {
                half_sides,
                radius,
                ratio,
                half: 0.04,
                arm: None,
            };
            note.to_string()
        };
        let text = said([0.03, 0.03]);
        assert!(
            text.contains("object.half_size 27.3 ± 1.1 mm for 30.0 mm, or striker.radius 13.2 ± 0.5 mm for 12.0 mm"),
            "{text}"
        );
        assert!(!text.contains("arm"), "{text}");
        let text = said([0.03, 0.044]);
        assert!(
            text.contains("27.3 ± 1.1 mm for 30.0 mm and 40.0 ± 1.6 mm for 44.0 mm"),
            "{text}"
        );
    }
}
