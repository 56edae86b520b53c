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
    /// The differing keys, such as `[object] mass is 0.1 in the artifact, 0.2 here`.
    pub differences: Vec<String>,
}

/// Whether a robot's own rig file is that of the artifact, or stricter: same object and striker; table and limits of the
/// arm the same or within the artifact's. Camera and topics may differ: they say how a strike is seen and logged.
pub fn check(artifact: &Rig, own: &Rig) -> Result<(), OtherRig> {
    compare(artifact, own, |rule, artifact, own| {
        rule.is_stricter(own, artifact)
    })
}

/// Whether what is planned for one rig file may be struck in another: that one's table and arm allow all that the plan's do.
pub fn allows(planned: &Rig, there: &Rig) -> Result<(), OtherRig> {
    compare(planned, there, |rule, planned, there| {
        rule.is_stricter(planned, there)
    })
}

/// How a key of two rig files may differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rule {
    /// Not at all: another value is another set-up.
    Same,
    /// The stricter interval lies within the other.
    Within,
    /// The stricter number is the smaller one.
    AtMost,
    /// Any difference is allowed: the key describes the object for a camera, or this robot's place and area. Plans use the robot's
    /// own value, and no artifact depends on it.
    Own,
}

/// The rule of each key of `[table]` and `[robot]`, and of `[object]` and `[striker]` where it is not [`Rule::Same`].
const RULES: [((&str, &str), Rule); 21] = [
    (("object", "colour"), Rule::Own),
    (("object", "marker"), Rule::Own),
    (("table", "x"), Rule::Within),
    (("table", "y"), Rule::Within),
    (("table", "fences"), Rule::Own),
    (("robot", "speed"), Rule::Within),
    (("robot", "angle"), Rule::Within),
    (("robot", "acceleration"), Rule::AtMost),
    (("robot", "base"), Rule::Own),
    (("robot", "base_yaw"), Rule::Own),
    (("robot", "base_height"), Rule::Own),
    (("robot", "keep_out"), Rule::Own),
    (("robot", "reach"), Rule::Own),
    (("robot", "jerk"), Rule::Own),
    // Where the tip meets the object decides how the object leaves it.
    (("robot", "strike_height"), Rule::Same),
    (("robot", "travel_height"), Rule::Own),
    (("robot", "tool_orientation"), Rule::Own),
    (("robot", "tool_offset"), Rule::Own),
    (("robot", "payload"), Rule::Own),
    (("robot", "serial"), Rule::Own),
    (("robot", "obstacles"), Rule::Own),
];

/// The rule of a key. A key that the table does not name makes another rig: a new one is thought about before it may differ.
fn rule(section: &str, key: &str) -> Rule {
    let named = RULES.iter().find(|(name, _)| *name == (section, key));
    named.map_or(Rule::Same, |(_, rule)| *rule)
}

impl Rule {
    /// Whether one value may stand where the other was agreed: it is the same, or stricter.
    fn is_stricter(self, one: &Value, other: &Value) -> bool {
        let number = Value::as_f64;
        let ends = |value: &Value| Some((number(value.get(0)?)?, number(value.get(1)?)?));
        one == other
            || match self {
                Self::Same => false,
                Self::Own => true,
                Self::AtMost => number(one)
                    .zip(number(other))
                    .is_some_and(|(one, other)| one <= other),
                Self::Within => {
                    ends(one)
                        .zip(ends(other))
                        .is_some_and(|((low, high), (lowest, highest))| {
                            lowest <= low && high <= highest
                        })
                }
            }
    }
}

/// Differences of two rigs in what a strike depends on; `may_differ` says which ones are allowed.
fn compare(
    artifact: &Rig,
    here: &Rig,
    may_differ: impl Fn(Rule, &Value, &Value) -> bool,
) -> Result<(), OtherRig> {
    let (theirs, ours) = (sections(artifact), sections(here));
    let mut differences = Vec::new();
    for section in SECTIONS {
        let keys = |rig: &Value| rig[section].as_object().cloned().unwrap_or_default();
        let names: BTreeSet<String> = [&theirs, &ours]
            .into_iter()
            .flat_map(|rig| keys(rig).into_iter().map(|(name, _)| name))
            .collect();
        for name in names {
            let (theirs, ours) = (&theirs[section][&name], &ours[section][&name]);
            if may_differ(rule(section, &name), theirs, ours) {
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

/// What a strike depends on.
const SECTIONS: [&str; 4] = ["object", "striker", "table", "robot"];

fn sections(rig: &Rig) -> Value {
    serde_json::to_value(rig).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use values::{Interval, Marker, Obstacle, Point, Shape};

    #[test]
    fn a_rig_is_known_by_what_a_strike_depends_on() {
        let rig = Rig::demo(Shape::Cylinder);
        let mut seen_otherwise = rig.clone();
        seen_otherwise.camera.rate = 30.0;
        seen_otherwise.object.marker = Some(Marker {
            dictionary: "DICT_APRILTAG_36h11".into(),
            id: 3,
            size: 0.03,
            offset: Point::default(),
            yaw: 0.0,
        });
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

    /// A rig of this shape that states every key of `[robot]`.
    fn complete(shape: Shape) -> Rig {
        let mut rig = Rig::demo(shape);
        let robot = &mut rig.robot;
        robot.base = Some(Point::new(0.01, 0.02));
        robot.base_yaw = Some(0.1);
        robot.base_height = Some(0.01);
        robot.keep_out = Some(0.2);
        robot.reach = Some(Interval {
            low: 0.2,
            high: 0.9,
        });
        robot.jerk = Some(100.0);
        robot.strike_height = Some(0.02);
        robot.travel_height = Some(0.15);
        robot.tool_orientation = Some([3.1, 0.1, 0.1]);
        robot.tool_offset = Some([0.1, 0.1, 0.1, 0.1, 0.1, 0.1]);
        robot.payload = Some(0.3);
        robot.obstacles = vec![Obstacle::Disc {
            centre: Point::new(0.5, -0.4),
            radius: 0.05,
        }];
        rig
    }

    /// What may be written in a key's place: values that allow less, and others.
    struct Changes {
        stricter: Vec<Value>,
        others: Vec<Value>,
    }

    /// By the direction of each key, stated here apart from the code's own table.
    fn changes(section: &str, key: &str, value: &Value) -> Changes {
        let intervals = |ends: Vec<[f64; 2]>| ends.into_iter().map(|ends| ends.to_vec().into());
        let scaled = |factor: f64| scaled(value, factor);
        match (section, key) {
            ("table", "x" | "y") | ("robot", "speed" | "angle") => {
                let low = value[0].as_f64().expect("a low end");
                let high = value[1].as_f64().expect("a high end");
                let step = 0.1 * (high - low);
                Changes {
                    stricter: intervals(vec![[low + step, high], [low, high - step]]).collect(),
                    others: intervals(vec![[low - step, high], [low, high + step]]).collect(),
                }
            }
            ("robot", "acceleration") => Changes {
                stricter: vec![scaled(0.9)],
                others: vec![scaled(1.1)],
            },
            _ => Changes {
                stricter: Vec::new(),
                others: [0.9, 1.1]
                    .map(scaled)
                    .into_iter()
                    .filter(|scaled| scaled != value)
                    .collect(),
            },
        }
    }

    /// Every number in a value by this factor.
    fn scaled(value: &Value, factor: f64) -> Value {
        match value {
            Value::Number(number) => (factor * number.as_f64().expect("a number")).into(),
            Value::Array(all) => all.iter().map(|value| scaled(value, factor)).collect(),
            Value::Object(all) => all
                .iter()
                .map(|(key, value)| (key.clone(), scaled(value, factor)))
                .collect::<serde_json::Map<_, _>>()
                .into(),
            other => other.clone(),
        }
    }

    /// Keys of this robot's own: any value of them is planned within, and none makes another rig.
    const OWN: [&str; 11] = [
        "robot.base",
        "robot.base_yaw",
        "robot.base_height",
        "robot.keep_out",
        "robot.reach",
        "robot.jerk",
        "robot.travel_height",
        "robot.tool_orientation",
        "robot.tool_offset",
        "robot.payload",
        "robot.obstacles",
    ];

    #[test]
    fn every_key_of_a_rig_file_is_compared_in_its_own_direction() {
        let mut compared = BTreeSet::new();
        for shape in [Shape::Cylinder, Shape::Box, Shape::Sphere] {
            let whole = sections(&complete(shape));
            let rig: Rig = serde_json::from_value(whole.clone()).expect("a rig");
            for section in ["object", "striker", "table", "robot", "camera"] {
                for (key, value) in whole[section].as_object().expect("a section") {
                    let name = format!("{section}.{key}");
                    let other = |value: &Value| -> Rig {
                        let mut whole = whole.clone();
                        whole[section][key] = value.clone();
                        serde_json::from_value(whole).expect(&name)
                    };
                    let is_own = section == "camera" || OWN.contains(&&*name);
                    let changes = changes(section, key, value);
                    for value in &changes.stricter {
                        compared.insert(name.clone());
                        assert_eq!(check(&rig, &other(value)), Ok(()), "{name} = {value}");
                        // A plan for the wider rig may not be struck in the stricter one.
                        allows(&rig, &other(value)).expect_err(&name);
                        assert_eq!(allows(&other(value), &rig), Ok(()), "{name} = {value}");
                    }
                    for value in &changes.others {
                        compared.insert(name.clone());
                        let own = check(&rig, &other(value));
                        assert_eq!(own.is_ok(), is_own, "{name} = {value}: {own:?}");
                        if !is_own {
                            let text = own.expect_err("another rig").to_string();
                            assert!(text.contains(&format!("[{section}] {key} is ")), "{text}");
                        }
                    }
                }
            }
        }
        // Colour and shapes are no numbers; what is left must have been compared.
        for section in SECTIONS {
            let whole = sections(&complete(Shape::Box));
            for (key, value) in whole[section].as_object().expect("a section") {
                let name = format!("{section}.{key}");
                let is_compared = value.is_string() || compared.contains(&name);
                assert!(is_compared, "{name} was not compared: {compared:?}");
            }
        }
    }

    #[test]
    fn a_key_that_only_one_file_states_is_another_rig_unless_it_is_the_robots_own() {
        let (bare, stated) = (Rig::demo(Shape::Cylinder), complete(Shape::Cylinder));
        let differences = check(&bare, &stated)
            .expect_err("strike height")
            .differences;
        assert_eq!(
            differences,
            ["[robot] strike_height is none in the artifact, 0.02 here"]
        );
        let mut own = stated.clone();
        own.robot.strike_height = None;
        assert_eq!(check(&bare, &own), Ok(()));
    }
}
