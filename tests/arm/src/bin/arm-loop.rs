//! `arm-loop MAKER FOLDER BIN PAGE [STRIKES TARGETS]`: the paper's script on the emulated arm of a maker, `xarm` or `ur`. An object lies before it whose physics is the
//! embedded rig's, and a camera publishes where it is. `carom collect`, `carom run --key`, and a `strike --watch` for each target, as
//! a person would type them; then the page, with the misses beside the scatter of repeats of the same commands.
//!
//! What was collected is kept: the same command continues. The maker's ports are taken, of which 502 needs root.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};
use std::process::{Command as Program, Stdio};
use std::time::Instant;

use arm::foxglove::Topic;
use arm::{Emulator, Listening, Maker, Table};
use clap::ValueEnum;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rig::{Hide, Sim, Truth};
use values::{Command, Point};

/// Where the emulator listens, and its camera.
const HOST: &str = "127.0.0.1";
const CAMERA_PORT: u16 = 8765;
/// What is hidden from carom; an arm that reports what it delivers hides nothing of its own.
const HIDDEN: [&str; 2] = ["table_tilt", "speed_weakening_friction"];
const SEED: u64 = 11;
/// Repeats of a command, for the noise floor.
const REPEATS: u32 = 25;
/// How often what the watchdog ended is gone on with: reports that a busy machine delays look like a silent arm.
const STOPS: usize = 40;
/// Targets that are drawn for each one that is struck: some cannot be reached from where the object lies.
const DRAWS: usize = 20;

type Failed = Box<dyn Error>;

/// One strike at a target.
struct TargetStrike {
    from: Point,
    to: Point,
    command: Command,
    delivered: f64,
    /// Where the object really stopped.
    stop: Point,
}

/// What came of repeats of one command, in m: how far they stop from their mean, and from the target.
struct Repeats {
    scatter: f64,
    miss: f64,
}

struct Lab {
    folder: PathBuf,
    bin: PathBuf,
    /// As `--robot` names it.
    arm: String,
    truth: Truth,
    emulator: Emulator,
}

fn main() -> Result<(), Failed> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [maker, folder, bin, page, numbers @ ..] = &arguments[..] else {
        return Err("give MAKER FOLDER BIN PAGE [STRIKES TARGETS]".into());
    };
    let number =
        |at: usize, otherwise: usize| numbers.get(at).map_or(Ok(otherwise), |text| text.parse());
    let (strikes, targets): (usize, usize) = (number(0, 100)?, number(1, 200)?);
    let lab = Lab::open(folder.as_ref(), bin.as_ref(), maker)?;
    let begun = Instant::now();
    let mut stops = lab.gather(strikes)?;
    let gathered = begun.elapsed();
    lab.learn()?;
    let learnt = begun.elapsed() - gathered;
    let (struck, refused) = lab.strike(targets, &mut stops)?;
    let repeats: Vec<Repeats> = struck
        .iter()
        .map(|struck| lab.repeats(struck))
        .collect::<Result<_, _>>()?;
    let counts = lab.emulator.table(|table| table.counts).unwrap_or_default();
    let text = page_of(
        &lab.arm,
        &struck,
        &repeats,
        [refused, stops, strikes],
        counts,
    )?;
    fs::write(page, &text)?;
    println!("{text}");
    println!(
        "gathered in {:.0} s, learnt in {:.0} s, all in {:.0} s",
        gathered.as_secs_f64(),
        learnt.as_secs_f64(),
        begun.elapsed().as_secs_f64()
    );
    Ok(())
}

impl Lab {
    /// The arm at its table, the camera, and the files that a user has.
    fn open(folder: &Path, bin: &Path, maker: &str) -> Result<Self, Failed> {
        fs::create_dir_all(folder)?;
        let kind = Maker::from_str(maker, true)?;
        let mut rig = kind.rig();
        rig.robot.travel_height = Some(0.1);
        let hide = Hide::parse(&HIDDEN)?;
        let truth = Truth {
            hidden: hide.hidden,
            ..Truth::demo(&rig, SEED)
        };
        fs::write(folder.join("rig.toml"), rig.to_toml())?;
        let address = IpAddr::V4(Ipv4Addr::LOCALHOST);
        let camera = Topic::serve((address, CAMERA_PORT).into(), &rig.topics.centroid.name)?;
        let table = Table::new(truth.clone(), Point::new(0.33, 0.0), true)?;
        let listening = Listening::Standard(address);
        let emulator = Emulator::start(kind, listening, kind.model(), None)?;
        let lab = Self {
            folder: folder.into(),
            bin: bin.into(),
            arm: format!("{maker}:{HOST}"),
            truth,
            emulator: emulator.with_table(table, (camera, rig.camera.rate)),
        };
        if !lab.folder.join("carom.key").exists() {
            lab.run("carom", &["key", "new", "--out", &lab.path("carom.key")])?;
        }
        Ok(lab)
    }

    fn path(&self, name: &str) -> String {
        self.folder.join(name).display().to_string()
    }

    fn program(&self, name: &str, arguments: &[&str]) -> Program {
        let mut program = Program::new(self.bin.join(name));
        program.args(arguments).stdin(Stdio::null());
        // Each emulated table is another one: where an object stopped on one is nothing to the next.
        let state = std::path::absolute(&self.folder).unwrap_or_else(|_| self.folder.clone());
        program.env("XDG_STATE_HOME", state);
        program
    }

    /// Runs a program to its end. Done, or done with some input rejected.
    fn run(&self, name: &str, arguments: &[&str]) -> Result<(), Failed> {
        eprintln!("{name} {}", arguments.join(" "));
        let status = self.program(name, arguments).status()?;
        match status.code() {
            Some(0 | 3) => Ok(()),
            _ => Err(format!("{name} {}: {status}", arguments.join(" ")).into()),
        }
    }

    /// Gathers strikes; gives how often the watchdog ended that.
    fn gather(&self, strikes: usize) -> Result<usize, Failed> {
        let camera = format!("ws://{HOST}:{CAMERA_PORT}");
        let arguments = [
            "collect",
            "--rig",
            &self.path("rig.toml"),
            "--robot",
            &self.arm,
            "--watch",
            &camera,
            "--strikes",
            &strikes.to_string(),
            "--out",
            &self.path("logs"),
            "--pause",
            "0.5",
            "--key",
            &self.path("carom.pub"),
        ];
        for stops in 0..STOPS {
            let status = self.program("carom", &arguments).status()?;
            match status.code() {
                Some(0 | 3) => return Ok(stops),
                Some(1 | 4) => eprintln!("carom collect: {status}; the same command goes on"),
                _ => return Err(format!("carom collect: {status}").into()),
            }
        }
        Err(format!("carom collect was stopped {STOPS} times").into())
    }

    fn learn(&self) -> Result<(), Failed> {
        self.run(
            "carom",
            &[
                "run",
                &self.path("logs"),
                "--rig",
                &self.path("rig.toml"),
                "--out",
                &self.path("run"),
                "--key",
                &self.path("carom.key"),
            ],
        )
    }

    /// Strikes at targets from wherever the hand puts the object. Also how many targets were refused; counts what was stopped.
    fn strike(
        &self,
        targets: usize,
        stops: &mut usize,
    ) -> Result<(Vec<TargetStrike>, usize), Failed> {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let (mut struck, mut refused) = (Vec::new(), 0);
        while struck.len() < targets && refused < DRAWS * targets && *stops < STOPS {
            let to = Point::new(
                0.50 + 0.35 * random.random::<f64>(),
                -0.25 + 0.5 * random.random::<f64>(),
            );
            self.wait_for_hand();
            match self.strike_at(to, stops)? {
                Some(one) => {
                    eprintln!(
                        "{:2}: {:.1} mm from the target",
                        struck.len() + 1,
                        one.miss() * 1e3
                    );
                    struck.push(one);
                }
                None => {
                    refused += 1;
                    // Where it lies may be what was refused.
                    self.emulator.table(Table::put_elsewhere);
                }
            }
        }
        Ok((struck, refused))
    }

    /// Waits until the object is put back.
    fn wait_for_hand(&self) {
        let lies_ready = || {
            self.emulator
                .table(|table| table.place(Instant::now()).x < 0.41)
                .unwrap_or(true)
        };
        while !lies_ready() {
            std::thread::sleep(std::time::Duration::from_millis(100));
        }
        std::thread::sleep(std::time::Duration::from_millis(600));
    }

    fn strike_at(&self, to: Point, stops: &mut usize) -> Result<Option<TargetStrike>, Failed> {
        let camera = format!("ws://{HOST}:{CAMERA_PORT}");
        let (x, y) = (to.x.to_string(), to.y.to_string());
        let output = self
            .program(
                "strike",
                &[
                    "--artifacts",
                    &self.path("run"),
                    "--key",
                    &self.path("carom.pub"),
                    "--rig",
                    &self.path("rig.toml"),
                    "--watch",
                    &camera,
                    "--to",
                    &x,
                    &y,
                    "--robot",
                    &self.arm,
                    "--pause",
                    "0",
                    "--json",
                ],
            )
            .output()?;
        match output.status.code() {
            Some(0) => {}
            Some(4) => return Ok(None),
            code => {
                let printed = String::from_utf8_lossy(&output.stderr).into_owned();
                if !matches!(code, Some(1 | 3)) {
                    return Err(format!("strike: {}: {printed}", output.status).into());
                }
                // Stopped before the impact or after it, or not seen to its end: the target is drawn again.
                eprintln!("{printed}");
                *stops += 1;
                return Ok(None);
            }
        }
        // A hand may have put the object back by now: its stop is kept.
        let stop = self.emulator.table(|table| table.stop.take()).flatten();
        let plan: serde_json::Value = serde_json::from_slice(&output.stdout)?;
        let number = |value: &serde_json::Value| value.as_f64().ok_or("no number in the answer");
        let point = |value: &serde_json::Value| -> Result<Point, Failed> {
            Ok(Point::new(number(&value[0])?, number(&value[1])?))
        };
        Ok(Some(TargetStrike {
            from: point(&plan["from"])?,
            to,
            command: Command::new(number(&plan["speed"])?, number(&plan["angle"])?),
            delivered: number(&plan["delivered_speed"])?,
            stop: stop.ok_or("the strike did not meet the object")?,
        }))
    }

    /// Repeats of the command that was sent; their mean distance from their mean is widened for the mean's own error.
    fn repeats(&self, struck: &TargetStrike) -> Result<Repeats, Failed> {
        let mut sim = Sim::from(self.truth.clone())?.after(100_000);
        let stops: Vec<Point> = (0..REPEATS)
            .map(|_| sim.meet(struck.from, struck.command, 0.0).stop())
            .collect();
        let n = f64::from(REPEATS);
        let mean = stops.iter().fold(Point::default(), |sum, stop| sum + *stop) * (1.0 / n);
        let from = |point: Point| stops.iter().map(|stop| stop.distance(point)).sum::<f64>() / n;
        Ok(Repeats {
            scatter: (n / (n - 1.0)).sqrt() * from(mean),
            miss: from(struck.to),
        })
    }
}

impl TargetStrike {
    fn miss(&self) -> f64 {
        self.stop.distance(self.to)
    }
}

/// The ratio of two means, and its standard error: what the one scatters by about it.
fn ratio(pairs: &[(f64, f64)]) -> (f64, f64) {
    let sum = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>();
    let below = sum(|pair| pair.1);
    let ratio = sum(|pair| pair.0) / below;
    let about = pairs
        .iter()
        .map(|(one, other)| (one - ratio * other).powi(2));
    (ratio, about.sum::<f64>().sqrt() / below)
}

fn page_of(
    arm: &str,
    struck: &[TargetStrike],
    repeats: &[Repeats],
    [refused, stops, strikes]: [usize; 3],
    (met, again): (usize, usize),
) -> Result<String, Failed> {
    let mean =
        |numbers: &mut dyn Iterator<Item = f64>| numbers.sum::<f64>() / struck.len().max(1) as f64;
    let miss = mean(&mut struck.iter().map(TargetStrike::miss));
    let floor = mean(&mut repeats.iter().map(|repeats| repeats.scatter));
    let over = |miss: &mut dyn Iterator<Item = f64>| {
        let pairs: Vec<(f64, f64)> = miss.zip(repeats.iter().map(|one| one.scatter)).collect();
        ratio(&pairs)
    };
    let (by_strikes, error) = over(&mut struck.iter().map(TargetStrike::miss));
    let (by_repeats, error_of_repeats) = over(&mut repeats.iter().map(|repeats| repeats.miss));
    let off = struck
        .iter()
        .map(|one| (one.delivered / one.command.speed - 1.0).abs())
        .fold(0.0, f64::max);
    let mut page = format!(
        "# From no data to targets on the emulated arm\n\n\
         `make loop`: an object lies before the emulated arm `{arm}`; its physics is the embedded rig's (hidden: {}), moved by what the arm's \
         motion delivers, and a camera publishes where it is over the Foxglove WebSocket protocol. `carom collect` gathers {strikes} \
         strikes, `carom run --key` learns from them, and `strike --watch` strikes each target from where a hand put the object.\n\n\
         | | |\n|---|---|\n\
         | targets struck | {} |\n\
         | targets drawn and not struck: refused, or stopped | {refused} |\n\
         | times that the watchdog stopped the arm and the same command went on | {stops} |\n\
         | mean miss | {:.2} mm |\n\
         | mean scatter of repeats of the same commands ({REPEATS} each): the floor | {:.2} mm |\n\
         | mean miss over the floor, and its standard error | {by_strikes:.2} ± {error:.2} |\n\
         | the same by those repeats, which hold the command alone: no arm, and not the luck of one strike | {by_repeats:.3} ± \
         {error_of_repeats:.3} |\n\
         | delivered speed at contact, farthest from the command | {:.2} % |\n\
         | strikes that met the object; times that the tip came into it again (since this emulator began) | {met}; {again} |\n\n\
         | from, m | to, m | command | delivered, m/s | miss, mm | repeats, mm |\n|---|---|---|---|---|---|\n",
        HIDDEN.join(", "),
        struck.len(),
        miss * 1e3,
        floor * 1e3,
        off * 100.0,
    );
    for (one, repeats) in struck.iter().zip(repeats) {
        writeln!(
            page,
            "| {:.3}, {:.3} | {:.3}, {:.3} | {:.3} m/s, {:+.3} rad | {:.4} | {:.1} | {:.1} |",
            one.from.x,
            one.from.y,
            one.to.x,
            one.to.y,
            one.command.speed,
            one.command.angle,
            one.delivered,
            one.miss() * 1e3,
            repeats.scatter * 1e3
        )?;
    }
    Ok(page)
}
