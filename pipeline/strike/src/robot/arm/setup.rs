//! What a rig file must state for an arm that moves, and the table's frame in the arm's.

use values::{Point, Rig};

use super::driver::{Identity, Pose, Status, distance, shown};
use super::guard::ASIDE;
use super::turn::Turn;

/// Speed (m/s) and acceleration (m/s²) of travel outside a strike: well below the 0.25 m/s of reduced speed (ISO 10218-2).
pub(super) const TRAVEL: (f64, f64) = (0.1, 0.5);
/// Greatest difference of the tool from the rig file, in m, rad and kg.
const TOOL: (f64, f64, f64) = (0.0005, 0.01, 0.05);
/// Distance by which the tip at travel height passes above the object, in m.
const CLEAR: f64 = 0.010;
/// Least distance of a striking tip below the object's top, in m: what the guard lets it be off.
const BELOW_TOP: f64 = ASIDE;

/// How high the tip's centre is, in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Height {
    /// Height above the table, in m, by the rig file.
    pub(crate) above: f64,
    /// z in the arm's frame, in m.
    pub(crate) z: f64,
}

/// What is known of the arm's place and tool.
#[derive(Clone, Debug)]
pub(super) struct Setup {
    /// The base's axis in frame `table`, its yaw in rad, and its height above the table, in m.
    base: Point,
    yaw: f64,
    height: f64,
    strike_height: f64,
    travel_height: f64,
    /// Distance that the tip reaches below its centre, in m.
    below: f64,
    orientation: Turn,
    tool: Pose,
    payload: f64,
    /// m/s³; none for an arm that has none.
    pub(super) jerk: Option<f64>,
    /// m/s².
    pub(super) acceleration: f64,
    /// m/s.
    speed: f64,
    serial: Option<String>,
}

impl Setup {
    /// The setup of a rig file. Errors name the keys that are missing, or a height at which the tip meets what it must not.
    pub(super) fn of(rig: &Rig) -> Result<Self, String> {
        let robot = &rig.robot;
        let (
            Some(base),
            Some(_),
            Some(_),
            Some(strike_height),
            Some(travel_height),
            Some(orientation),
            Some(tool_offset),
            Some(payload),
        ) = (
            robot.base,
            robot.keep_out,
            robot.reach,
            robot.strike_height,
            robot.travel_height,
            robot.tool_orientation,
            robot.tool_offset,
            robot.payload,
        )
        else {
            let missing: Vec<&str> = [
                ("base", robot.base.is_none()),
                ("keep_out", robot.keep_out.is_none()),
                ("reach", robot.reach.is_none()),
                ("strike_height", robot.strike_height.is_none()),
                ("travel_height", robot.travel_height.is_none()),
                ("tool_orientation", robot.tool_orientation.is_none()),
                ("tool_offset", robot.tool_offset.is_none()),
                ("payload", robot.payload.is_none()),
            ]
            .into_iter()
            .filter_map(|(key, is_missing)| is_missing.then_some(key))
            .collect();
            return Err(format!(
                "the rig file's [robot] lacks {}",
                missing.join(", ")
            ));
        };
        let below = match rig.striker.tip {
            values::Tip::Sphere => rig.striker.radius,
            // An upright rod's centre is that of its lower end, which the rig file states no length for.
            values::Tip::Cylinder => 0.0,
        };
        check_heights(rig, below, strike_height, travel_height)?;
        let [x, y, z, roll, pitch, yaw] = tool_offset;
        Ok(Self {
            base,
            yaw: robot.base_yaw.unwrap_or(0.0),
            height: robot.base_height.unwrap_or(0.0),
            strike_height,
            travel_height,
            below,
            orientation: Turn::rpy(orientation),
            tool: Pose {
                at: [x, y, z],
                turn: Turn::rpy([roll, pitch, yaw]),
            },
            payload,
            jerk: robot.jerk,
            acceleration: robot.acceleration,
            speed: robot.speed.high,
            serial: robot.serial.clone(),
        })
    }

    /// Checks that it is the arm of the rig file, and can do what that lets it be commanded.
    pub(super) fn check_identity(&self, identity: &Identity) -> Result<(), String> {
        let (limits, serial) = (&identity.limits, &identity.serial);
        if let Some(own) = self.serial.as_ref().filter(|own| *own != serial) {
            return Err(format!(
                "its serial number is {serial}, and the rig file is of the arm {own} (robot.serial): look at the address, or set the rig file \
                 right"
            ));
        }
        match (self.jerk, limits.jerk) {
            (None, Some(_)) => {
                return Err("the rig file's [robot] lacks jerk".into());
            }
            (Some(_), None) => {
                return Err(
                    "robot.jerk is stated, and this arm's lines have no limit of jerk: plans would not be what it moves; take it away"
                        .into(),
                );
            }
            _ => {}
        }
        for (key, unit, value, most) in [
            ("speed", "m/s", self.speed, limits.speed),
            (
                "acceleration",
                "m/s²",
                self.acceleration,
                limits.acceleration,
            ),
            (
                "jerk",
                "m/s³",
                self.jerk.unwrap_or(0.0),
                limits.jerk.unwrap_or(0.0),
            ),
        ] {
            if value > most {
                return Err(format!(
                    "robot.{key} is {value} {unit}, the arm does {most} {unit}"
                ));
            }
        }
        Ok(())
    }

    /// A point of the table (m) at strike height, in the arm's frame.
    pub(super) fn low(&self, point: Point) -> Pose {
        self.at(point, self.strike_height)
    }

    /// A point of the table (m) at travel height, in the arm's frame.
    pub(super) fn high(&self, point: Point) -> Pose {
        self.at(point, self.travel_height)
    }

    fn at(&self, point: Point, height: f64) -> Pose {
        let ((sin, cos), from) = (self.yaw.sin_cos(), point - self.base);
        Pose {
            at: [
                cos * from.x + sin * from.y,
                cos * from.y - sin * from.x,
                height - self.height,
            ],
            turn: self.orientation,
        }
    }

    /// A place in the arm's frame (m) on the table (m).
    pub(super) fn on_table(&self, place: [f64; 3]) -> Point {
        self.base + self.turned(place)
    }

    /// A vector along the table in the arm's frame, in the table's.
    pub(super) fn turned(&self, [x, y, _]: [f64; 3]) -> Point {
        let (sin, cos) = self.yaw.sin_cos();
        Point::new(cos * x - sin * y, sin * x + cos * y)
    }

    /// Checks that the controller is set as the rig file says, and to what a strike may be made with.
    pub(super) fn check_status(&self, status: &Status) -> Result<(), String> {
        if let Some(wrong) = status.wrong.first() {
            return Err(wrong.clone());
        }
        let (far, turned, heavy) = TOOL;
        let is_same = distance(self.tool.at, status.tool.at) <= far
            && self.tool.turn.angle_to(status.tool.turn) <= turned;
        if !is_same {
            let told = |pose: &Pose| {
                let turn = pose.turn.to_rpy();
                format!("{} m, turned by {} rad", shown(&pose.at), shown(&turn))
            };
            return Err(format!(
                "the controller has the tool offset {}, the rig file says {}; set one right",
                told(&status.tool),
                told(&self.tool)
            ));
        }
        let is_light = (self.payload - status.payload).abs() <= heavy;
        is_light.then_some(()).ok_or_else(|| {
            format!(
                "the controller has a tool of {} kg, the rig file says {} kg; set one right",
                status.payload, self.payload
            )
        })
    }

    /// Checks that a place (m) lies within the arm's own fence.
    pub(super) fn check_fence(&self, status: &Status, place: [f64; 3]) -> Result<(), String> {
        let Some([low, high]) = status.fence else {
            return Ok(());
        };
        let is_inside = (0..3).all(|i| (low[i]..=high[i]).contains(&place[i]));
        is_inside.then_some(()).ok_or_else(|| {
            format!(
                "the arm's own fence holds its tip between {} and {} m, and the strike goes to {} m; choose another target, or set the fence \
                 by the arm's own program",
                shown(&low),
                shown(&high),
                shown(&place)
            )
        })
    }

    /// Checks that the tool points as the rig file says.
    pub(super) fn check_orientation(&self, pose: &Pose) -> Result<(), String> {
        let (_, turned, _) = TOOL;
        let apart = self.orientation.angle_to(pose.turn);
        (apart <= turned).then_some(()).ok_or_else(|| {
            format!(
                "the tool points {apart:.3} rad beside robot.tool_orientation; turn it by the arm's own program first"
            )
        })
    }

    /// The height (m) of a place of the tip's centre (arm's frame, m), above the table and along the arm's z.
    pub(super) fn height(&self, [_, _, z]: [f64; 3]) -> Height {
        let above = z + self.height;
        Height { above, z }
    }

    /// The height (m) at which the tip strikes, above the table and along the arm's z.
    pub(super) fn low_height(&self) -> Height {
        Height {
            above: self.strike_height,
            z: self.strike_height - self.height,
        }
    }

    /// Checks that the tip stands at travel height, or, where carom left it in a strike that was not ended (`left`), as high above the table as then:
    /// nothing that the arm reports shows that the rig file's heights are wrong, and the tip would be driven into the table. What it may stand higher
    /// than by the rig file leaves half of what a strike keeps clear of the table.
    pub(super) fn check_height(&self, pose: &Pose, left: Option<Height>) -> Result<(), String> {
        let (Height { above: height, z }, mm) = (self.height(pose.at), |length: f64| length * 1e3);
        if height < self.below {
            return Err(format!(
                "by robot.base_height and robot.tool_offset the tip, which reaches {:.1} mm below its centre, is {:.1} mm above the table: \
                 inside it; one of them is wrong: measure where the tip stands, and set the rig file right",
                mm(self.below),
                mm(height)
            ));
        }
        let most = CLEAR.min(0.5 * (self.strike_height - self.below));
        let still = left.filter(|then| (z - then.z).abs() <= most);
        let expected = still.map_or(self.travel_height, |then| then.above);
        let is_known = (height - expected).abs() <= most;
        is_known.then_some(()).ok_or_else(|| {
            format!(
                "by robot.base_height the tip is {:.1} mm above the table, and robot.travel_height is {:.1} mm: a base_height that is wrong by \
                 more than {:.1} mm drives it into the table; measure how high it stands: where that is what is said here, bring the tip to \
                 travel height by the arm's own program, else set base_height right",
                mm(height),
                mm(self.travel_height),
                mm(most)
            )
        })
    }
}

/// Checks that the tip strikes clear of the table and below the object's top, and travels clear of the object.
fn check_heights(rig: &Rig, below: f64, strike: f64, travel: f64) -> Result<(), String> {
    let object = object_height(rig);
    let mm = |length: f64| length * 1e3;
    if strike < below + ASIDE {
        return Err(format!(
            "robot.strike_height is {:.1} mm: the tip, which reaches {:.1} mm below it, would not stay {:.1} mm above the table, by which \
             the arm may be off its line",
            mm(strike),
            mm(below),
            mm(ASIDE)
        ));
    }
    if strike > object - BELOW_TOP {
        return Err(format!(
            "robot.strike_height is {:.1} mm: the tip would pass over the object, which is {:.1} mm high",
            mm(strike),
            mm(object)
        ));
    }
    if travel < object + below + CLEAR {
        return Err(format!(
            "robot.travel_height is {:.1} mm: the tip would not pass {:.0} mm above the object, which is {:.1} mm high",
            mm(travel),
            mm(CLEAR),
            mm(object)
        ));
    }
    if let Some(reach) = rig.robot.reach
        && travel > reach.high
    {
        return Err(format!(
            "robot.travel_height is {:.1} mm: farther than robot.reach, which ends at {:.1} mm",
            mm(travel),
            mm(reach.high)
        ));
    }
    Ok(())
}

/// Height of the object, in m.
fn object_height(rig: &Rig) -> f64 {
    2.0 * rig.object.solid.half_height()
}

#[cfg(test)]
mod tests {
    use values::Shape;

    use super::*;

    fn rig() -> Rig {
        let mut rig = Rig::demo(Shape::Cylinder);
        let robot = &mut rig.robot;
        robot.base = Some(Point::new(0.1, -0.2));
        robot.keep_out = Some(0.1);
        robot.reach = Some([0.1, 0.9].into());
        robot.strike_height = Some(0.02);
        robot.travel_height = Some(0.08);
        robot.tool_orientation = Some([std::f64::consts::PI, 0.0, 0.0]);
        robot.tool_offset = Some([0.0; 6]);
        robot.payload = Some(0.3);
        rig
    }

    #[test]
    fn a_height_at_which_the_tip_meets_the_table_or_misses_the_object_is_refused() {
        // The demo's object is 40 mm high, its tip a ball of 12 mm.
        for (strike, travel, said) in [
            (0.002, 0.08, "above the table"),
            (0.016, 0.08, "above the table"),
            (0.036, 0.08, "over the object"),
            (0.05, 0.08, "over the object"),
            (0.02, 0.06, "above the object"),
            (0.02, 5.0, "farther than robot.reach"),
        ] {
            let mut rig = rig();
            rig.robot.strike_height = Some(strike);
            rig.robot.travel_height = Some(travel);
            let error = Setup::of(&rig).expect_err(said);
            assert!(error.contains(said), "{error}");
        }
        Setup::of(&rig()).expect("as it should be");
    }

    #[test]
    fn a_tip_that_is_not_at_travel_height_or_where_it_was_left_is_refused() {
        let mut rig = rig();
        rig.robot.base_height = Some(-0.05);
        let setup = Setup::of(&rig).expect("a setup");
        // A ball of 12 mm strikes 20 mm above the table, 8 mm clear of it.
        let checked = |height: f64, left: Option<Height>| {
            setup.check_height(&setup.at(Point::default(), height), left)
        };
        // Left in a strike by this rig file, and by one whose base stood 60 mm lower.
        let (left, otherwise) = (
            Some(setup.low_height()),
            Some(Height {
                above: 0.02,
                z: 0.13,
            }),
        );
        for (height, left) in [
            (0.0761, None),
            (0.0839, None),
            (0.0761, left),
            (0.0239, left),
            (0.0161, left),
        ] {
            checked(height, left).expect("its height is known");
        }
        for (height, left, said) in [
            (0.0119, left, "inside it"),
            (-0.22, None, "-220.0 mm above the table"),
            (0.0841, None, "robot.travel_height is 80.0 mm"),
            (0.0759, None, "bring the tip to travel height"),
            (0.02, None, "bring the tip to travel height"),
            (0.08, otherwise, "bring the tip to travel height"),
            (0.0241, left, "wrong by more than 4.0 mm"),
            (0.07, left, "bring the tip to travel height"),
            (0.33, None, "330.0 mm above the table"),
        ] {
            let why = checked(height, left).expect_err(said);
            assert!(why.contains(said) && why.contains("base_height"), "{why}");
        }
    }

    #[test]
    fn a_base_that_is_turned_and_raised_is_a_frame_of_its_own() {
        let mut rig = rig();
        rig.robot.base_yaw = Some(std::f64::consts::FRAC_PI_2);
        rig.robot.base_height = Some(0.03);
        let setup = Setup::of(&rig).expect("a setup");
        // A point that lies to the base's left on the table lies straight ahead of an arm that is turned to the left.
        let ahead = setup.low(Point::new(0.1, 0.3)).at;
        assert!(distance(ahead, [0.5, 0.0, -0.01]) < 1e-12, "{ahead:?}");
        assert!(setup.on_table(ahead).distance(Point::new(0.1, 0.3)) < 1e-12);
        let right = setup.turned([0.0, -1.0, 0.0]);
        assert!(right.distance(Point::new(1.0, 0.0)) < 1e-12, "{right:?}");
    }
}
