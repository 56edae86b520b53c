//! Whether two rig files describe the same set-up.

use serde::Serialize;
use values::Rig;

/// Two rig files that do not describe one set-up. Its text stands after a colon.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "this is not the rig that the artifact was made for: {}; use its own artifact, or calibrate this rig",
    differences.join(", ")
)]
pub struct OtherRig {
    /// What differs, such as `[object] mass = 0.1 in the artifact, 0.2 here`.
    pub differences: Vec<String>,
}

/// Compares what a strike depends on: object, striker, table and robot. Camera and topics may differ: they say how it
/// is seen and logged.
pub fn check(artifact: &Rig, here: &Rig) -> Result<(), OtherRig> {
    let mut differences = Vec::new();
    compare("object", &artifact.object, &here.object, &mut differences);
    compare(
        "striker",
        &artifact.striker,
        &here.striker,
        &mut differences,
    );
    compare("table", &artifact.table, &here.table, &mut differences);
    compare("robot", &artifact.robot, &here.robot, &mut differences);
    if differences.is_empty() {
        Ok(())
    } else {
        Err(OtherRig { differences })
    }
}

fn compare<T: Serialize + PartialEq>(
    section: &str,
    artifact: &T,
    here: &T,
    differences: &mut Vec<String>,
) {
    if artifact == here {
        return;
    }
    let keys = |value: &T| match serde_json::to_value(value) {
        Ok(serde_json::Value::Object(keys)) => keys,
        _ => serde_json::Map::new(),
    };
    let (artifact, here) = (keys(artifact), keys(here));
    let names: std::collections::BTreeSet<_> = artifact.keys().chain(here.keys()).collect();
    for name in names {
        let (theirs, ours) = (artifact.get(name), here.get(name));
        if theirs != ours {
            let text = |value: Option<&serde_json::Value>| {
                value.map_or("none".to_owned(), ToString::to_string)
            };
            differences.push(format!(
                "[{section}] {name} is {} in the artifact, {} here",
                text(theirs),
                text(ours)
            ));
        }
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
        heavier.robot.speed.high = 0.9;
        let text = check(&rig, &heavier).expect_err("differs").to_string();
        assert!(
            text.contains("[object] mass is 0.1 in the artifact, 0.2 here"),
            "{text}"
        );
        assert!(
            text.contains("[robot] speed is [0.4,1.0] in the artifact, [0.4,0.9] here"),
            "{text}"
        );
    }
}
