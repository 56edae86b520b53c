//! Verdict and findings in words.

use crate::{
    diagnosis::{GapDependence, NamedEffect, Verdict},
    evidence::PValue,
    question::{Answer, Column, Finding, Form, What},
    score::{DRAWN, FLIPPED},
};

/// A finding of the question in a sentence.
pub(crate) fn finding(finding: &Finding) -> String {
    let what = match finding.what {
        What::Column(Column::Launch) => "the launch speed",
        What::Column(Column::Heading) => "the launch angle",
        What::Column(Column::Friction) => "friction",
        What::Column(Column::Stop) => "how far objects slide",
        What::Column(Column::Fade) => "friction from the beginning of the way to its end",
        What::Column(Column::Curve) => "a push across the way",
        What::Along => "a push along the way",
        What::Across => "a push across the way",
    };
    let by = match (finding.covariate, finding.form) {
        ("order", Some(Form::Step(at) | Form::StepInSession(at))) => {
            format!("steps after strike {at} of those that were looked at")
        }
        ("order" | "session", Some(form)) => {
            format!("depends on the order of strikes ({})", form.name())
        }
        ("level", _) => "is off in all strikes".into(),
        ("phase", _) => "is there in all strikes".into(),
        ("start", _) => "depends on where strikes start".into(),
        ("position", _) => "depends on the place on the table".into(),
        ("command", _) => "depends on speed, angle and start together".into(),
        ("command and order", _) => {
            "depends on speed, angle or start otherwise as strikes go on".into()
        }
        ("command and session", _) => {
            "depends on speed, angle or start otherwise in one session than in another".into()
        }
        ("speed", _) => "depends on the commanded speed".into(),
        ("angle", _) => "depends on the commanded angle".into(),
        ("command before", _) => "depends on the command of the strike before".into(),
        ("group", _) => "falls into two groups of strikes, which nothing that was logged tells apart (two objects, a tip or a focus that rests in one \
             of two states)"
            .into(),
        ("pause", _) => "depends on the pause before a strike".into(),
        (covariate, _) => format!("depends on the {covariate}"),
    };
    format!(
        "{what} {by}, which moves stops by {:.1} mm",
        1e3 * finding.size
    )
}

/// What the question found, the largest first: of each covariate, the finding that moves stops most.
pub(crate) fn found(answer: &Answer) -> Vec<GapDependence> {
    let mut first: Vec<&Finding> = Vec::new();
    for found in &answer.findings {
        if first.iter().all(|other| other.covariate != found.covariate) {
            first.push(found);
        }
    }
    let all: f64 = first.iter().map(|found| found.size.powi(2)).sum();
    let dependence = |found: &&Finding| GapDependence {
        covariate: found.covariate.into(),
        description: finding(found),
        p_value: found.p_value,
        share: found.size.powi(2) / all.max(f64::MIN_POSITIVE),
    };
    first.iter().map(dependence).collect()
}

/// Both probabilities, as far as the replicates can show them.
pub(crate) fn p_value(p: PValue) -> String {
    let one = |p: f64, replicates: usize| {
        let least = 1.0 / (1 + replicates) as f64;
        match p {
            p if p <= least => format!("p < 1/{replicates}"),
            p if p < 0.01 => format!("p = {p:.3}"),
            p => format!("p = {p:.2}"),
        }
    };
    format!(
        "{} by drawn noise, {} by flipped signs",
        one(p.drawn, DRAWN),
        one(p.flipped, FLIPPED)
    )
}

/// The verdict in a sentence; `cause` is what stands behind a gap that no candidate explains.
pub(crate) fn summary(
    verdict: Verdict,
    named: &[NamedEffect],
    p_value: PValue,
    cause: Option<&str>,
) -> String {
    match verdict {
        Verdict::Consistent if p_value.is_real() => format!(
            "no gap at rest: tracks differ from the world's beyond noise ({}), but nothing by command or place moves stops by more than they scatter",
            self::p_value(p_value)
        ),
        Verdict::Consistent if p_value.is_real_as_drawn() => format!(
            "no gap beyond noise ({}: strikes differ from noise as it was drawn, not from their own scatter); see `detectable` for the least that would have shown",
            self::p_value(p_value)
        ),
        Verdict::Consistent => format!(
            "no gap beyond noise ({}); see `detectable` for the least that would have shown",
            self::p_value(p_value)
        ),
        Verdict::Unexplained => unexplained(cause),
        Verdict::Named => {
            let statements: Vec<String> = named.iter().map(stated).collect();
            statements.join(", and ")
        }
    }
}

/// What an effect does, with all that may as well stand in its place.
fn stated(effect: &NamedEffect) -> String {
    match effect.equivalent.as_slice() {
        [] => effect.statement.clone(),
        alike => format!(
            "{} ({} is one name of several: {} would fit these strikes as well)",
            effect.statement,
            effect.name,
            alike.join(" or ")
        ),
    }
}

/// A gap that no candidate explains, with what stands behind it.
pub(crate) fn unexplained(cause: Option<&str>) -> String {
    let cause = cause.map_or(String::new(), |cause| format!(": {cause}"));
    format!("a real gap that no candidate explains{cause}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_stated_with_all_that_fit_as_well() {
        let effect = NamedEffect {
            name: "table_tilt".into(),
            parameters: Default::default(),
            statement: "the table slopes".into(),
            evidence: 9.0,
            equivalent: vec!["anisotropic_friction".into(), "a draught".into()],
            rivals: Vec::new(),
        };
        let alone = NamedEffect {
            equivalent: Vec::new(),
            ..effect.clone()
        };
        assert_eq!(stated(&alone), "the table slopes");
        let several = stated(&effect);
        assert!(several.contains("table_tilt is one name of several"));
        assert!(several.contains("anisotropic_friction or a draught"));
    }

    #[test]
    fn a_probability_is_stated_no_smaller_than_its_replicates_show() {
        let least = PValue {
            drawn: 1.0 / (1 + DRAWN) as f64,
            flipped: 1.0 / (1 + FLIPPED) as f64,
        };
        let text = p_value(least);
        let bounds: Vec<f64> = text
            .split("1/")
            .skip(1)
            .map(|rest| {
                let number = rest.split_whitespace().next().expect("a number");
                1.0 / number.parse::<f64>().expect("replicates")
            })
            .collect();
        assert!(
            least.drawn < bounds[0] && least.flipped < bounds[1],
            "{text}"
        );
    }
}
