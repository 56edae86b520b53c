//! Whether two rig files describe the same set-up.

use std::collections::BTreeSet;

use serde_json::Value;
use values::Rig;

/// Two rig files that do not describe one set-up. Its text stands after a colon.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "this is not the rig that the artifact was made for: {}; use its own artifact, or calibrate this rig",
    differences.join(", ")
)]
pub struct OtherRig {
    /// What differs, such as `[object] mass is 0.1 in the artifact, 0.2 here`.
    pub differences: Vec<String>,
}

/// Whether a robot's own rig file is that of the artifact, or stricter: same object and striker; table and limits of the
/// arm the same or within the artifact's. Camera and topics may differ: they say how a strike is seen and logged.
pub fn check(artifact: &Rig, own: &Rig) -> Result<(), OtherRig> {
    compare(artifact, own, |theirs, ours| is_within(ours, theirs))
}

/// Whether what is planned for one rig file may be struck in another: that one's table and arm allow all that the plan's do.
pub fn allows(planned: &Rig, there: &Rig) -> Result<(), OtherRig> {
    compare(planned, there, is_within)
}

/// What a camera needs to know of the object, and where the arm stands and may go: every plan keeps to this robot's own, and no
/// artifact depends on it.
const OWN: [(&str, &str); 10] = [
    ("object", "colour"),
    ("robot", "base"),
    ("robot", "keep_out"),
    ("robot", "reach"),
    ("robot", "jerk"),
    ("robot", "travel_height"),
    ("robot", "tool_orientation"),
    ("robot", "tool_offset"),
    ("robot", "payload"),
    ("robot", "obstacles"),
];

/// Differences of two rigs in what a strike depends on; `may_differ` says which limits may.
fn compare(
    artifact: &Rig,
    here: &Rig,
    may_differ: impl Fn(&Value, &Value) -> bool,
) -> Result<(), OtherRig> {
    let (theirs, ours) = (sections(artifact), sections(here));
    let mut differences = Vec::new();
    for (section, is_limit) in [
        ("object", false),
        ("striker", false),
        ("table", true),
        ("robot", true),
    ] {
        let keys = |rig: &Value| rig[section].as_object().cloned().unwrap_or_default();
        let names: BTreeSet<String> = [&theirs, &ours]
            .into_iter()
            .flat_map(|rig| keys(rig).into_iter().map(|(name, _)| name))
            .collect();
        for name in names {
            if OWN.contains(&(section, name.as_str())) {
                continue;
            }
            let (theirs, ours) = (&theirs[section][&name], &ours[section][&name]);
            if theirs == ours || (is_limit && may_differ(theirs, ours)) {
                continue;
            }
            let text = |value: &Value| match value {
                Value::Null => "none".to_owned(),
                value => value.to_string(),
            };
            differences.push(format!(
                "[{section}] {name} is {} in the artifact, {} here",
                text(theirs),
                text(ours)
            ));
        }
    }
    if differences.is_empty() {
        Ok(())
    } else {
        Err(OtherRig { differences })
    }
}

fn sections(rig: &Rig) -> Value {
    serde_json::to_value(rig).unwrap_or_default()
}

/// Whether an interval lies within another, or a number is no larger than another.
fn is_within(inner: &Value, outer: &Value) -> bool {
    let ends = |value: &Value| match value {
        Value::Array(ends) => Some((ends.first()?.as_f64()?, ends.get(1)?.as_f64()?)),
        value => Some((0.0, value.as_f64()?)),
    };
    match (ends(inner), ends(outer)) {
        (Some((low, high)), Some((lowest, highest))) => lowest <= low && high <= highest,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use values::Shape;

    #[test]
    fn a_rig_is_known_by_what_a_strike_depends_on() {
        let rig = Rig::demo(Shape::Cylinder);
        let mut seen_otherwise = rig.clone();
        seen_otherwise.camera.rate = 30.0;
        assert_eq!(check(&rig, &seen_otherwise), Ok(()));

        let mut heavier = rig.clone();
        heavier.object.mass = 0.2;
        heavier.robot.speed.high = 1.1;
        let text = check(&rig, &heavier).expect_err("differs").to_string();
        assert!(
            text.contains("[object] mass is 0.1 in the artifact, 0.2 here"),
            "{text}"
        );
        assert!(
            text.contains("[robot] speed is [0.4,1.0] in the artifact, [0.4,1.1] here"),
            "{text}"
        );
    }

    /// Limits, which may be stricter. Everything else in these sections makes another rig.
    const LIMITS: [&str; 5] = [
        "table.x",
        "table.y",
        "robot.speed",
        "robot.angle",
        "robot.acceleration",
    ];

    /// A value changed in every way that leaves its kind: those within it, and those that reach beyond it.
    fn changes(value: &Value) -> (Vec<Value>, Vec<Value>) {
        let numbers = |value: &Value| -> Option<Vec<f64>> {
            value.as_array()?.iter().map(Value::as_f64).collect()
        };
        if let Some(number) = value.as_f64() {
            return (vec![(0.9 * number).into()], vec![(1.1 * number).into()]);
        }
        match numbers(value).as_deref() {
            Some([low, high]) => {
                let step = 0.1 * (high - low);
                let within = [[low + step, *high], [*low, high - step]];
                let beyond = [[low - step, *high], [*low, high + step]];
                let values = |ends: [[f64; 2]; 2]| ends.map(|ends| ends.to_vec().into()).to_vec();
                (values(within), values(beyond))
            }
            Some(numbers) => {
                let scaled = |factor: f64| -> Value {
                    numbers
                        .iter()
                        .map(|n| factor * n)
                        .collect::<Vec<f64>>()
                        .into()
                };
                (vec![scaled(0.9)], vec![scaled(1.1)])
            }
            None => (Vec::new(), Vec::new()),
        }
    }

    #[test]
    fn every_number_of_a_rig_file_is_compared_and_only_limits_may_be_stricter() {
        let mut compared = BTreeSet::new();
        for shape in [Shape::Cylinder, Shape::Box, Shape::Sphere] {
            let rig = Rig::demo(shape);
            let whole = sections(&rig);
            for section in ["object", "striker", "table", "robot", "camera"] {
                let keys = whole[section].as_object().expect("a section");
                for (key, value) in keys {
                    let name = format!("{section}.{key}");
                    let other = |value: &Value| -> Rig {
                        let mut whole = whole.clone();
                        whole[section][key] = value.clone();
                        serde_json::from_value(whole).expect(&name)
                    };
                    let (within, beyond) = changes(value);
                    let may_be_stricter = section == "camera" || LIMITS.contains(&&*name);
                    for value in &within {
                        compared.insert(name.clone());
                        let own = check(&rig, &other(value));
                        assert_eq!(own.is_ok(), may_be_stricter, "{name} = {value}: {own:?}");
                    }
                    for value in &beyond {
                        let own = check(&rig, &other(value));
                        assert_eq!(
                            own.is_ok(),
                            section == "camera",
                            "{name} = {value}: {own:?}"
                        );
                        if section != "camera" {
                            let text = own.expect_err("another rig").to_string();
                            assert!(text.contains(&format!("[{section}] {key} is ")), "{text}");
                        }
                        let there = allows(&rig, &other(value));
                        assert_eq!(
                            there.is_ok(),
                            may_be_stricter,
                            "{name} = {value}: {there:?}"
                        );
                    }
                }
            }
        }
        for limit in LIMITS {
            assert!(compared.contains(limit), "{limit} was not compared");
        }
        for other in [
            "object.mass",
            "object.half_size",
            "object.radius",
            "striker.radius",
        ] {
            assert!(
                compared.contains(other),
                "{other} was not compared: {compared:?}"
            );
        }
    }
}
