//! An emulated arm's controller as a program of its own.

use std::error::Error;
use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Parser;

use arm::foxglove::Topic;
use arm::{Emulator, Listening, Maker, Table};
use rig::Truth;
use values::Point;

/// Port of the camera's topic: the one of Foxglove's servers.
const CAMERA_PORT: u16 = 8765;
/// Where the object lies at first, in m.
const FIRST: Point = Point::new(0.33, 0.0);

/// A controller of an arm that is not there, until it is interrupted: it listens on the maker's own ports, of which 502 needs root.
#[derive(Parser)]
#[command(name = "arm-emulator")]
struct Args {
    /// Whose controller.
    maker: Maker,
    /// Address that it listens on.
    #[arg(default_value = "127.0.0.1")]
    address: IpAddr,
    /// A truth.json, as `carom demo` writes it: its object lies before the arm, a hand puts it back after each strike, and a camera publishes
    /// where it is at ws://ADDRESS:8765.
    truth: Option<PathBuf>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let Args {
        maker,
        address,
        truth,
    } = Args::parse();
    let ends = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, ends.clone())?;
    }
    let mut emulator = Emulator::start(maker, Listening::Standard(address), maker.model(), None)?;
    if let Some(path) = truth {
        let truth = Truth::load(&path)?;
        let topic = &truth.rig.topics.centroid.name;
        let camera = Topic::serve((address, CAMERA_PORT).into(), topic)?;
        let rate = truth.rig.camera.rate;
        emulator = emulator.with_table(Table::new(truth, FIRST, true)?, (camera, rate));
    }
    println!("an arm listens on {address}");
    while !ends.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(50));
    }
    if let Some((strikes, again)) = emulator.table(|table| table.counts) {
        println!("{strikes} strikes met the object; {again} came into it again");
    }
    Ok(())
}
