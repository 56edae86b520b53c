//! What a check found: what was seen, what it most likely is, and the line of the rig file or the command that mends it.

use check::{Finding, Limit, Severity};
use serde::Serialize;
use values::{CommandFrame, Point, RejectReason, Rig};

/// A finding for a person.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Said {
    pub seen: String,
    pub likely: String,
    /// The line of the rig file, or what to do, that mends it.
    pub mend: String,
}

impl Said {
    pub fn sentence(&self) -> String {
        format!("{}: {}; {}", self.seen, self.likely, self.mend)
    }
}

/// A heading before the findings of this severity.
pub fn severity(severity: Severity) -> &'static str {
    match severity {
        Severity::Meaningless => "wrong",
        Severity::Doubtful => "doubtful",
        Severity::Told => "note",
    }
}

/// Difference from half a turn, in rad, within which a sign is what is wrong.
const HALF_TURN: f64 = 0.15;

pub fn say(finding: &Finding, rig: &Rig) -> Said {
    let said = |seen: String, likely: &str, mend: String| Said {
        seen,
        likely: likely.into(),
        mend,
    };
    match finding {
        Finding::Mirrored {
            log,
            strikes,
            slope,
            error,
        } => said(
            format!(
                "{}objects leave to the other side than commanded: {strikes} departure headings change by {slope:.2} ± {error:.2} rad for each rad of the command",
                of(log.as_deref())
            ),
            "the camera's picture, or the commands, are mirrored about the x axis",
            of_one(
                log.as_deref(),
                if rig.frames.mirrored {
                    "take out `mirrored = true` under [frames]".into()
                } else {
                    "state `[frames] mirrored = true`, or negate y where it is tracked".into()
                },
            ),
        ),
        Finding::AxesSwapped {
            log,
            strikes,
            slope,
            error,
        } => said(
            format!(
                "{}objects leave as if x and y were exchanged: {strikes} departure headings change by {slope:.2} ± {error:.2} rad for each rad of the command, about 45°",
                of(log.as_deref())
            ),
            "the tracker's axes are swapped",
            of_one(
                log.as_deref(),
                format!(
                    "exchange the paths: `[topics.centroid] x = \"{}\"  y = \"{}\"`, and give [table] in the same frame",
                    rig.topics.centroid.y, rig.topics.centroid.x
                ),
            ),
        ),
        Finding::Turned {
            log,
            strikes,
            by,
            mirrored,
            certain,
            origin,
        } => {
            let seen = format!(
                "{}objects leave {:.0}° to the {} of the commanded direction, in the middle of {strikes} strikes{}",
                of(log.as_deref()),
                by.abs().to_degrees(),
                if *by < 0.0 { "right" } else { "left" },
                if *mirrored {
                    ", once one of both is read mirrored"
                } else {
                    ""
                }
            );
            let of_base = rig.frames.command == CommandFrame::Base;
            let base_yaw = rig.robot.base_yaw.filter(|_| of_base);
            let by_places = origin.map_or(*by, |(_, turn)| turn);
            let turn = base_yaw_of(base_yaw.unwrap_or(0.0) + by_places);
            let base = origin.map_or(String::new(), |(origin, turn)| {
                let base = based(rig, origin, turn);
                format!("base = [{:.3}, {:.3}]  ", base.x, base.y)
            });
            let mirror = match (*mirrored, rig.frames.mirrored) {
                (true, false) => "mirrored = true  ",
                (true, true) => "mirrored = false  ",
                (false, _) => "",
            };
            let is_half = std::f64::consts::PI - by.abs() < HALF_TURN;
            let (likely, or) = match (is_half, *mirrored) {
                (true, true) => (
                    "the camera's picture, or the commands, are mirrored about the y axis",
                    "negate x where it is tracked, or where it is commanded; or ",
                ),
                (true, false) => (
                    "the commands have the opposite sign, or the arm's base, or the camera, is turned by half a turn",
                    "negate the commands where they are logged; if something is turned, ",
                ),
                (false, _) => ("the arm's base, or the camera, is turned about the table", ""),
            };
            let mend = if *certain || *mirrored {
                format!(
                    "{or}state `[frames] {mirror}command = \"base\"` and `[robot] {base}base_yaw = {turn:.3}` (measure it: strikes do not tell the base's turn from a constant error of heading, which this number would hide), or log both in the frame `table`"
                )
            } else {
                "check how the arm's base and the camera are turned on the table, and where the tip meets the object".into()
            };
            said(seen, likely, of_one(log.as_deref(), mend))
        }
        Finding::ConstantHeading {
            log,
            strikes,
            angle,
            spread,
        } => said(
            format!(
                "{}{strikes} commands all point to {:.1}°, and the objects, or the arm itself, go in directions that spread by {:.0}°",
                of(log.as_deref()),
                angle.to_degrees(),
                spread.to_degrees()
            ),
            "the command is logged in the tool's frame, which turns with the arm",
            format!(
                "log it in the frame `table`; or log the measured state ({}) and state `[frames] command = \"tool\"`",
                rig.topics.state.topic.name
            ),
        ),
        Finding::ConstantSpeed {
            log,
            strikes,
            speed,
            spread,
        } => said(
            format!(
                "{}{strikes} commands all say {speed:.2} m/s, and the objects leave at speeds that scatter by {:.0} %",
                of(log.as_deref()),
                spread * 100.0
            ),
            "a set-point is logged that never changes, and the arm's speed is set elsewhere (an override, a program)",
            "log the speed that each strike is commanded, in m/s".into(),
        ),
        Finding::SpeedAndAngle {
            log,
            strikes,
            degrees,
            exchanged,
            spread,
            spread_as_stated,
        } => {
            let topic = &rig.topics.command;
            let path = if *exchanged { &topic.x } else { &topic.y };
            let unit = if *degrees { "degrees" } else { "rad" };
            said(
                format!(
                    "{}headings of {strikes} objects follow `{path}` of {} as an angle in {unit} (they spread by {:.1}° about it), and not the direction of both fields ({:.1}°)",
                    of(log.as_deref()),
                    topic.name,
                    spread.to_degrees(),
                    spread_as_stated.to_degrees()
                ),
                "the command is logged as a speed and an angle, not as a velocity",
                format!(
                    "log the velocity's coordinates in m/s: x = speed·cos(angle), y = speed·sin(angle){}",
                    if *degrees { ", the angle in rad first" } else { "" }
                ),
            )
        }
        Finding::Jumps {
            log,
            share,
            bursts,
            ..
        } => said(
            match 100.0 * share {
                percent if percent < 1.0 => format!(
                    "{log}: {bursts} times the centroid lies for a while where another object rests, farther than any object gets, and then where it was"
                ),
                percent => format!(
                    "{log}: in {percent:.0} % of the frames the centroid lies farther from the last one than any object gets"
                ),
            },
            "the tracker jumps to and fro between two objects, or between the object and what looks like it, or writes some place where it sees nothing",
            "take the other object away, or narrow what is tracked (its colour range, `carom camera tune`; one topic for each object), and record anew".into(),
        ),
        Finding::Unrelated {
            log,
            strikes,
            correlation,
        } => said(
            format!(
                "{}what {strikes} objects do does not follow the commands: their correlation is {correlation:.2}",
                of(log.as_deref())
            ),
            "these are the commands, or the camera, of another robot or another day",
            format!(
                "check which topics these logs hold, and `[topics.command] name = \"{}\"` and `[topics.centroid] name = \"{}\"`",
                rig.topics.command.name, rig.topics.centroid.name
            ),
        ),
        Finding::ClockOffset {
            log,
            delay,
            uncertainty,
            strikes,
            certain,
        } => said(
            format!(
                "{log}: objects move {delay:.2} s (± {uncertainty:.2}) {} the commands that strike them, {strikes} times",
                if *delay < 0.0 { "before" } else { "after" }
            ),
            "the camera's clock and the arm's differ",
            if delay.abs() > 3600.0 {
                "stamp both by one clock: one counts from another moment (since it was switched on, and since 1970)".into()
            } else {
                format!(
                "set both by one clock; or state `[frames] camera_delay = {:.2}`{}",
                delay + rig.frames.camera_delay,
                if *certain {
                    ""
                } else {
                    " (tracks are timed from first motion, and are not moved by it)"
                }
                )
            },
        ),
        Finding::ClockStep {
            log,
            strike,
            by,
            error,
            untimely,
            by_touch,
        } => said(
            match by_touch {
                true => format!(
                    "{log}: from its strike {strike} on the camera sees objects move {:.0} ms (± {:.0}) {} after the tip's touch, by its measured place, than before",
                    by.abs() * 1e3,
                    2.0 * error * 1e3,
                    if *by < 0.0 { "sooner" } else { "later" },
                ),
                false => format!(
                    "{log}: from its strike {strike} on objects move {:.2} s {} after their commands than before{}",
                    by.abs(),
                    if *by < 0.0 { "sooner" } else { "later" },
                    match untimely {
                        0 => String::new(),
                        n => format!(", {n} of them when no strike of theirs is looked for"),
                    }
                ),
            },
            "the clock of the camera or of the arm was set while the log ran, or the tip starts farther away",
            "have both machines keep one time (NTP, PTP) before a log begins; cut this log there, and state `[frames] camera_delay` for the part that is late".into(),
        ),
        Finding::ClockDrift {
            log,
            rate,
            drifted,
            certain,
            by_touch,
        } => said(
            format!(
                "{log}: the time from {} to motion changes by {:.2} ms a minute, {:.0} ms over the log",
                match by_touch {
                    true => "the tip's touch, by its measured place,",
                    false => "command",
                },
                rate * 60e3,
                drifted * 1e3
            ),
            &match certain {
                true => format!(
                    "the camera's clock runs {:.1} % {} than the arm's, or stamps are counted from frames at a rate that is not the camera's",
                    rate.abs() * 100.0,
                    if *rate < 0.0 { "slower" } else { "faster" }
                ),
                false => "the camera's clock and the arm's run at different rates".into(),
            },
            "set both by one clock (NTP, PTP) while recording".into(),
        ),
        Finding::NothingMoves {
            log,
            commands,
            moved,
            motions,
        } => said(
            format!(
                "{log}: of {commands} commands {moved} are followed by a motion of the object; it moves {motions} times"
            ),
            "the arm missed, another object was tracked, or commands and centroids are not of one session",
            "look at both topics in a viewer, and record anew".into(),
        ),
        Finding::OtherTimes {
            log,
            commands,
            followed,
            struck,
        } => said(
            format!(
                "{log}: {followed} of {commands} commands are followed by a motion, and {struck} times objects are struck when nothing is commanded"
            ),
            "commands and centroids are not of one session, or their clocks do not run alike",
            "look at both topics in a viewer, and record them into one log".into(),
        ),
        Finding::StateClock {
            log,
            behind,
            strikes,
        } => {
            let state = &rig.topics.state.topic.name;
            said(
                format!(
                    "{log}: by {state} the arm moves {:.0} ms {} it is commanded to, over {strikes} strikes, and the camera sees objects move at the commands' time",
                    behind.abs() * 1e3,
                    if *behind < 0.0 { "before" } else { "after" }
                ),
                &format!("the clock of {state} is another than that of the commands and the camera"),
                "stamp the state by the commands' clock, and record anew; or let it be, by another name under [topics.state]: the state is read where it is there, and needed by nothing (`camera_delay` moves the camera, which is right)".into(),
            )
        }
        Finding::Delivers {
            log,
            share,
            strikes,
        } => {
            let (command, state) = (&rig.topics.command.name, &rig.topics.state.topic.name);
            let is_in_kmh = |times: f64| (times / 3.6 - 1.0).abs() < 0.05;
            let (likely, mend) = match (is_in_kmh(1.0 / share), is_in_kmh(*share)) {
                (true, _) => ("the commands are in km/h".into(), format!("give {command} in m/s")),
                (_, true) => (
                    format!("the velocities of {state} are in km/h"),
                    format!("give {state} in m/s"),
                ),
                _ => (
                    "commands and measured velocities are not in one unit, or an override is set that the commands do not hold".into(),
                    format!("give {command} and {state} in m/s; log what the arm is told"),
                ),
            };
            said(
                format!(
                    "{}by its measured state the arm moves at {share:.3} times the commanded speed, in the middle of {strikes} strikes",
                    of(log.as_deref())
                ),
                &likely,
                of_one(log.as_deref(), mend),
            )
        }
        Finding::EncoderDelay { log, delay, .. } => {
            let [seconds, error] = delay.seconds;
            let side = if seconds < 0.0 { "before" } else { "after" };
            said(
                format!(
                    "{}by its measured place the tip touches the object, and {:.1} ms (± {:.1}) {side} that the camera sees it move, over {} strikes{}",
                    of(log.as_deref()),
                    seconds.abs() * 1e3,
                    2.0 * error * 1e3,
                    delay.strikes,
                    delay.reach.map_or(String::new(), |[reach, error]| format!(
                        " of several speeds, which leave {:+.1} mm (± {:.1}) for the radii of both",
                        reach * 1e3,
                        2.0 * error * 1e3
                    ))
                ),
                if delay.reach.is_some() {
                    "the camera's stamps and the encoders' differ by this, whichever of them is off"
                } else {
                    "the camera's stamps and the encoders' differ by this, whichever of them is off, or the sizes of both together are off"
                },
                of_one(log.as_deref(), format!(
                    "state `[frames] camera_delay = {:.4}`, which brings both together (± {:.4}{}){}",
                    seconds + rig.frames.camera_delay,
                    2.0 * error,
                    match seconds > 0.0 {
                        true =>
                            format!("; up to {:.3} of it may be a soft tip's contact", check::CONTACT),
                        false => String::new(),
                    },
                    if delay.reach.is_some() {
                        ""
                    } else {
                        ", or measure the object and striker.radius"
                    }
                )),
            )
        }
        Finding::Scaled {
            log,
            scale,
            error,
            strikes,
        } => {
            /// The tip's places are in another unit where they lie so many times as far apart.
            const MILLIMETRES: std::ops::Range<f64> = 0.0005..0.002;
            let is_in_mm = MILLIMETRES.contains(scale);
            said(
                format!(
                    "{}by the tip's measured places the camera's are {} (± {}) times as far apart, over {strikes} strikes",
                    of(log.as_deref()),
                    match is_in_mm {
                        true => significant(*scale),
                        false => format!("{scale:.3}"),
                    },
                    significant(2.0 * error)
                ),
                if is_in_mm {
                    "the tip's measured places are in mm, not in m"
                } else {
                    "the camera's scale is wrong: its calibration, or the height that it was made for"
                },
                if is_in_mm {
                    let state = &rig.topics.state;
                    format!(
                        "give `{}` and `{}` of {} in m",
                        state.position_x, state.position_y, state.topic.name
                    )
                } else {
                    format!(
                        "calibrate the camera anew (`carom camera calibrate`), or give {} in m",
                        rig.topics.centroid.name
                    )
                },
            )
        }
        Finding::Bent { strikes } => said(
            format!("over {strikes} strikes the camera's lengths differ from place to place, by the tip's measured places"),
            "its lens bends the picture, or the camera leans",
            "correct it where places are measured (`carom camera calibrate`); a diagnosis names it where strikes show it".into(),
        ),
        Finding::TwoSources { log, apart } => said(
            format!(
                "{log}: a resting object's centroids lie at two places in turn, {:.1} mm apart",
                1e3 * apart
            ),
            "two cameras or trackers write to one topic",
            format!("record one of them as {}", rig.topics.centroid.name),
        ),
        Finding::SlowStamps { log, times, error } => said(
            format!(
                "{}by the recorder's clock the stamps of {} go {:.1} % (± {}) too {}, beside those of the arm",
                of(log.as_deref()),
                rig.topics.centroid.name,
                100.0 * (times - 1.0).abs(),
                significant(200.0 * error),
                if *times > 1.0 { "slowly" } else { "fast" }
            ),
            "frames are stamped by a rate that the camera does not have, or one of two clocks runs wrong: friction would be off by twice as much",
            "stamp frames by the clock as they are taken, and record anew".into(),
        ),
        Finding::CommandFrame { log, strikes, by } => said(
            format!(
                "{}the arm moves {:.1}° beside its commands, by its measured velocity, and {strikes} objects leave as it moves",
                of(log.as_deref()),
                by.to_degrees()
            ),
            "the command is logged in another frame than the arm's state",
            "log both in one frame; or state `[frames] command = \"tool\"`: then the measured motion stands for the commanded direction".into(),
        ),
        Finding::StateFrame { beside, strikes } => said(
            format!(
                "as {strikes} objects begin to move, the arm's measured velocity points {:.0}° beside the way that its measured place goes, in the middle",
                beside.to_degrees()
            ),
            "the velocity is told in the tool's frame (the child frame of nav_msgs/msg/Odometry), and the place in the table's",
            "log both in the frame `table`: turn the velocity by the orientation of the tool".into(),
        ),
        Finding::StateBeside { beside, strikes } => said(
            format!(
                "as {strikes} objects begin to move, the arm's measured velocity points {:.0}° beside its commands, in the middle, and objects leave as \
                 commanded",
                beside.to_degrees()
            ),
            "the state is mirrored, its axes are exchanged, or it is that of other strikes",
            "log the arm's state in the frame `table`, as its commands are".into(),
        ),
        Finding::Displaced {
            by,
            turn,
            away,
            strikes,
            ..
        } => said(
            format!(
                "as {strikes} objects begin to move, the tip's measured places lie {:.0} mm away from where it would touch them{}",
                away * 1e3,
                match *turn {
                    0.0 => String::new(),
                    turn => format!(", turned by {:.1}°", turn.to_degrees()),
                }
            ),
            match *turn {
                0.0 => {
                    "the camera's frame and the arm's have other origins, or the measured place is the flange's and not the tip's"
                }
                _ => "the camera's frame and the arm's are turned about one another",
            },
            {
                let of_base = rig.frames.command == CommandFrame::Base;
                let base = based(rig, *by, *turn);
                let yaw = rig.robot.base_yaw.filter(|_| of_base).unwrap_or(0.0);
                format!(
                    "state `[frames] command = \"base\"` and `[robot] base = [{:.3}, {:.3}]  base_yaw = {:.3}`, or log the tip's place in the frame `table`",
                    base.x,
                    base.y,
                    base_yaw_of(yaw + turn)
                )
            },
        ),
        Finding::DisplacedApart {
            log,
            strike,
            by,
            error,
            strikes,
            ..
        } => said(
            format!(
                "{log}: {}the camera sees objects {:.0} mm (± {:.1}) away from where it {}, by the tip's measured places over {strikes} strikes",
                strike.map_or(String::new(), |strike| format!("from its strike {strike} on ")),
                by.norm() * 1e3,
                2.0 * error * 1e3,
                match strike {
                    Some(_) => "saw them before",
                    None => "sees those of the other logs",
                }
            ),
            match strike {
                Some(_) => "the camera, or the arm's base, was moved while the log ran",
                None => "the camera, or the arm's base, was moved between the sessions",
            },
            match strike {
                Some(_) => "calibrate the camera's pose anew, and log again: strikes before and after are of two set-ups".into(),
                None => "calibrate the camera's pose anew, and give this log a rig file and a run of its own".into(),
            },
        ),
        Finding::Radii {
            longer,
            error,
            strikes,
            by_touch,
        } => {
            let object = rig.object.solid.radius().unwrap_or_default() + longer;
            let tip = rig.striker.radius + longer;
            let either: Vec<String> = [("object", object), ("striker", tip)]
                .iter()
                .filter(|(_, radius)| *radius > 0.0)
                .map(|(part, radius)| format!("`[{part}] radius = {radius:.4}`"))
                .collect();
            let (by, mend) = match by_touch {
                true => (
                    format!("some {:.0} mm", longer.abs() * 1e3),
                    "measure both, state `[object] radius` and `[striker] radius`, and check again: without a command touches are sought where the stated radii put them, so that they may be twice as far off, or farther".into(),
                ),
                false => (
                    format!("{:.1} mm (± {:.1})", longer.abs() * 1e3, 2.0 * error * 1e3),
                    format!("measure both, and the tool point; where a size is off, state {}", either.join(" or ")),
                ),
            };
            said(
                format!(
                    "by its measured place the tip touches objects {by} {} than both radii allow, over {strikes} strikes of several speeds",
                    if *longer > 0.0 { "earlier" } else { "later" }
                ),
                "the object's size, or the tip's, or the tool point that the state gives along the way, is not what the rig file states",
                mend,
            )
        }
        Finding::Reach {
            apart,
            error,
            stated,
            hits,
        } => said(
            format!(
                "{hits} times the tip pushes the object where their centres are {:.1} mm (± {:.1}) apart; both radii make {:.1} mm",
                apart * 1e3,
                2.0 * error * 1e3,
                stated * 1e3
            ),
            "the object's size, or the tip's, is not what the rig file states: touches, which tell of strikes where no command is logged, are not seen",
            format!(
                "measure both, and state `[object] radius` and `[striker] radius`, which make {apart:.4} together"
            ),
        ),
        Finding::OtherCommands {
            log,
            by,
            others,
            strikes,
            first,
        } => {
            let places = match by.unsigned_abs() {
                1 => String::new(),
                places => format!("{places} places "),
            };
            let side = if *by > 0 { "after" } else { "before" };
            said(
                format!(
                    "{log}: {others} of {strikes} objects, from strike {first} on, leave as the command {places}{side} their own says, and not as their own"
                ),
                "a command was logged twice, or not at all, or the log's writer queued them: from there on each strike has another's",
"look there in a viewer, mend what writes the log, and record these strikes anew or cut them out".into(),
            )
        }
        Finding::Strays {
            log,
            strays,
            strikes,
            from,
            until,
            ..
        } => said(
            format!(
                "{log}: {strays} of {strikes} objects leave by more than 40° elsewhere than the others do for their commands, from {from:.0} to {until:.0} s after the first"
            ),
            "hands moved them (a command that was given up), a clock was set in between, or these commands belong to other strikes",
            "look at them in a viewer, and record them anew or cut them out".into(),
        ),
        Finding::Scale {
            ratio,
            strikes,
            topic,
        } => {
            /// Ratios of speeds that impacts give.
            const GIVEN: std::ops::Range<f64> = 0.4..2.3;
            let command = &rig.topics.command.name;
            let unit = [("mm", 1e3), ("cm", 1e2)].into_iter().find_map(|(unit, in_a_metre)| {
                if GIVEN.contains(&(ratio * in_a_metre)) {
                    Some((format!("the commands are in {unit}/s"), format!("give {command} in m/s")))
                } else if GIVEN.contains(&(ratio / in_a_metre)) {
                    Some((format!("the centroids are in {unit}"), format!("give {topic} in m")))
                } else {
                    None
                }
            });
            let (likely, mend) = unit.unwrap_or_else(|| (
                "centroids and commands are not in one unit, or the clocks do not run alike".into(),
                format!("give {topic} in m and {command} in m/s"),
            ));
            said(
                format!(
                    "objects leave at {} times the commanded speed, in the middle of {strikes} strikes; an impact gives 2 at the most",
                    significant(*ratio)
                ),
                &likely,
                mend,
            )
        }
        Finding::OutsideLimits {
            log,
            ratio,
            others,
            commanded,
            limit,
            outside,
            strikes,
            low,
            high,
        } => {
            /// km/h in a m/s; and ratio of an object's speed to a tip's that few impacts give.
            const KMH: f64 = 3.6;
            const WEAK: f64 = 0.7;
            let (key, unit, stated) = match limit {
                Limit::Speed => ("speed", "m/s", rig.robot.speed),
                Limit::Angle => ("angle", "rad", rig.robot.angle),
            };
            let speed = &rig.robot.speed;
            let is_kmh = *limit == Limit::Speed
                && *low > 0.9 * KMH * speed.low
                && *high < 1.1 * KMH * speed.high
                && ratio.is_some_and(|ratio| ratio < WEAK);
            let seen = format!(
                    "{}{outside} of {strikes} {} lie outside `robot.{key}` = [{}, {}] {unit}: they go from {low:.3} to {high:.3}{}",
                    of(log.as_deref()),
                    if *commanded {
                        "commands"
                    } else {
                        "strikes, as they were delivered,"
                    },
                    stated.low,
                    stated.high,
                    match (ratio, others) {
                        (Some(ratio), Some(others)) => format!(
                            ", and objects leave at {ratio:.2} times the commanded speed, and at {others:.2} times in the other logs"
                        ),
                        (Some(ratio), None) if is_kmh => format!(
                            ", and objects leave at {ratio:.2} times the commanded speed"
                        ),
                        _ => String::new(),
                    }
            );
            match (is_kmh, log) {
                (true, _) => said(
                    seen,
                    "the commands are in km/h",
                    format!("give {} in m/s", rig.topics.command.name),
                ),
                (false, Some(_)) => said(
                    seen,
                    "its commands are in another unit, or another robot's",
                    format!("give {} in m/s in every session", rig.topics.command.name),
                ),
                (false, None) => said(
                    seen,
                    "these logs are another robot's, or the rig file states the limits of another",
                    format!(
                        "state what this arm may be commanded: `[robot] {key} = [{low:.2}, {high:.2}]`"
                    ),
                ),
            }
        }
        Finding::MostlyRejected {
            log,
            rejected,
            seen,
            reason,
            count,
            detail,
        } => said(
            format!(
                "{log}: {rejected} of {seen} strikes were rejected, {count} as {}, such as: {detail}",
                reason.name()
            ),
            rejected_for(*reason),
            match reason {
                RejectReason::UnitsImplausible => format!(
                    "give {} in m and {} in m/s",
                    rig.topics.centroid.name, rig.topics.command.name
                ),
                RejectReason::OffTable => format!(
                    "give `[table] x` and `y` in the frame of {} (x away from the robot, y to its left); `carom rig init --from` this log proposes bounds",
                    rig.topics.centroid.name
                ),
                RejectReason::ClockBackwards if rejected == seen => format!(
                    "have the drivers of {} and {} fill in `{}` from one running clock, and record anew",
                    rig.topics.centroid.name, rig.topics.command.name, rig.topics.centroid.stamp
                ),
                _ => "`carom run` goes on with the others; rejects.parquet has every one".into(),
            },
        ),
        Finding::BaseTurns { base_yaw, left } => said(
            format!(
                "`robot.base_yaw` = {base_yaw:.3} turns the commands, and objects leave {:.1}° beside them, in the middle",
                left.to_degrees()
            ),
            "a constant error of heading (a bias of the arm, a turned camera, a tip beside the middle) that this number was taken from is part of it, and no diagnosis will name it",
            "measure how the base stands on the table, and take it from no strikes".into(),
        ),
        Finding::Fence { fence, bounces } => said(
            format!(
                "{bounces} times objects are turned round, or led along, at the line from ({:.3}, {:.3}) to ({:.3}, {:.3}) m",
                fence.from.x, fence.from.y, fence.to.x, fence.to.y
            ),
            "a fence that the rig file does not state: tracks end there, as contacts",
            format!(
                "state it, so that it stays where it is: `[[table.fences]] from = [{:.3}, {:.3}]  to = [{:.3}, {:.3}]`",
                fence.from.x, fence.from.y, fence.to.x, fence.to.y
            ),
        ),
        Finding::Noise { measured, stated } => said(
            format!(
                "a resting object's centroid scatters by {:.2} mm, and the rig file says {:.2} mm",
                measured * 1e3,
                stated * 1e3
            ),
            "`camera.noise` was not measured on this rig",
            format!("state `[camera] noise = {measured:.5}`"),
        ),
        Finding::LostFrames { share } => said(
            format!(
                "in {:.0} % of the frames the tracker saw nothing",
                share * 100.0
            ),
            "the object is hidden at times, by the arm or the light",
            "move the camera, or check the colour range (`carom camera tune`)".into(),
        ),
        Finding::Gathering { times, strikes } => said(
            format!(
                "70 ms after they begin to move objects are {times:.1} times as fast as at first, in the middle of {strikes} strikes"
            ),
            "the tracker smooths its places (a filter or a mean over frames), or the tip goes on pushing and lets go late",
            "log places as they are measured, without a filter; have the tip hold its speed until it has struck, and then brake".into(),
        ),
        Finding::Swelling {
            seconds,
            gains_speed,
            strikes,
        } => said(
            format!(
                "objects begin to move little by little, as a sudden start looks through a filter of {:.0} ms, in the middle of {strikes} strikes",
                seconds * 1e3
            ),
            match gains_speed {
                true => {
                    "the tracker filters its places, which then follow the object late (an exponential mean, a Kalman filter), or its exposure is long, or the tip pushes the object for a while"
                }
                false => {
                    "the tracker filters its places (an exponential mean, a Kalman filter), or objects brake less right after they are struck than later, or the lens distorts"
                }
            },
            match gains_speed {
                true => "log places as they are measured, without a filter".into(),
                false => {
                    "log places as they are measured, without a filter; if they are, let the diagnosis say what brakes".into()
                }
            },
        ),
        Finding::SessionTurned {
            log,
            by,
            error,
            strikes,
        } => said(
            format!(
                "{log}: objects leave {:.1}° (± {:.1}) to the {} of those of the other logs, for the same commands, over {strikes} strikes",
                by.abs().to_degrees(),
                2.0 * error.to_degrees(),
                if *by < 0.0 { "right" } else { "left" }
            ),
            "the camera, or the arm's base, was moved between the sessions",
            "calibrate the camera's pose anew, and give this log a rig file and a run of its own".into(),
        ),
        Finding::TurnedWithin {
            log,
            strike,
            by,
            error,
        } => said(
            format!(
                "{log}: from its strike {strike} on objects leave {:.1}° (± {:.1}) to the {} of those before, for the same commands",
                by.abs().to_degrees(),
                2.0 * error.to_degrees(),
                if *by < 0.0 { "right" } else { "left" }
            ),
            "the camera, or the arm's base, was moved while the log ran",
            "calibrate the camera's pose anew, and log again: strikes before and after are of two set-ups".into(),
        ),
        Finding::SpeedWithin {
            log,
            strike,
            times,
            error,
        } => said(
            format!(
                "{log}: from its strike {strike} on objects leave {times:.2} (± {:.2}) times as fast as those before, for the same commanded speeds",
                2.0 * error
            ),
            "speeds are commanded in another unit, or through an override, or the camera's scale, the tip or the object was changed, while the log ran",
            "log what the arm is told, in m/s, and log again: strikes before and after are of two set-ups".into(),
        ),
        Finding::InPart {
            log,
            first,
            last,
            what,
        } => {
            let what = say(what, rig);
            said(
                format!("{log}, strikes {first} to {last} alone: {}", what.seen),
                &what.likely,
                format!(
                    "the other strikes do not say so: cut the log there, and give this part a run of its own, by a rig file of its own; there {}",
                    what.mend
                ),
            )
        }
        Finding::SessionSpeed {
            log,
            times,
            strikes,
            certain,
        } => said(
            format!(
                "{log}: objects leave {times:.2} times as fast as those of the other logs, for the same commanded speeds, over {strikes} strikes"
            ),
            match certain {
                true => "its speeds are logged in another unit, or before an override that the other logs do not have",
                false => "its speeds are logged before an override, its camera has another scale, or another tip or object was used",
            },
            "log what the arm is told, in m/s, in every session; or give this log a run of its own".into(),
        ),
        Finding::Density { density } => said(
            format!(
                "the stated sizes and mass of the object make {} kg/m³",
                significant(*density)
            ),
            "a length or the mass is in another unit, or a diameter stands for a radius",
            "measure `[object]`: lengths in m, the mass in kg".into(),
        ),
        Finding::FewStrikes { strikes } => said(
            format!("{strikes} strikes began a motion"),
            "that is enough for a look, and few for a model: 81 % are learnt from, the others judge",
            "record 100 (8 held-out strikes judge a first version, and of 80 strikes 8 or more are held out in 99 of 100 runs); `carom collect` spreads them over speed, angle and table".into(),
        ),
        Finding::OneSpeed { speed } => said(
            format!("all strikes have nearly one speed, {speed:.2} m/s"),
            "what depends on speed (drag, friction that weakens, restitution that falls) cannot be told apart",
            format!(
                "strike from {} to {} m/s",
                rig.robot.speed.low, rig.robot.speed.high
            ),
        ),
        Finding::OneAngle { angle } => said(
            format!("all strikes have nearly one angle, {angle:.2} rad"),
            "an error of the arm's angle cannot be told from a camera that is turned, nor grain from friction",
            format!(
                "strike from {} to {} rad",
                rig.robot.angle.low, rig.robot.angle.high
            ),
        ),
        Finding::OnePlace { extent } => said(
            format!("all strikes begin within {:.0} mm", extent * 1e3),
            "what depends on the place (patches, bowls, a camera's lens) cannot be told apart",
            "put the object all over the table".into(),
        ),
        Finding::NoRepeats => said(
            "no strike repeats another's command from its place".into(),
            "the scatter of repeats, which no model can better, is then estimated from neighbours",
            "repeat three strikes a few times each".into(),
        ),
    }
}

/// With two digits that count.
fn significant(value: f64) -> String {
    let places = if value.abs() < 0.1 { 5 } else { 2 };
    format!("{value:.places$}")
}

fn of(log: Option<&str>) -> String {
    log.map_or(String::new(), |log| format!("{log}: "))
}

/// The arm's base, in m, where its origin lies here in the camera's frame beside what is stated, about which it is turned (rad).
fn based(rig: &Rig, origin: Point, turn: f64) -> Point {
    let of_base = rig.frames.command == CommandFrame::Base;
    let stated = rig.robot.base.filter(|_| of_base).unwrap_or_default();
    origin + stated.rotated(turn)
}

/// A turn of the base as the rig file takes it: rounded, no more than half a turn.
fn base_yaw_of(turn: f64) -> f64 {
    let most = std::f64::consts::PI - 1e-3;
    check::wrapped(turn).clamp(-most, most)
}

/// What mends one log alone would spoil the others.
fn of_one(log: Option<&str>, mend: String) -> String {
    match log {
        None => mend,
        Some(_) => format!(
            "the other logs do not say so: give this one a run of its own, by a rig file of its own; there {mend}"
        ),
    }
}

fn rejected_for(reason: RejectReason) -> &'static str {
    match reason {
        RejectReason::OffTable => {
            "the table's bounds are in another frame than the centroids, or the axes are swapped"
        }
        RejectReason::ClockSkew => "the clocks of camera and arm differ",
        RejectReason::ClockBackwards => {
            "a topic's stamps go back, or stand still: its driver was started anew, or writes none"
        }
        RejectReason::NoMotion => "the arm missed, or another object was tracked",
        RejectReason::NoRestBefore => "objects were struck before they rested half a second",
        RejectReason::NoRestAfter => "objects were taken away, or logs end, before they rest",
        RejectReason::FramesMissing => "the tracker loses the object",
        RejectReason::NotFinite => "commands are no number: what commands the arm writes them",
        RejectReason::UnitsImplausible => "a topic is in another unit",
        RejectReason::Duplicate => "the same recordings were given twice",
        RejectReason::Truncated => "the files are cut off or damaged",
        RejectReason::NoPlateau => "commands are logged too seldom, or never hold a speed",
    }
}
