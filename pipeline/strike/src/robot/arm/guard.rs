//! What the arm may do on one straight line, or while it is to rest, and whether a report keeps to it.

use std::time::Instant;

use super::driver::{Condition, Report, distance, norm};
use super::line::Line;

/// Greatest distance of the tip from its line, in m.
pub(crate) const ASIDE: f64 = 0.005;
/// What is kept clear beside the tip, in m: what it may be off its line, and 2 mm in which it brakes from the fastest that it may leave it
/// (0.1 m/s, 5 ms until the stop is sent, and 4 m/s² from there).
pub(crate) const MARGIN: f64 = ASIDE + 0.002;
/// Greatest speed at which the tip may leave its line, in m/s, and as a share of the line's speed.
const DRIFT: (f64, f64) = (0.05, 0.05);
/// Greatest excess over the commanded speed, as a share, and in m/s.
const FASTER: (f64, f64) = (0.10, 0.010);
/// Share of the striking speed that the tip may lack at the point where it must be reached.
const SLOWER: f64 = 0.05;
/// Greatest delay of a report, in s, after what the quickest of the last ones took.
const LATE: f64 = 0.05;
/// Greatest lag of the tip on its line: in s, behind when it was quickest, and in m, behind that.
const BEHIND: (f64, f64) = (0.04, 0.0005);
/// Distances in m: a tip that has gone less than the second, where its ramp, begun at the latest moment, has gone the first, stands still.
const STANDS: (f64, f64) = (0.0002, 0.00005);
/// Greatest lead of the tip on its line: in s, before what its limits allow, and in m, ahead of that.
const AHEAD: (f64, f64) = (0.02, 0.003);
/// Distance in m from a line's ends within which a place says little of the time.
const ENDS: f64 = 0.001;
/// Greatest turn of the tip from its orientation while it moves, in rad.
const TURNED: f64 = 0.03;
/// When the tip is at rest at the end of its line: within m, slower than m/s, in so many reports one after another.
const ARRIVED: (f64, f64, u32) = (0.0005, 0.002, 5);
/// Greatest motion, in m, of an arm that is to rest.
pub(super) const STILL: f64 = 0.001;

/// A report and when it came.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// When it came, by this computer's clock.
    pub(super) at: Instant,
    /// When it was made, by the controller's clock set by the quickest reports.
    pub(super) made: Instant,
    pub(super) report: Report,
}

#[derive(Debug)]
pub(super) enum Guard {
    Line(Box<OnLine>),
    /// The arm must rest where the first report finds it.
    Rest(Option<[f64; 3]>),
}

impl Guard {
    /// Checks a report against what the arm may do. Errors with what does not keep to it.
    pub(super) fn judge(&mut self, sample: &Sample) -> Result<(), String> {
        match self {
            Self::Line(line) => line.judge(sample),
            Self::Rest(place) => {
                let at = sample.report.pose.at;
                let moved = distance(*place.get_or_insert(at), at);
                if moved > STILL {
                    return Err(format!(
                        "the tip moves, by {:.1} mm, and no line was sent: another program drives the arm, or a hand",
                        moved * 1e3
                    ));
                }
                Ok(())
            }
        }
    }

    pub(super) fn on_line(&self) -> Option<&OnLine> {
        match self {
            Self::Line(line) => Some(line),
            Self::Rest(_) => None,
        }
    }
}

#[derive(Debug)]
pub(super) struct OnLine {
    line: Line,
    sent: Instant,
    /// The report before the one to be judged.
    before: Option<Sample>,
    /// By how much, in s, the line began after it was sent, as the tip's place in the quickest report shows; none before one does.
    began: Option<f64>,
    /// By how much, in s, the line began after it was sent, as the controller's wanted places of the tip show; none where its reports do not hold
    /// them.
    wanted: Option<f64>,
    was_reached: bool,
    at_end: u32,
}

impl OnLine {
    /// `last` is the report before the line was sent.
    pub(super) fn new(line: Line, last: Option<Sample>) -> Self {
        Self {
            line,
            sent: Instant::now(),
            before: last,
            began: None,
            wanted: None,
            was_reached: false,
            at_end: 0,
        }
    }

    pub(super) fn sent(&self) -> Instant {
        self.sent
    }

    /// Whether the tip has been seen to move along the line.
    pub(super) fn has_begun(&self) -> bool {
        self.began.is_some()
    }

    /// Whether the tip rests at the end of the line.
    pub(super) fn is_over(&self) -> bool {
        self.at_end >= ARRIVED.2
    }

    /// Whether the tip, as far ahead as it may be, has not come to within the last 10 mm before the object by that moment: what the object does
    /// then is not the strike's.
    pub(super) fn runs_up(&self, at: Instant) -> bool {
        let (early, ahead) = AHEAD;
        let time = at.saturating_duration_since(self.sent).as_secs_f64();
        let time = time - self.began.unwrap_or(0.0) + early;
        let farthest = self.line.profile.at(time) + ahead;
        self.line.reached_at.is_some_and(|end| farthest < end)
    }

    fn judge(&mut self, sample: &Sample) -> Result<(), String> {
        let before = self.before.replace(*sample);
        let report = &sample.report;
        if let Condition::Stopped(said) | Condition::Held(said) = report.condition {
            return Err(format!("the controller left motion: {said}"));
        }
        let turned = report.pose.turn.angle_to(self.line.to.turn);
        if turned > TURNED {
            return Err(format!(
                "the tool is turned by {turned:.3} rad from its orientation, {TURNED} rad is the most"
            ));
        }
        let (along, aside) = self.line.place(report.pose.at);
        if aside > ASIDE {
            return Err(format!(
                "the tip is {:.1} mm off its line, {} mm is the most",
                aside * 1e3,
                ASIDE * 1e3
            ));
        }
        let speed = norm(report.velocity);
        let most = self.line.speed * (1.0 + FASTER.0) + FASTER.1;
        if speed > most {
            return Err(format!(
                "the tip moves at {:.0} mm/s, commanded were {:.0} mm/s",
                speed * 1e3,
                self.line.speed * 1e3
            ));
        }
        if let Some(before) = before {
            let step = report.clock - before.report.clock;
            if step < 0.0 {
                return Err("the clock of its reports runs backwards".into());
            }
            let jump = distance(before.report.pose.at, report.pose.at);
            if jump > most * step + ASIDE {
                return Err(format!(
                    "the tip jumps by {:.1} mm within {:.1} ms",
                    jump * 1e3,
                    step * 1e3
                ));
            }
        }
        self.judge_drift(report)?;
        // What came before the line was sent says nothing of its progress.
        let Some(time) = sample.made.checked_duration_since(self.sent) else {
            return Ok(());
        };
        let time = time.as_secs_f64();
        if let Some(wanted) = report.wanted {
            self.wanted = self.quickest(self.wanted, time, self.line.place(wanted).0);
        }
        self.judge_progress(time, along)?;
        if let Some(reached_at) = self.line.reached_at
            && !self.was_reached
            && along >= reached_at
        {
            self.was_reached = true;
            if speed < self.line.speed * (1.0 - SLOWER) {
                return Err(format!(
                    "the speed is not reached: {:.0} mm/s of {:.0} mm/s before the object",
                    speed * 1e3,
                    self.line.speed * 1e3
                ));
            }
        }
        let (near, slow, _) = ARRIVED;
        let is_there = report.condition == Condition::Ready
            && distance(report.pose.at, self.line.to.at) <= near
            && speed <= slow;
        self.at_end = if is_there { self.at_end + 1 } else { 0 };
        Ok(())
    }

    /// Checks that the tip does not move away from its line.
    fn judge_drift(&self, report: &Report) -> Result<(), String> {
        let length = self.line.length().max(1e-9);
        let direction: [f64; 3] =
            std::array::from_fn(|i| (self.line.to.at[i] - self.line.from[i]) / length);
        let along: f64 = (0..3).map(|i| report.velocity[i] * direction[i]).sum();
        let beside = norm(std::array::from_fn(|i| {
            report.velocity[i] - along * direction[i]
        }));
        let (least, share) = DRIFT;
        if beside > least + share * self.line.speed {
            return Err(format!(
                "the tip leaves its line at {:.0} mm/s",
                beside * 1e3
            ));
        }
        Ok(())
    }

    /// When (s after it was sent) the line began by the quickest of these places (m) along it so far, and this one at a time (s).
    fn quickest(&self, so_far: Option<f64>, time: f64, along: f64) -> Option<f64> {
        let says = along > ENDS && along < self.line.length() - ENDS;
        let began = says.then(|| time - self.line.profile.when(along));
        so_far.into_iter().chain(began).reduce(f64::min)
    }

    /// Checks that the tip is where its ramp lets it be, `time` seconds after the line was sent. One check catches a line that begins late, reports
    /// that are late all along, a place that stands still while its clock runs, and an arm that is slower or faster than its ramp.
    fn judge_progress(&mut self, time: f64, along: f64) -> Result<(), String> {
        let profile = self.line.profile;
        let (early, ahead) = AHEAD;
        let farthest = profile.at(time + early) + ahead;
        if along > farthest {
            return Err(format!(
                "the tip is {:.0} mm ahead of its ramp",
                (along - farthest) * 1e3
            ));
        }
        self.began = self.quickest(self.began, time, along);
        let (late, behind) = BEHIND;
        let began = self.began.into_iter().chain(self.wanted);
        let allowed = began
            .reduce(f64::min)
            .map_or(self.line.start, |began| began + late);
        let due = profile.at(time - allowed);
        let least = due - behind;
        let (moved, still) = STANDS;
        let stands = self.began.is_none() && due > moved && along < still;
        if along >= least && !stands {
            return Ok(());
        }
        Err(match self.began {
            None if self.wanted.is_some() => {
                "the controller has begun the line, and the tip is not seen to move: it is held, or its pose stands still".into()
            }
            None => format!(
                "the line did not begin within {:.0} ms of being sent, or its reports are late",
                self.line.start * 1e3
            ),
            Some(_) => format!(
                "the tip is {:.1} mm behind its ramp: it stands still, is too slow, or its reports are late",
                (least + behind - along) * 1e3
            ),
        })
    }
}

/// Maps the controller's clock to this computer's: reports take some time to come, the quickest the least.
#[derive(Debug, Default)]
pub(super) struct Clocks {
    /// For each of the last two spans of time: when the span began, and the quickest pair of clocks in it.
    spans: [Option<Span>; 2],
}

#[derive(Clone, Copy, Debug)]
struct Span {
    begun: Instant,
    at: Instant,
    clock: f64,
}

/// Length of a span, in s: clocks drift apart by less than a millisecond in it.
const SPAN: f64 = 5.0;

impl Clocks {
    /// When a report was made that came at a moment, and how late (s) it came.
    pub(super) fn made(&mut self, at: Instant, clock: f64) -> (Instant, f64) {
        let late = |span: &Span| {
            at.saturating_duration_since(span.at).as_secs_f64() - (clock - span.clock)
        };
        let new = Span {
            begun: at,
            at,
            clock,
        };
        match &mut self.spans[0] {
            Some(span) if at.saturating_duration_since(span.begun).as_secs_f64() < SPAN => {
                if late(span) < 0.0 {
                    (span.at, span.clock) = (at, clock);
                }
            }
            _ => self.spans = [Some(new), self.spans[0]],
        }
        let lateness = self.spans.iter().flatten().map(late).fold(0.0, f64::max);
        let made = at
            .checked_sub(std::time::Duration::from_secs_f64(lateness.clamp(0.0, 1e3)))
            .unwrap_or(at);
        (made, lateness)
    }

    /// Errors where a report came too late.
    pub(super) fn judge(lateness: f64) -> Result<(), String> {
        if lateness > LATE {
            return Err(format!("its reports lag by {:.0} ms", lateness * 1e3));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::super::driver::Pose;
    use super::super::line::Profile;
    use super::super::turn::Turn;
    use super::*;

    const DOWN: [f64; 3] = [std::f64::consts::PI, 0.0, 0.0];

    fn line(speed: f64) -> Line {
        let to = Pose {
            at: [0.4, 0.0, 0.02],
            turn: Turn::rpy(DOWN),
        };
        Line {
            from: [0.0, 0.0, 0.02],
            to,
            speed,
            reached_at: None,
            profile: Profile::new(0.4, speed, 5.0, Some(100.0)),
            start: 0.06,
        }
    }

    const TICK: f64 = 0.004;

    /// What is reported at a time (s), of a tip that is at `place` of it (m) along the line.
    fn sample(begun: Instant, t: f64, place: impl Fn(f64) -> f64, condition: Condition) -> Sample {
        let at = begun + Duration::from_secs_f64(t);
        let along = place(t);
        Sample {
            at,
            made: at,
            report: Report {
                clock: t,
                pose: Pose {
                    at: [along, 0.0, 0.02],
                    turn: Turn::rpy(DOWN),
                },
                velocity: [(along - place(t - TICK)) / TICK, 0.0, 0.0],
                condition,
                wanted: None,
            },
        }
    }

    /// Judges reports every 4 ms that show the tip where it is at a time (s): gives when (s) the first error came, and which.
    fn judged(line: Line, shown: impl Fn(f64) -> f64) -> Option<(f64, String)> {
        let mut guard = OnLine::new(line, None);
        let begun = guard.sent();
        let place = |t: f64| line.profile.at(shown(t));
        (1..1_500).find_map(|tick| {
            let t = f64::from(tick) * TICK;
            let condition = if place(t) < line.to.at[0] {
                Condition::Moving
            } else {
                Condition::Ready
            };
            let sample = sample(begun, t, place, condition);
            let failed = guard.judge(&sample).err();
            assert!(failed.is_some() || t < line.profile.duration + 0.2 || guard.is_over());
            failed.map(|why| (t, why))
        })
    }

    #[test]
    fn progress_on_time_is_let_pass_and_what_is_late_frozen_or_early_is_not() {
        for speed in [0.1, 0.4, 1.0] {
            assert_eq!(judged(line(speed), |t| t), None);
            assert_eq!(
                judged(line(speed), |t| t - 0.05),
                None,
                "it begins 50 ms late"
            );
            // Late all along, or late to begin.
            let (at, why) = judged(line(speed), |t| t - 0.3).expect("late");
            assert!(
                at < 0.11 && why.contains("did not begin"),
                "{speed}: {at} {why}"
            );
            // Frozen in the middle.
            let frozen = 0.5 * line(speed).profile.duration;
            let (at, why) = judged(line(speed), |t| t.min(frozen)).expect("frozen");
            assert!(
                at - frozen < 0.06 && why.contains("behind its ramp"),
                "{speed}: {why}"
            );
            // Frozen from the beginning, also of a line of travel; one that begins in time is never taken for that.
            for acceleration in [0.5, 5.0] {
                let mut line = line(speed);
                line.profile = Profile::new(0.4, speed, acceleration, Some(100.0));
                let (at, _) = judged(line, |_| 0.0).expect("frozen");
                assert!(at <= 0.1, "{speed}: {at}");
                assert_eq!(judged(line, |t| t - line.start), None);
            }
            let (_, why) = judged(line(speed), |t| 0.8 * t).expect("slow");
            assert!(why.contains("behind"), "{why}");
            let (_, why) = judged(line(speed), |t| t + 0.1).expect("early");
            assert!(why.contains("ahead") || why.contains("jumps"), "{why}");
        }
    }

    #[test]
    fn a_tip_that_is_not_seen_where_its_controller_wants_it_is_not_given_the_time_of_a_late_line() {
        // A line of an arm without a limit of jerk that may begin 100 ms late, and begins 20 ms late; in the air, and one that strikes.
        for (speed, acceleration) in [(0.1, 0.5), (1.0, 5.0)] {
            let mut line = line(speed);
            line.profile = Profile::new(0.4, speed, acceleration, None);
            line.start = 0.1;
            let begins = 0.02;
            let stopped = |is_seen: bool| {
                let mut guard = OnLine::new(line, None);
                let sent = guard.sent();
                (1..100).map(|tick| f64::from(tick) * TICK).find(|t| {
                    let wanted = |t: f64| line.profile.at(t - begins);
                    // The tip follows 12 ms later.
                    let place = |t: f64| if is_seen { wanted(t - 0.012) } else { 0.0 };
                    let mut sample = sample(sent, *t, place, Condition::Moving);
                    sample.report.wanted = Some([wanted(*t), 0.0, 0.02]);
                    guard.judge(&sample).is_err()
                })
            };
            assert_eq!(stopped(true), None);
            let at = stopped(false).expect("frozen");
            assert!(at <= 0.1, "{speed}: {at}");
        }
    }

    #[test]
    fn what_an_object_does_that_may_have_been_touched_is_not_the_run_ups() {
        for (speed, late) in [0.4, 0.7, 1.0]
            .into_iter()
            .flat_map(|speed| [0.0, 0.03, 0.055].map(|late| (speed, late)))
        {
            let mut line = line(speed);
            let ramp = crate::Ramp::to(speed, 5.0, Some(100.0));
            line.reached_at = Some(ramp.length());
            // 10 mm after its speed is reached the tip touches.
            let touch = late + ramp.duration + 0.010 / speed;
            let mut guard = OnLine::new(line, None);
            let sent = guard.sent();
            let at = |t: f64| sent + Duration::from_secs_f64(t);
            let (mut last, mut first) = (0.0, f64::INFINITY);
            for tick in 1..=(touch / TICK) as u32 {
                let t = f64::from(tick) * TICK;
                let place = |t: f64| line.profile.at(t - late);
                let sample = sample(sent, t, place, Condition::Moving);
                assert_eq!(guard.judge(&sample), Ok(()), "{speed} {late}");
                if guard.runs_up(at(t)) {
                    last = t;
                } else {
                    first = t.min(first);
                }
            }
            // Also of an arm that is as much ahead as the guard lets it be.
            let (early, ahead) = AHEAD;
            assert!(
                touch - last >= early + ahead / speed,
                "{speed} {late}: {last} of {touch}"
            );
            assert!(touch - first <= 0.08, "{speed} {late}: {first} of {touch}");
        }
    }

    #[test]
    fn a_report_is_as_late_as_the_quickest_of_the_last_ones_was_not() {
        let (mut clocks, begun) = (Clocks::default(), Instant::now());
        let at = |seconds: f64| begun + Duration::from_secs_f64(seconds);
        for tick in 0..5_000 {
            // A clock that runs 100 ppm slow, and reports that take 1 ms, now and then 11.
            let t = f64::from(tick) * 0.004;
            let takes = if tick % 7 == 3 { 0.011 } else { 0.001 };
            let (made, late) = clocks.made(at(t + takes), t * 0.9999 + 50.0);
            assert!((late - (takes - 0.001)).abs() < 1.5e-3, "{tick}: {late}");
            let off = made.saturating_duration_since(at(t)).as_secs_f64();
            assert!(off < 2.5e-3, "{off}");
        }
        let (_, late) = clocks.made(at(20.3), 70.0 - 0.002);
        assert!(Clocks::judge(late).is_err(), "{late}");
    }
}
