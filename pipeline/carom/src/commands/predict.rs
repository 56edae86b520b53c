//! `carom predict`: the track that a version expects of a strike.

use std::path::PathBuf;

use clap::Args;
use judge::{HeldOut, Predict};
use serde_json::json;
use store::Store;
use values::{Command, Conditions, Point};
use world::Simulator;

use crate::Error;
use crate::args::Global;
use crate::error::Output;
use crate::publishing::store_error;
use crate::score::default_model;
use crate::steps::open;

/// `carom predict`.
#[derive(Args, Debug)]
pub struct PredictArgs {
    /// Folder of a run.
    #[arg(long, value_name = "DIR", default_value = "artifacts/demo")]
    pub artifacts: PathBuf,
    /// Version [default: the latest].
    #[arg(long, value_name = "VERSION")]
    pub version: Option<String>,
    /// Where the object rests, in m.
    #[arg(long, num_args = 2, value_names = ["X", "Y"], allow_negative_numbers = true)]
    pub from: Vec<f64>,
    /// Commanded speed, in m/s.
    #[arg(long, value_name = "V")]
    pub speed: f64,
    /// Commanded angle, in rad from +x.
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    pub angle: f64,
}

/// Simulates the next strike, and has the version's own model say where it stops.
pub fn run(args: &PredictArgs, global: Global) -> Result<Output, Error> {
    let artifact = Store::open(&args.artifacts)
        .load(args.version.as_deref())
        .map_err(store_error)?;
    let &[x, y] = &args.from[..] else {
        return Err(Error::input(
            "read --from: give X and Y in m, such as --from 0.3 0.0",
        ));
    };
    let initial = Point::new(x, y);
    if !artifact.rig.table.contains(initial) {
        return Err(Error::input(format!(
            "strike from ({x}, {y}): it is off the table of the rig file"
        )));
    }
    let is_speed = args.speed.is_finite() && args.speed > 0.0;
    if !is_speed || !args.angle.is_finite() {
        return Err(Error::input(
            "read --speed and --angle: give a speed above 0 m/s and an angle in rad",
        ));
    }
    let command = Command::new(args.speed, args.angle);
    let name = artifact.manifest.provenance.default_model;
    let model = default_model(&artifact);
    let simulator = Simulator::new(&artifact.rig, &model.world).map_err(Error::failed)?;
    // As `strike` plans: the strike after those that the version knows.
    let conditions = Conditions {
        order: artifact.next_order(),
        ..Conditions::default()
    };
    let simulated = simulator
        .worker()
        .strike(initial, command, &conditions)
        .map_err(Error::input)?;
    let strike = HeldOut {
        strike_id: String::new(),
        initial,
        stop: initial,
        ends: None,
        command,
        conditions,
    };
    let scratch = tempfile::tempdir().map_err(Error::failed)?;
    let run = open(
        scratch.path(),
        Global {
            quiet: true,
            ..global
        },
    )?;
    let predicted = run.items(&Predict, &model, std::slice::from_ref(&strike))?;
    let stop = predicted.first().and_then(|predicted| predicted.stop);
    let track = &simulated.track;
    let mut text = format!("model      {name} of {}\n", artifact.version);
    let robot = &artifact.rig.robot;
    let is_within = robot.speed.contains(args.speed) && robot.angle.contains(args.angle);
    if !is_within {
        text += "limits     outside what the rig file allows: `strike` refuses it\n";
    }
    match stop {
        Some(stop) => {
            text += &format!(
                "stop       ({:.4}, {:.4}) m, by the model\n",
                stop.x, stop.y
            )
        }
        None => text += "stop       none: the model's network knows no such strike\n",
    }
    text += &format!(
        "world      rests at ({:.4}, {:.4}) m after {:.2} s\n\n     t/s     x/m     y/m\n",
        simulated.stop.x, simulated.stop.y, simulated.rest_time
    );
    // A line every twentieth of a second.
    let lines = (simulated.rest_time / LINE).ceil() as u32;
    for line in 0..=lines {
        let t = (f64::from(line) * LINE).min(simulated.rest_time);
        let at = simulated.at(t);
        text += &format!("{t:8.3}{:8.4}{:8.4}\n", at.x, at.y);
    }
    let json = json!({
        "artifact": artifact.version,
        "model": name.to_string(),
        "from": initial,
        "speed": command.speed,
        "angle": command.angle,
        "within_limits": is_within,
        "stop": stop,
        "world": {
            "stop": simulated.stop,
            "rest_time": simulated.rest_time,
            "track": { "t": track.t, "x": track.x, "y": track.y },
        },
    });
    Ok(Output::done(json, text))
}

/// Seconds between the lines of a table of the track.
const LINE: f64 = 0.05;
