//! `arm-emulator [ADDRESS]`: an xArm7's controller on the maker's ports of an address, 127.0.0.1 unless given, until it is
//! interrupted.

use std::error::Error;
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use arm::{Emulator, Listening, Model};

fn main() -> Result<(), Box<dyn Error>> {
    let address: IpAddr = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "127.0.0.1".into())
        .parse()?;
    let ends = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, ends.clone())?;
    }
    let _emulator = Emulator::start(Listening::Standard(address), Model::default(), None)?;
    println!("an xArm7 listens on {address}, ports 502, 30000 and 30001");
    while !ends.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(50));
    }
    Ok(())
}
