//! Answers on standard output: for a person, and for a machine.

use std::io::{self, Write};
use std::path::PathBuf;

use serde::Serialize;
use strike::Plan;
use values::Point;

use super::Failure;

/// The contract's plan, and what became of it where a robot struck.
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
    /// The log.
    #[serde(skip_serializing_if = "Option::is_none")]
    log: Option<PathBuf>,
}

impl Answer {
    /// A plan that nothing struck.
    pub fn planned(plan: &Plan) -> Self {
        Self {
            plan: plan.clone(),
            stopped: None,
            miss: None,
            log: None,
        }
    }

    /// The robot struck.
    pub fn struck(&mut self, stop: Point, log: PathBuf) {
        self.stopped = Some(stop);
        self.miss = Some(stop.distance(self.plan.to));
        self.log = Some(log);
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
    let expected = plan.expected_miss.map_or(String::new(), |miss| {
        format!(", mean miss {:.1} mm on held-out strikes", miss * 1e3)
    });
    let laid = if laid {
        "  (lay it there: no --from was given)"
    } else {
        ""
    };
    let mut text = format!(
        "plan        {}, {}{expected}\n",
        plan.artifact,
        plan.model.name()
    );
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
    let profile = plan.profile();
    text += "\ntip             t s      x m      y m\n";
    for (name, time, point) in [
        ("start", 0.0, plan.start),
        ("pre-strike", profile.t_pre_strike, plan.pre_strike),
        ("strike", profile.t_strike, plan.strike),
        ("stop", profile.t_stop, plan.stop),
    ] {
        text += &format!("{name:<11} {time:8.4} {:8.4} {:8.4}\n", point.x, point.y);
    }
    text += &format!("acceleration {:.3} m/s²\n", plan.acceleration);
    out.write_all(text.as_bytes()).map_err(failed)
}

/// What became of the plan.
pub fn struck(answer: Option<&Answer>) -> Result<(), Failure> {
    let Some(Answer {
        stopped: Some(stop),
        miss: Some(miss),
        log: Some(log),
        ..
    }) = answer
    else {
        return Ok(());
    };
    writeln!(
        io::stdout(),
        "\nstopped     {:8.4} {:8.4} m, {:.1} mm from the target\nlog         {}",
        stop.x,
        stop.y,
        miss * 1e3,
        log.display()
    )
    .map_err(failed)
}

fn failed(error: impl std::fmt::Display) -> Failure {
    Failure::failed(format!("write the answer: {error}"))
}
