//! What a check finds, as data.

use ingest::Seen;
use serde::{Deserialize, Serialize};
use values::{Fence, Point, Reject, RejectReason};

/// A log as it was read.
#[derive(Clone, Debug)]
pub struct LogRead<'a> {
    /// Its name.
    pub name: &'a str,
    /// Commands and motions.
    pub seen: &'a Seen,
    /// Strikes kept.
    pub kept: usize,
    /// Strikes rejected.
    pub rejects: Vec<&'a Reject>,
}

#[cfg(test)]
impl<'a> LogRead<'a> {
    /// For tests, a log of forty strikes, all kept.
    pub(crate) fn made(seen: &'a Seen) -> Self {
        Self {
            name: "one.mcap",
            seen,
            kept: 40,
            rejects: Vec::new(),
        }
    }
}

/// What a check found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// What is wrong, doubtful or worth knowing.
    pub findings: Vec<Finding>,
    /// What was measured.
    pub measured: Measured,
}

impl Check {
    /// Whether a model of these logs would be meaningless.
    pub fn is_meaningless(&self) -> bool {
        self.findings
            .iter()
            .any(|f| f.severity() == Severity::Meaningless)
    }

    /// By how much (s) the camera's stamps lie farther behind the arm's than stated, where too far for touches to be seen at their time: as commands
    /// or touches tell it.
    pub fn rough_delay(&self) -> Option<f64> {
        let long = self.findings.iter().find_map(|finding| match finding {
            Finding::EncoderDelay {
                log: None, delay, ..
            } => Some(delay.seconds[0]),
            _ => None,
        });
        let offsets = self.findings.iter().filter_map(|finding| match finding {
            Finding::ClockOffset {
                delay,
                uncertainty,
                certain: true,
                ..
            } => Some((*delay, *uncertainty)),
            _ => None,
        });
        let offsets: Vec<(f64, f64)> = offsets.collect();
        let (first, within) = *offsets.first().unwrap_or(&(0.0, 0.0));
        // Each log's, and the same.
        let is_one = offsets
            .iter()
            .all(|(delay, _)| (delay - first).abs() < within);
        let mean = offsets.iter().map(|o| o.0).sum::<f64>() / offsets.len() as f64;
        long.filter(|seconds| seconds.abs() > TOO_LONG)
            .or((!offsets.is_empty() && is_one).then_some(mean))
    }

    /// This check with what another one tells, of the same logs read with a camera that is late by `rough` (s) more than stated: the delay as touches
    /// tell it, and the rest beside it. None where they do not tell it.
    pub fn refined(rough: f64, by: Self) -> Option<Self> {
        let Delay {
            seconds: [left, error],
            ..
        } = by.measured.encoder_to_camera?;
        let is_clocks = |f: &Finding| {
            matches!(
                f,
                Finding::EncoderDelay { .. } | Finding::ClockOffset { .. }
            )
        };
        let is_told = left.abs() < TOO_LONG;
        let mut check = by;
        let delay = check.measured.encoder_to_camera.as_mut()?;
        delay.seconds = [rough + left, error];
        let first = Finding::EncoderDelay {
            log: None,
            delay: *delay,
            misleads: true,
        };
        check.findings.retain(|finding| !is_clocks(finding));
        check.findings.insert(0, first);
        is_told.then_some(check)
    }
}

/// What was measured of the logs together; none where they do not tell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Commands with the motion that each began.
    pub paired: usize,
    /// Median of departure heading less commanded angle, in rad.
    pub turn: Option<f64>,
    /// Median ratio of the object's launch speed to the commanded speed.
    pub speed_ratio: Option<f64>,
    /// Time, in s, from a command's rise to the object's first motion.
    pub rise_to_motion: Option<f64>,
    /// Delay from the tip's touching the object, by the measured state, to the object's first motion.
    pub encoder_to_camera: Option<Delay>,
    /// Standard deviation of a resting centroid's coordinate, in m.
    pub noise_at_rest: Option<f64>,
    /// Share of the frames in which the tracker saw nothing.
    pub frames_lost: f64,
    /// What the strikes cover.
    pub coverage: Coverage,
}

/// How far the camera's stamps lie behind the arm's, and how far off the reach of tip and object is: what shifts every touch by one time, and
/// what shifts it by one length. Values with their standard errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Delay {
    /// The delay and its standard error, in s; with the reach as stated, where speeds do not tell both.
    pub seconds: [f64; 2],
    /// Excess of both radii together over the stated ones, and its standard error, in m; none where speeds do not tell.
    pub reach: Option<[f64; 2]>,
    /// Number of strikes that show it.
    pub strikes: usize,
}

impl Delay {
    /// Whether the delay is significant, and more than a touch's moment is known to, or than the contact itself explains.
    pub fn is_sure(&self) -> bool {
        let [seconds, error] = self.seconds;
        let by_contact = if seconds > 0.0 { CONTACT } else { 0.0 };
        seconds.abs() > (by_contact + SURE * error).max(LEAST)
    }

    /// Whether the tip is looked up at a moment at which its speed is not that of the touch: before it has its speed, or long after. In logs without
    /// commands (`by_touches`) it is looked up earlier by the delay.
    pub(crate) fn misleads(&self, by_touches: bool) -> bool {
        let seconds = self.seconds[0];
        seconds.abs() > TOO_LONG || (seconds < -TOO_EARLY && !by_touches)
    }
}

/// Standard errors from which a delay is told, and the least one, in s; from the next one on a model may suffer from it: a strike's clock is
/// fitted up to a frame.
const SURE: f64 = 3.0;
const LEAST: f64 = 0.003;
/// Greatest time, in s, after the touch at which a line through an object's first frames meets its rest, where clocks agree: half of the time that a
/// contact lasts, which is 10 ms of a soft tip.
pub const CONTACT: f64 = 0.005;
const LONG: f64 = 0.01;
/// Time, in s, after the touch from which a tip is some centimetres past the object, and brakes: what it delivered is not known then.
const TOO_LONG: f64 = 0.03;
/// Time, in s, before the touch from which a tip still gathers speed: errors of the arm are then named that are none.
const TOO_EARLY: f64 = 0.008;

/// Turn, in rad, beyond which no effect of the library can explain it (a bias of the arm, up to 0.3 rad, with an offset of the tip).
pub const TURNED: f64 = 0.21;
/// Ratio of launch speeds from one strike to the next that nothing but another set-up makes: ways, which go by the square of the speed, are a third
/// longer.
const FASTER: f64 = 1.15;
/// Least number of strikes at another time that are no chance.
const FEWEST_UNTIMELY: usize = 6;
/// Ratio of an object's speed 70 ms after it began to move to its speed at first, from which it was not struck, or is not seen as it moves.
const PUSHED: f64 = 1.5;

/// Time constant (s) of a filter from which launches, and friction, are others.
const SMEARED: f64 = 0.015;

/// Error of the camera's scale from which friction, which goes by it, is another.
pub(crate) const SCALED: f64 = 0.03;

/// How grave a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// Good to know.
    Told,
    /// A model may suffer from it.
    Doubtful,
    /// A model would be meaningless.
    Meaningless,
}

/// Which limit of the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// `robot.speed`, in m/s.
    Speed,
    /// `robot.angle`, in rad.
    Angle,
}

/// One thing that a check found. Angles in rad, times in s, lengths in m; `log` is none where all logs say it together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "finding", rename_all = "snake_case")]
#[expect(
    missing_docs,
    reason = "fields are named as the quantities that they are"
)]
pub enum Finding {
    /// Objects leave to the other side than commanded.
    Mirrored {
        log: Option<String>,
        strikes: usize,
        slope: f64,
        error: f64,
    },
    /// Objects leave as if x and y were exchanged.
    AxesSwapped {
        log: Option<String>,
        strikes: usize,
        slope: f64,
        error: f64,
    },
    /// Objects leave turned by an angle against the command, `mirrored` besides; `certain` where no effect of an arm could be so large. The tip's
    /// measured places, where they say the same, also tell where the arm's origin lies in the camera's frame, and the turn that goes with it.
    Turned {
        log: Option<String>,
        strikes: usize,
        by: f64,
        mirrored: bool,
        certain: bool,
        #[serde(default)]
        origin: Option<(Point, f64)>,
    },
    /// Objects leave as the arm moves, by its measured velocity, and both are turned by this (rad) against the command.
    CommandFrame {
        log: Option<String>,
        strikes: usize,
        by: f64,
    },
    /// The command has one angle, and objects leave in many: a frame that turns with the arm.
    ConstantHeading {
        log: Option<String>,
        strikes: usize,
        angle: f64,
        spread: f64,
    },
    /// The command has one speed, in m/s, and objects leave at many: `spread` is the standard deviation of their logarithm.
    ConstantSpeed {
        log: Option<String>,
        strikes: usize,
        speed: f64,
        spread: f64,
    },
    /// Objects leave as if the command's first field were the speed and its second the angle (`exchanged`: the other way about).
    SpeedAndAngle {
        log: Option<String>,
        strikes: usize,
        degrees: bool,
        exchanged: bool,
        spread: f64,
        spread_as_stated: f64,
    },
    /// Centroids jump from one frame to the next farther than any object gets, in this part of the frames that are kept; so many times they lay for a
    /// while at another object, and these frames are left out. `certain` where no track is one object's.
    Jumps {
        log: String,
        share: f64,
        bursts: u64,
        certain: bool,
    },
    /// Neither heading nor speed of the objects follows the commands.
    Unrelated {
        log: Option<String>,
        strikes: usize,
        correlation: f64,
    },
    /// From strike `first` on (1 is the log's first), `others` objects in a row leave as the command `by` places after their own says.
    OtherCommands {
        log: String,
        by: isize,
        others: usize,
        strikes: usize,
        first: usize,
    },
    /// Motions come at a constant time beside their commands that no strike takes; `certain` where strikes are lost by it.
    ClockOffset {
        log: String,
        delay: f64,
        uncertainty: f64,
        strikes: usize,
        certain: bool,
    },
    /// The clocks drift apart, in s a second; `certain` where strikes are lost by it. `by_touch` where the time after the tip's touch, by its
    /// measured place, tells it, and not that after the command.
    ClockDrift {
        log: String,
        rate: f64,
        drifted: f64,
        certain: bool,
        #[serde(default)]
        by_touch: bool,
    },
    /// From this strike of a log on objects move so many s later after their commands, or sooner; `untimely` strikes at a time at which none is
    /// looked for. `by_touch` as above.
    ClockStep {
        log: String,
        strike: usize,
        by: f64,
        error: f64,
        untimely: usize,
        #[serde(default)]
        by_touch: bool,
    },
    /// After most commands nothing moves.
    NothingMoves {
        log: String,
        commands: usize,
        moved: usize,
        motions: usize,
    },
    /// Objects are struck when nothing is commanded, and after most commands nothing moves.
    OtherTimes {
        log: String,
        commands: usize,
        followed: usize,
        struck: usize,
    },
    /// The camera's stamps lie behind the arm's by the tip's measured place, or before them; `misleads` where what the tip delivered is read of another
    /// moment than the touch, or where one log alone (`log`) says it.
    EncoderDelay {
        #[serde(default)]
        log: Option<String>,
        delay: Delay,
        misleads: bool,
    },
    /// By the arm's measured state it moves so many s after its commands (before them where negative), and the camera sees objects move as commanded.
    StateClock {
        log: String,
        behind: f64,
        strikes: usize,
    },
    /// By the arm's measured state it moves at this part of the commanded speed, which no arm does.
    Delivers {
        log: Option<String>,
        share: f64,
        strikes: usize,
    },
    /// By the tip's measured places the camera's have another scale.
    Scaled {
        log: Option<String>,
        scale: f64,
        error: f64,
        strikes: usize,
    },
    /// By the tip's measured places the camera shows the table in several scales, as a lens does, or a camera that leans.
    Bent { strikes: usize },
    /// The arm's measured velocities point beside the ways that its measured places go, by this in the middle.
    StateFrame { beside: f64, strikes: usize },
    /// The arm's measured velocities point beside its commands, by this in the middle, and objects leave as commanded.
    StateBeside { beside: f64, strikes: usize },
    /// By the tip's measured places the arm's origin lies here in the camera's frame, and its axes are turned; both then lie this far apart in
    /// the mean. `misses` where a tip that goes to where the camera sees an object misses it.
    Displaced {
        by: Point,
        turn: f64,
        away: f64,
        strikes: usize,
        misses: bool,
    },
    /// The camera sees objects elsewhere beside the tip's measured places than in the other logs, or, from this strike on, than before; `misses`
    /// as above.
    DisplacedApart {
        log: String,
        strike: Option<usize>,
        by: Point,
        error: f64,
        strikes: usize,
        misses: bool,
    },
    /// Tip and object touch when both radii together are so much longer than stated. Where no command is logged (`by_touch`), touches are sought
    /// where the stated radii put them, which draws this to those by more than the error says.
    Radii {
        longer: f64,
        error: f64,
        strikes: usize,
        by_touch: bool,
    },
    /// Without a command, what the tip pushes is so far from its centre, which is not as far as both radii reach: no touch is seen as one.
    Reach {
        apart: f64,
        error: f64,
        stated: f64,
        hits: usize,
    },
    /// Objects of a log leave elsewhere than its others do, between these times since its first command; `certain` where they are many.
    Strays {
        log: String,
        strays: usize,
        strikes: usize,
        from: f64,
        until: f64,
        certain: bool,
    },
    /// Objects leave at speeds that no impact gives.
    Scale {
        ratio: f64,
        strikes: usize,
        topic: String,
    },
    /// Most commands lie outside the limits that the rig file states; `commanded` is false where what the arm did stands for them. Objects leave
    /// at this ratio to the commanded speed, and at that one in the other logs where one log is told alone.
    OutsideLimits {
        #[serde(default)]
        log: Option<String>,
        #[serde(default)]
        ratio: Option<f64>,
        #[serde(default)]
        others: Option<f64>,
        commanded: bool,
        limit: Limit,
        outside: usize,
        strikes: usize,
        low: f64,
        high: f64,
    },
    /// Many strikes of a log were rejected.
    MostlyRejected {
        log: String,
        rejected: usize,
        seen: usize,
        reason: RejectReason,
        count: usize,
        detail: String,
    },
    /// Commands are turned as the rig file says that the base stands; objects leave beside them by what is left.
    BaseTurns { base_yaw: f64, left: f64 },
    /// A fence that the rig file does not state: objects bounce at it.
    Fence { fence: Fence, bounces: usize },
    /// A resting object is noisier than stated.
    Noise { measured: f64, stated: f64 },
    /// Many frames are lost.
    LostFrames { share: f64 },
    /// Objects are faster a while after they began to move than at first, by this factor in the middle.
    Gathering { times: f64, strikes: usize },
    /// Objects begin to move little by little, as through a filter of this time constant; whether they are faster a while later, as no table makes
    /// them.
    Swelling {
        seconds: f64,
        gains_speed: bool,
        strikes: usize,
    },
    /// Centroids of a resting object of this log lie at two places in turn, so far (m) apart in the mean.
    TwoSources { log: String, apart: f64 },
    /// By the recorder's clock the camera's stamps, of all logs or of one, go so many times as slow as the arm's.
    SlowStamps {
        log: Option<String>,
        times: f64,
        error: f64,
    },
    /// Objects of a log leave turned against those of the others.
    SessionTurned {
        log: String,
        by: f64,
        error: f64,
        strikes: usize,
    },
    /// From this strike of a log on objects leave turned against those before.
    TurnedWithin {
        log: String,
        strike: usize,
        by: f64,
        error: f64,
    },
    /// From this strike of a log on objects leave so many times as fast as those before, for the same commanded speeds.
    SpeedWithin {
        log: String,
        strike: usize,
        times: f64,
        error: f64,
    },
    /// What these strikes of a log show, from the first to the last, and not all of it.
    InPart {
        log: String,
        first: usize,
        last: usize,
        what: Box<Finding>,
    },
    /// Objects of a log leave so many times as fast as those of the others, for the same commanded speeds; `certain` where no arm, tip or
    /// contact changes as much from day to day.
    SessionSpeed {
        log: String,
        times: f64,
        strikes: usize,
        certain: bool,
    },
    /// The stated object has a density that hardly any material has, in kg/m³.
    Density { density: f64 },
    /// Few strikes.
    FewStrikes { strikes: usize },
    /// All at nearly one speed.
    OneSpeed { speed: f64 },
    /// All at nearly one angle.
    OneAngle { angle: f64 },
    /// All from nearly one place.
    OnePlace { extent: f64 },
    /// No command was repeated from one place.
    NoRepeats,
}

impl Finding {
    /// Whether places or angles of the arm are not those of the camera, or touches are none.
    pub(crate) fn is_of_frames(&self) -> bool {
        matches!(
            self,
            Self::Mirrored { .. }
                | Self::AxesSwapped { .. }
                | Self::Turned { .. }
                | Self::CommandFrame { .. }
                | Self::InPart { .. }
                | Self::Unrelated { .. }
                | Self::Reach { .. }
        )
    }

    /// A drift of the clocks that touches tell.
    pub(crate) fn told_by_touches(mut self) -> Self {
        if let Self::ClockDrift { by_touch, .. } = &mut self {
            *by_touch = true;
        }
        self
    }

    /// Whether the times of commands and motions tell it of the clocks.
    pub(crate) fn is_of_clocks(&self) -> bool {
        matches!(
            self,
            Self::ClockOffset { .. } | Self::ClockDrift { .. } | Self::ClockStep { .. }
        )
    }

    /// How grave it is.
    pub fn severity(&self) -> Severity {
        match self {
            Self::Mirrored { .. }
            | Self::AxesSwapped { .. }
            | Self::Turned { certain: true, .. }
            | Self::CommandFrame { .. }
            | Self::ConstantHeading { .. }
            | Self::ConstantSpeed { .. }
            | Self::SessionSpeed { certain: true, .. }
            | Self::SpeedAndAngle { .. }
            | Self::Jumps { certain: true, .. }
            | Self::Unrelated { .. }
            | Self::OtherCommands { .. }
            | Self::ClockOffset { certain: true, .. }
            | Self::ClockDrift { certain: true, .. }
            | Self::NothingMoves { .. }
            | Self::OtherTimes { .. }
            | Self::ClockDrift { by_touch: true, .. }
            | Self::ClockStep { by_touch: true, .. }
            | Self::DisplacedApart { misses: true, .. }
            | Self::Delivers { .. }
            | Self::StateClock { .. }
            | Self::TwoSources { .. }
            | Self::Scale { .. }
            | Self::Reach { .. }
            | Self::Strays { certain: true, .. }
            | Self::OutsideLimits {
                commanded: true, ..
            } => Severity::Meaningless,
            Self::MostlyRejected {
                reason: RejectReason::UnitsImplausible | RejectReason::OffTable,
                rejected,
                seen,
                ..
            } if 2 * rejected > *seen => Severity::Meaningless,
            // Not one strike is timed.
            Self::MostlyRejected {
                reason: RejectReason::ClockBackwards,
                rejected,
                seen,
                ..
            } if rejected == seen => Severity::Meaningless,
            Self::StateFrame { .. }
            | Self::StateBeside { .. }
            | Self::Displaced { misses: true, .. } => Severity::Meaningless,
            Self::Swelling {
                seconds,
                gains_speed: true,
                ..
            } if *seconds > SMEARED => Severity::Meaningless,
            Self::Gathering { times, .. } if *times > PUSHED => Severity::Meaningless,
            Self::Scaled { scale, .. } if (scale - 1.0).abs() > SCALED => Severity::Meaningless,
            Self::TurnedWithin { by, .. } if by.abs() > TURNED => Severity::Meaningless,
            Self::SpeedWithin { times, .. } if times.ln().abs() > FASTER.ln() => {
                Severity::Meaningless
            }
            Self::ClockStep { untimely, .. } if *untimely >= FEWEST_UNTIMELY => {
                Severity::Meaningless
            }
            Self::InPart { what, .. } => what.severity(),
            Self::EncoderDelay { misleads: true, .. } => Severity::Meaningless,
            Self::EncoderDelay { delay, .. } if delay.seconds[0].abs() <= LONG => Severity::Told,
            Self::Turned { .. }
            | Self::ClockOffset { .. }
            | Self::EncoderDelay { .. }
            | Self::Jumps { .. }
            | Self::Displaced { .. }
            | Self::DisplacedApart { .. }
            | Self::Scaled { .. }
            | Self::Radii { .. }
            | Self::Strays { .. }
            | Self::OutsideLimits { .. }
            | Self::ClockDrift { .. }
            | Self::ClockStep { .. }
            | Self::MostlyRejected { .. }
            | Self::Gathering { .. }
            | Self::Swelling { .. }
            | Self::SlowStamps { .. }
            | Self::SessionTurned { .. }
            | Self::SessionSpeed { .. }
            | Self::TurnedWithin { .. }
            | Self::SpeedWithin { .. }
            | Self::Density { .. }
            | Self::Noise { .. }
            | Self::LostFrames { .. } => Severity::Doubtful,
            Self::Fence { .. }
            | Self::Bent { .. }
            | Self::BaseTurns { .. }
            | Self::FewStrikes { .. }
            | Self::OneSpeed { .. }
            | Self::OneAngle { .. }
            | Self::OnePlace { .. }
            | Self::NoRepeats => Severity::Told,
        }
    }
}

/// Ranges of the strikes, from the least to the greatest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// Strikes of which the motion was seen.
    pub strikes: usize,
    /// Commanded speeds, in m/s.
    pub speed: [f64; 2],
    /// Commanded angles, in rad.
    pub angle: [f64; 2],
    /// Starts along x, in m.
    pub x: [f64; 2],
    /// Starts along y, in m.
    pub y: [f64; 2],
    /// Strikes that repeat another.
    pub repeats: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_that_commands_tell_roughly_is_told_as_touches_tell_it() {
        let offset = |delay: f64| Finding::ClockOffset {
            log: "one.mcap".into(),
            delay,
            uncertainty: 0.15,
            strikes: 30,
            certain: true,
        };
        let check = |findings: Vec<Finding>| Check {
            findings,
            ..Check::default()
        };
        let rough = check(vec![offset(1.01), offset(1.03)]).rough_delay();
        assert!(
            rough.is_some_and(|rough| (rough - 1.02).abs() < 1e-9),
            "{rough:?}"
        );
        // One log alone is late.
        assert_eq!(check(vec![offset(1.01), offset(-2.0)]).rough_delay(), None);
        assert_eq!(check(Vec::new()).rough_delay(), None);
        let mut again = check(vec![Finding::NoRepeats]);
        assert_eq!(Check::refined(1.02, again.clone()), None);
        again.measured.encoder_to_camera = Some(Delay {
            seconds: [-0.0204, 0.0003],
            reach: None,
            strikes: 60,
        });
        let found = Check::refined(1.02, again).expect("touches tell it");
        assert!(
            matches!(&found.findings[..], [Finding::EncoderDelay { delay, .. }, Finding::NoRepeats]
                if (delay.seconds[0] - 0.9996).abs() < 1e-9),
            "{found:?}"
        );
        assert!(found.is_meaningless());
    }

    #[test]
    fn what_a_soft_contact_delays_by_itself_is_no_clocks() {
        let is_sure = |seconds: f64, error: f64| {
            let delay = Delay {
                seconds: [seconds, error],
                reach: None,
                strikes: 100,
            };
            delay.is_sure()
        };
        // As measured at contacts that delay by 3.1 to 3.6 ms themselves, the clocks being one.
        for (seconds, error) in [(0.0034, 0.0005), (0.0048, 0.00075), (0.0029, 0.0004)] {
            assert!(!is_sure(seconds, error));
        }
        assert!(is_sure(0.008, 0.0007) && !is_sure(0.008, 0.0012));
        // No contact begins before the touch.
        assert!(is_sure(-0.0034, 0.0005) && !is_sure(-0.0028, 0.0005));
    }

    #[test]
    fn a_tip_that_is_seen_before_it_has_its_speed_or_centimetres_past_the_touch_tells_nothing_of_it()
     {
        let severity = |seconds, by_touches| {
            let delay = Delay {
                seconds: [seconds, 0.001],
                reach: None,
                strikes: 40,
            };
            let misleads = delay.misleads(by_touches);
            let log = None;
            Finding::EncoderDelay {
                log,
                delay,
                misleads,
            }
            .severity()
        };
        for by_touches in [false, true] {
            assert_eq!(severity(0.008, by_touches), Severity::Told);
            assert_eq!(severity(0.02, by_touches), Severity::Doubtful);
            for seconds in [-0.06, 0.06] {
                assert_eq!(severity(seconds, by_touches), Severity::Meaningless);
            }
        }
        assert_eq!(severity(-0.004, false), Severity::Told);
        assert_eq!(severity(-0.012, false), Severity::Meaningless);
        assert_eq!(severity(-0.012, true), Severity::Doubtful);
    }
}
