//! Answers on standard output: as text, and as JSON.

use std::io::{self, Write};
use std::path::PathBuf;

use serde::Serialize;
use strike::{Adapted, Details, FEW, Plan, Seen, StrikeRecord};
use values::Point;

use super::Failure;

/// The contract's plan and, where a robot struck, the result.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    #[serde(flatten)]
    plan: Plan,
    /// Where the object came to rest, in m.
    #[serde(skip_serializing_if = "Option::is_none")]
    stopped: Option<Point>,
    /// Distance from there to the target, in m.
    #[serde(skip_serializing_if = "Option::is_none")]
    miss: Option<f64>,
    /// Speed that the arm delivered at contact, in m/s, where it is measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    delivered_speed: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    warning: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub log: Option<PathBuf>,
    /// Why the log was written under another name; none where it was not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub log_moved: Option<String>,
    /// What the camera did not see of the strike: that the object moved, or came to rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unseen: Option<String>,
    /// What failed once the strike was begun; completes "failed to …".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
}

impl Answer {
    /// A plan that nothing struck.
    pub fn planned(plan: &Plan) -> Self {
        Self {
            plan: plan.clone(),
            stopped: None,
            miss: None,
            delivered_speed: None,
            warning: None,
            log: None,
            log_moved: None,
            unseen: None,
            failed: None,
        }
    }

    /// What the robot answered, in a word or as what failed.
    pub fn robot_answered(&self) -> String {
        match (&self.failed, &self.warning) {
            (Some(failed), _) => format!("failed to {failed}"),
            (None, Some(warning)) => format!("struck, with a warning: {warning}"),
            (None, None) => "struck".into(),
        }
    }

    pub fn struck(&mut self, struck: &StrikeRecord) {
        self.stopped = struck.stop;
        self.miss = struck.stop.map(|stop| stop.distance(self.plan.to));
        self.delivered_speed = struck.delivered_speed;
        self.warning.clone_from(&struck.warning);
    }

    /// Where the camera saw the object come to rest, if it did.
    pub fn seen(&mut self, seen: &Seen) {
        if let Ok(rest) = &seen.rest {
            self.stopped = Some(rest.point);
            self.miss = Some(rest.point.distance(self.plan.to));
        }
        self.unseen = seen.doubt();
        for warning in seen.warning.iter().cloned().chain(seen.doubt()) {
            self.warn(&warning);
        }
    }

    /// Adds a warning for the operator.
    pub fn warn(&mut self, what: &str) {
        let before = self.warning.take();
        self.warning = Some(before.map_or(what.into(), |before| format!("{before}; {what}")));
    }
}

/// One JSON object on a line.
pub fn json(answer: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string(answer).map_err(failed)?;
    writeln!(io::stdout(), "{text}").map_err(failed)
}

/// A plan as a table. `laid` says that the start was chosen here.
pub fn plan(plan: &Plan, laid: bool) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    let place = |point: Point| format!("{:8.4} {:8.4} m", point.x, point.y);
    let degrees = |angle: f64| format!("{:+.2}°", angle.to_degrees());
    let laid = if laid {
        "  (lay it there: no --from was given)"
    } else {
        ""
    };
    let mut text = format!(
        "plan        {}, {}{}\n",
        plan.artifact,
        plan.model.name(),
        expected(plan)
    );
    text += &plan.adapted.as_ref().map_or_else(String::new, adapted);
    text += &format!("from        {}{laid}\n", place(plan.from));
    text += &format!("to          {}\n", place(plan.to));
    for (name, speed, angle) in [
        ("simulated", plan.speed_sim, plan.angle_sim),
        ("residual", plan.d_speed, plan.d_angle),
        ("command", plan.speed, plan.angle),
    ] {
        text += &format!(
            "{name:<11} {speed:+8.4} m/s  {angle:+8.4} rad ({})\n",
            degrees(angle)
        );
    }
    let stroke = plan.stroke();
    text += "\ntip             t s      x m      y m\n";
    for (name, time, point) in [
        ("start", 0.0, plan.start),
        ("pre-strike", stroke.t_pre_strike, plan.pre_strike),
        ("strike", stroke.t_strike, plan.strike),
        ("stop", stroke.t_stop, plan.stop),
    ] {
        text += &format!("{name:<11} {time:8.4} {:8.4} {:8.4}\n", point.x, point.y);
    }
    text += &format!("acceleration {:.3} m/s²\n", plan.acceleration);
    out.write_all(text.as_bytes()).map_err(failed)
}

/// What miss to expect, and how well that is known.
fn expected(plan: &Details) -> String {
    let Some((miss, strikes)) = plan.expected_miss.zip(plan.expected_miss_strikes) else {
        return String::new();
    };
    let miss = miss * 1e3;
    let condition = if plan.if_as_before {
        " if the table is as it was"
    } else {
        ""
    };
    match strikes {
        1 => format!(", expected miss hardly known ({miss:.1} mm rms{condition}, by one strike)"),
        2..FEW => format!(
            ", expected miss hardly known ({miss:.1} mm rms{condition}, by only {strikes} strikes)"
        ),
        _ => format!(", expected miss {miss:.1} mm rms{condition} (by {strikes} strikes)"),
    }
}

fn adapted(adapted: &Adapted) -> String {
    let [friction, gain, heading] = adapted.deviations;
    format!(
        "adapted     by {} recent strikes: {} (± {:.1} %, {:.1} %, {:.2}°)\n",
        adapted.strikes,
        adapted.shift,
        100.0 * friction,
        100.0 * gain,
        heading.to_degrees()
    )
}

pub fn struck(answer: &Answer) -> Result<(), Failure> {
    let mut text = String::new();
    if let (Some(stop), Some(miss)) = (answer.stopped, answer.miss) {
        text += &format!(
            "\nstopped     {:8.4} {:8.4} m, {:.1} mm from the target\n",
            stop.x,
            stop.y,
            miss * 1e3
        );
    }
    if let Some(speed) = answer.delivered_speed {
        text += &format!("delivered   {speed:8.4} m/s at contact\n");
    }
    if let Some(warning) = &answer.warning {
        text += &format!("warning     {warning}\n");
    }
    if let Some(log) = &answer.log {
        text += &format!("log         {}\n", log.display());
    }
    io::stdout().write_all(text.as_bytes()).map_err(failed)
}

fn failed(error: impl std::fmt::Display) -> Failure {
    Failure::failed(format!("write the answer: {error}"))
}
