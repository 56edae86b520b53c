//! `arm-emulator [ADDRESS]`: an xArm7's controller on the maker's ports of an address, 127.0.0.1 unless given, until it is
//! interrupted. `arm-emulator ADDRESS TRUTH`: the same with a table before it, the embedded rig of a `truth.json`, whose object a
//! hand puts back after each strike, and with its camera's topic at ws://ADDRESS:8765. `arm-emulator ur …`: a Universal Robots controller.

use std::error::Error;
use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use arm::foxglove::Topic;
use arm::{Emulator, Listening, Model, Table};
use rig::Truth;
use values::Point;

/// Port of the camera's topic: the one of Foxglove's servers.
const CAMERA_PORT: u16 = 8765;
/// Where the object lies at first, in m.
const FIRST: Point = Point::new(0.33, 0.0);

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1).peekable();
    let is_ur = arguments.next_if(|text| text == "ur").is_some();
    let address: IpAddr = arguments
        .next()
        .unwrap_or_else(|| "127.0.0.1".into())
        .parse()?;
    let truth: Option<PathBuf> = arguments.next().map(Into::into);
    let ends = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, ends.clone())?;
    }
    let listening = Listening::Standard(address);
    let mut emulator = if is_ur {
        Emulator::start_ur(listening, Model::ur(), None)?
    } else {
        Emulator::start(listening, Model::default(), None)?
    };
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
