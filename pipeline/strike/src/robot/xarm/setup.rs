//! What a rig file must state for an arm that moves, in the arm's own units and frame.

use values::{Point, Rig};

use super::guard::distance;
use super::wire::Status;

/// Travel outside a strike, in mm/s and mm/s²: well below the 250 mm/s of reduced speed (ISO 10218-2).
pub(super) const TRAVEL: (f64, f64) = (100.0, 500.0);
/// The arm's own limits: mm/s, mm/s², mm/s³. The controller would clamp in silence what is above.
const LIMITS: (f64, f64, f64) = (1_000.0, 50_000.0, 100_000.0);
/// The tool may differ from the rig file by mm, rad and kg.
const TOOL: (f64, f64, f64) = (0.5, 0.01, 0.05);
/// At travel height the tip passes this far above the object, in mm.
const CLEAR: f64 = 10.0;

/// What is known of the arm's place and tool.
#[derive(Clone, Debug)]
pub(super) struct Setup {
    /// The base's axis in frame `table`, in mm.
    base: [f64; 2],
    strike_height: f64,
    travel_height: f64,
    /// Roll, pitch and yaw in rad.
    pub(super) orientation: [f64; 3],
    tool_offset: [f64; 6],
    payload: f64,
    /// mm/s³.
    pub(super) jerk: f64,
    /// mm/s².
    pub(super) acceleration: f64,
}

impl Setup {
    /// Of a rig file. Errors name the keys that are missing, or what the arm cannot do.
    pub(super) fn of(rig: &Rig) -> Result<Self, String> {
        let robot = &rig.robot;
        let missing: Vec<&str> = [
            ("base", robot.base.is_none()),
            ("keep_out", robot.keep_out.is_none()),
            ("reach", robot.reach.is_none()),
            ("jerk", robot.jerk.is_none()),
            ("strike_height", robot.strike_height.is_none()),
            ("travel_height", robot.travel_height.is_none()),
            ("tool_orientation", robot.tool_orientation.is_none()),
            ("tool_offset", robot.tool_offset.is_none()),
            ("payload", robot.payload.is_none()),
        ]
        .into_iter()
        .filter_map(|(key, is_missing)| is_missing.then_some(key))
        .collect();
        let (
            Some(base),
            Some(jerk),
            Some(strike_height),
            Some(travel_height),
            Some(orientation),
            Some(tool_offset),
            Some(payload),
            true,
        ) = (
            robot.base,
            robot.jerk,
            robot.strike_height,
            robot.travel_height,
            robot.tool_orientation,
            robot.tool_offset,
            robot.payload,
            missing.is_empty(),
        )
        else {
            return Err(format!(
                "the rig file's [robot] lacks {}",
                missing.join(", ")
            ));
        };
        let (speed, acceleration) = (robot.speed.high * 1e3, robot.acceleration * 1e3);
        let jerk = jerk * 1e3;
        let (most_speed, most_acceleration, most_jerk) = LIMITS;
        for (key, value, most) in [
            ("speed", speed, most_speed),
            ("acceleration", acceleration, most_acceleration),
            ("jerk", jerk, most_jerk),
        ] {
            if value > most {
                return Err(format!(
                    "robot.{key} is {value} in mm and s, the arm does {most}"
                ));
            }
        }
        let height = object_height(rig);
        let travel_height = travel_height * 1e3;
        if travel_height < height + rig.striker.radius * 1e3 + CLEAR {
            return Err(format!(
                "robot.travel_height is {travel_height} mm: the tip would not pass {CLEAR} mm above the object, which is {height} mm high"
            ));
        }
        let [x, y, z, ..] = tool_offset.map(|length| length * 1e3);
        let [_, _, _, roll, pitch, yaw] = tool_offset;
        Ok(Self {
            base: [base.x * 1e3, base.y * 1e3],
            strike_height: strike_height * 1e3,
            travel_height,
            orientation,
            tool_offset: [x, y, z, roll, pitch, yaw],
            payload,
            jerk,
            acceleration,
        })
    }

    /// A point of the table (m) at strike height, in the arm's frame, in mm.
    pub(super) fn low(&self, point: Point) -> [f64; 3] {
        self.at(point, self.strike_height)
    }

    /// The same at travel height.
    pub(super) fn high(&self, point: Point) -> [f64; 3] {
        self.at(point, self.travel_height)
    }

    fn at(&self, point: Point, height: f64) -> [f64; 3] {
        [
            point.x * 1e3 - self.base[0],
            point.y * 1e3 - self.base[1],
            height,
        ]
    }

    /// A place in the arm's frame (mm) on the table (m).
    pub(super) fn on_table(&self, place: [f64; 3]) -> Point {
        Point::new(
            (place[0] + self.base[0]) * 1e-3,
            (place[1] + self.base[1]) * 1e-3,
        )
    }

    /// Whether the controller has the rig file's tool.
    pub(super) fn check_tool(&self, status: &Status) -> Result<(), String> {
        let (far, turned, heavy) = TOOL;
        let split = |offset: [f64; 6]| {
            let [x, y, z, roll, pitch, yaw] = offset;
            ([x, y, z], [roll, pitch, yaw])
        };
        let ((place, turn), (there, turn_there)) =
            (split(self.tool_offset), split(status.tool_offset));
        let is_same = distance(place, there) <= far
            && turn
                .iter()
                .zip(turn_there)
                .all(|(a, b)| turn_between(*a, b) <= turned)
            && (self.payload - status.payload).abs() <= heavy;
        if is_same {
            return Ok(());
        }
        Err(format!(
            "the controller has the tool offset {:?} (mm, rad) and {} kg, the rig file says {:?} and {} kg; set one right",
            status.tool_offset, status.payload, self.tool_offset, self.payload
        ))
    }

    /// Whether the tool points as the rig file says.
    pub(super) fn check_orientation(&self, pose: [f64; 6]) -> Result<(), String> {
        let (_, turned, _) = TOOL;
        let [_, _, _, here @ ..] = pose;
        let is_same = self
            .orientation
            .iter()
            .zip(here)
            .all(|(a, b)| turn_between(*a, b) <= turned);
        is_same.then_some(()).ok_or_else(|| {
            format!(
                "the tool points to {here:?} rad, robot.tool_orientation is {:?}; turn it by the arm's own program first",
                self.orientation
            )
        })
    }
}

/// Height of the object, in mm.
fn object_height(rig: &Rig) -> f64 {
    let object = &rig.object;
    let half_size = object.half_size.map(|[_, _, z]| z);
    let half = half_size.or(object.half_height).or(object.radius);
    2.0 * half.unwrap_or(0.0) * 1e3
}

/// Angle in rad between two, whole turns aside.
fn turn_between(a: f64, b: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    let apart = (a - b).rem_euclid(turn);
    apart.min(turn - apart)
}
