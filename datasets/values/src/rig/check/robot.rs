//! Checks of where the arm stands and may go.

use super::super::{Obstacle, RigError, Robot};

/// Farthest that anything of an arm lies from its base, in m.
const FARTHEST: f64 = 20.0;
/// Largest jerk of an arm, in m/s³.
const LARGEST_JERK: f64 = 1e6;
/// Heaviest tool, in kg.
const HEAVIEST: f64 = 50.0;

/// In rad, as 3.1416 too.
const HALF_A_TURN: f64 = std::f64::consts::PI + 1e-5;

/// Checks what `[robot]` says of the arm's place.
pub(super) fn check(robot: &Robot) -> Result<(), RigError> {
    let wrong = |key: &str, value: String, why: &str| RigError::Value {
        key: format!("robot.{key}"),
        value,
        why: why.into(),
    };
    let within = |key: &str, number: f64, (low, high): (f64, f64), why: &str| {
        let is_within = low <= number && number <= high;
        is_within
            .then_some(())
            .ok_or_else(|| wrong(key, number.to_string(), why))
    };
    let length = (0.0, FARTHEST);
    if let Some(base) = robot.base {
        for number in [base.x, base.y] {
            within(
                "base",
                number,
                (-FARTHEST, FARTHEST),
                "must be a point within 20 m (metres, not millimetres?)",
            )?;
        }
    }
    for (key, number, most, why) in [
        (
            "base_yaw",
            robot.base_yaw,
            HALF_A_TURN,
            "must be an angle in rad, at most half a turn (not degrees?)",
        ),
        (
            "base_height",
            robot.base_height,
            FARTHEST,
            "must be at most 20 m (metres, not millimetres?)",
        ),
    ] {
        within(key, number.unwrap_or(0.0), (-most, most), why)?;
    }
    for (key, number) in [
        ("keep_out", robot.keep_out),
        ("strike_height", robot.strike_height),
        ("travel_height", robot.travel_height),
    ] {
        let why = "must be at least 0 and at most 20 m (metres, not millimetres?)";
        within(key, number.unwrap_or(0.0), length, why)?;
    }
    if let Some(reach) = robot.reach {
        let is_interval = 0.0 <= reach.low && reach.low < reach.high && reach.high <= FARTHEST;
        if !is_interval {
            let why = "must be [nearest, farthest] distance from the base, in m";
            return Err(wrong(
                "reach",
                format!("[{}, {}]", reach.low, reach.high),
                why,
            ));
        }
    }
    if let Some(jerk) = robot.jerk {
        let least = f64::MIN_POSITIVE;
        within(
            "jerk",
            jerk,
            (least, LARGEST_JERK),
            "must be above 0 m/s³ (metres, not millimetres?)",
        )?;
    }
    if let (Some(strike), Some(travel)) = (robot.strike_height, robot.travel_height)
        && travel <= strike
    {
        return Err(wrong(
            "travel_height",
            travel.to_string(),
            "must be above robot.strike_height",
        ));
    }
    within(
        "payload",
        robot.payload.unwrap_or(0.0),
        (0.0, HEAVIEST),
        "must be a mass in kg (not grams?)",
    )?;
    for angle in robot.tool_orientation.unwrap_or_default() {
        within(
            "tool_orientation",
            angle,
            (-HALF_A_TURN, HALF_A_TURN),
            "must be [roll, pitch, yaw] in rad (not degrees?)",
        )?;
    }
    for number in robot.tool_offset.unwrap_or_default() {
        within(
            "tool_offset",
            number,
            (-FARTHEST, FARTHEST),
            "must be [x, y, z, roll, pitch, yaw] in m and rad",
        )?;
    }
    robot.obstacles.iter().enumerate().try_for_each(|(index, obstacle)| {
        let (numbers, is_sound) = match *obstacle {
            Obstacle::Box { x, y } => (
                [x.low, x.high, y.low, y.high],
                x.low < x.high && y.low < y.high,
            ),
            Obstacle::Disc { centre, radius } => {
                ([centre.x, centre.y, radius, radius], radius > 0.0)
            }
        };
        let why = if numbers.iter().any(|number| number.is_finite() && number.abs() > FARTHEST) {
            "it looks like millimetres; state it in metres, 50 mm as 0.05"
        } else if is_sound && numbers.iter().all(|number| number.is_finite()) {
            return Ok(());
        } else {
            "a box needs x = [low, high] and y = [low, high], a disc centre = [x, y] and radius above 0, in m"
        };
        Err(wrong("obstacles", format!("{obstacle} (number {})", index + 1), why))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rig;
    use crate::rig::tests::refused;

    const PLACED: &str = "acceleration = 5.0
base = [-0.1, 0.0]
base_yaw = 0.3
base_height = -0.02
keep_out = 0.2
reach = [0.2, 0.9]
jerk = 100.0
strike_height = 0.02
travel_height = 0.15
tool_orientation = [3.14159, 0.0, 0.0]
tool_offset = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0]
payload = 0.3
[[robot.obstacles]]
shape = \"box\"
x = [0.5, 0.6]
y = [0.3, 0.4]
[[robot.obstacles]]
shape = \"disc\"
centre = [0.5, -0.4]
radius = 0.05
";

    fn parse(from: &str, to: &str) -> Result<Rig, RigError> {
        let placed = PLACED.replacen(from, to, 1);
        assert!(from.is_empty() || placed != PLACED, "{from}");
        let line = Rig::template()
            .lines()
            .find(|line| line.starts_with("acceleration"))
            .expect("there");
        Rig::parse(&Rig::template().replacen(line, &placed, 1))
    }

    #[test]
    fn what_is_said_of_the_arms_place_is_read_and_survives_a_round_trip() {
        let rig = parse("", "").expect("parses");
        assert!(rig.robot.is_placed());
        assert_eq!(rig.robot.obstacles.len(), 2);
        assert_eq!(Rig::parse(&rig.to_toml()).expect("parses"), rig);
        assert!(
            !Rig::parse(Rig::template())
                .expect("parses")
                .robot
                .is_placed()
        );
    }

    #[test]
    fn what_the_template_proposes_for_an_arm_is_accepted() {
        let (before, robot) = Rig::template()
            .split_once("# Where the arm stands")
            .expect("there");
        let (robot, after) = robot.split_once("\n\n").expect("ends");
        let keys: String = robot
            .lines()
            .skip(1)
            .map(|line| format!("{}\n", line.trim_start_matches("# ")))
            .collect();
        let rig = Rig::parse(&format!("{before}{keys}\n{after}")).expect("parses");
        assert!(rig.robot.tool_orientation.is_some() && rig.robot.obstacles.len() == 1);
    }

    #[test]
    fn what_makes_no_sense_is_refused_by_its_key() {
        refused(
            |from, to| parse(from, to).expect_err(to).to_string(),
            r#"
keep_out = 0.2 → keep_out = 200.0 ⇒ robot.keep_out
keep_out = 0.2 → keep_out = nan ⇒ robot.keep_out
reach = [0.2, 0.9] → reach = [0.9, 0.2] ⇒ robot.reach
jerk = 100.0 → jerk = 0.0 ⇒ robot.jerk
travel_height = 0.15 → travel_height = 0.01 ⇒ robot.travel_height
payload = 0.3 → payload = 300.0 ⇒ robot.payload
3.14159 → 180.0 ⇒ robot.tool_orientation
x = [0.5, 0.6] → x = [0.6, 0.5] ⇒ (number 1): a box needs
[[robot.obstacles]] → [[obstacles]] ⇒ did you mean `robot.obstacles`
radius = 0.05 → radius = 0.0 ⇒ robot.obstacles = a disc of radius 0 m about (0.5, -0.4) m (number 2): a box needs
centre = [0.5, -0.4]\nradius = 0.05 → centre = [500, -400]\nradius = 50 ⇒ robot.obstacles = a disc of radius 50 m about (500, -400) m (number 2): it looks like millimetres
x = [0.5, 0.6] → x = [500, 600] ⇒ a box, x in [500, 600] and y in [0.3, 0.4] m (number 1): it looks like millimetres
x = [0.5, 0.6] → x = [nan, 0.6] ⇒ (number 1)
radius = 0.05 → size = 0.05 ⇒ size
payload = 0.3\n[[robot.obstacles]] → [[robot.obstacles]]\npayload = 0.3 ⇒ it stands below [[robot.obstacles]], and TOML takes it for a key of that; move [[robot.obstacles]], with its own keys, below all other keys of [robot]
acceleration = 5.0\n → [[robot.obstacles]]\nacceleration = 5.0\n ⇒ `robot.acceleration` on line
base = [-0.1, 0.0] → base = [-100.0, 0.0] ⇒ robot.base
jerk = 100.0 → jrek = 100.0 ⇒ robot.jerk
base_yaw = 0.3 → base_yaw = 90.0 ⇒ robot.base_yaw
base_height = -0.02 → base_height = nan ⇒ robot.base_height
"#,
        );
    }
}
