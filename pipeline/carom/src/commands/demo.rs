//! `carom demo`: logs from the embedded rig.

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use rig::demo::{Settings, Written};
use rig::{Hide, Noise};
use serde_json::json;
use values::Shape;

use crate::Error;
use crate::error::Output;

/// `carom demo`.
#[derive(Args, Debug)]
pub struct DemoArgs {
    /// Number of strikes.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub strikes: u32,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// What is struck.
    #[arg(long, value_enum, default_value_t = DemoObject::Cylinder)]
    pub object: DemoObject,
    /// What to hide in place of the demo's mixture: an effect or a kind of noise, with values where its defaults do not serve
    /// (all in order, or some by NAME:VALUE), or `none`; repeat it for several.
    #[arg(long, value_name = "EFFECT[=VALUE,…]")]
    pub hide: Vec<String>,
    /// Strikes to make in place of random ones: a JSON list of {x0, y0, speed, angle}, or a diagnosis.json.
    #[arg(long, value_name = "FILE", conflicts_with = "strikes")]
    pub plan: Option<PathBuf>,
    /// Also log /striker/state.
    #[arg(long)]
    pub state: bool,
    /// Log /object/pose in place of /object/centroid: the object's yaw is tracked, too.
    #[arg(long, conflicts_with = "camera")]
    pub pose: bool,
    /// Log a camera's images in place of centroids (boxes are not turned in them).
    #[arg(long)]
    pub camera: bool,
    /// Folder to write.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// What the demo can strike.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum DemoObject {
    /// An upright cylinder.
    Cylinder,
    /// A box.
    Box,
    /// A ball.
    Sphere,
}

impl From<DemoObject> for Shape {
    fn from(object: DemoObject) -> Self {
        match object {
            DemoObject::Cylinder => Self::Cylinder,
            DemoObject::Box => Self::Box,
            DemoObject::Sphere => Self::Sphere,
        }
    }
}

/// Writes the demo's folder.
pub fn run(args: &DemoArgs) -> Result<Output, Error> {
    let written = write(args)?;
    let Written {
        rig,
        logs,
        truth,
        strikes,
    } = &written;
    Ok(Output::done(
        json!({ "rig": rig, "logs": logs, "truth": truth, "strikes": strikes }),
        format!(
            "{strikes} strikes, logs under {}, rig file {}\n",
            args.out.join("logs").display(),
            rig.display()
        ),
    ))
}

fn write(args: &DemoArgs) -> Result<Written, Error> {
    is_free(&args.out)?;
    let (hidden, noise) = match args.hide.as_slice() {
        [] => (None, Noise::none()),
        flags => {
            let hide = Hide::parse(flags).map_err(Error::input)?;
            (Some(hide.hidden), hide.noise)
        }
    };
    let plan = match &args.plan {
        None => None,
        Some(path) => {
            let text = fs::read_to_string(path).map_err(|error| Error::unreadable(path, &error))?;
            Some(rig::parse_plan(&text).map_err(Error::input)?)
        }
    };
    let mut settings = Settings::new(args.object.into(), args.strikes as usize, args.seed, hidden);
    settings.truth.noise = noise;
    settings.plan = plan;
    settings.log_state = args.state;
    settings.log_pose = args.pose;
    if args.camera {
        settings.truth.rig = rig::film::with_camera(settings.truth.rig);
    }
    let failed = |error| match error {
        rig::RigSimError::File { .. } | rig::RigSimError::Log(_) => Error::failed(error),
        error => Error::input(error),
    };
    rig::demo::write(&settings, &args.out).map_err(failed)
}

/// A rig file and logs that no demo wrote are a person's own: there is no truth beside them.
fn is_free(out: &Path) -> Result<(), Error> {
    let own = ["rig.toml", "logs"].map(|name| out.join(name));
    let own = own.iter().find(|path| match fs::read_dir(path) {
        Ok(mut logs) => logs.next().is_some(),
        Err(_) => path.exists(),
    });
    match own {
        Some(own) if !out.join("truth.json").exists() => Err(Error::input(format!(
            "write a demo into {}: {} is there, and no finished demo wrote it, for there is no truth.json; name another folder \
             with --out, or move it away",
            out.display(),
            own.display()
        ))),
        _ => Ok(()),
    }
}
