//! `arm-watch URL`: where a server's live topics show the object of the demo's rig at rest, and what was received in a second; one JSON
//! object. For servers that nobody here wrote.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use strike::Live;
use values::{Rig, Shape};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let url = std::env::args().nth(1).ok_or("give the server's URL")?;
    let live = Live::connect(&url, &Rig::demo(Shape::Cylinder))?;
    let rest = live.wait_for_rest(Duration::from_secs(5), &AtomicBool::new(false))?;
    live.record();
    std::thread::sleep(Duration::from_secs(1));
    let (received, left_out) = live.recorded(strike::Epoch::now());
    let channel = received.first().map(|message| &message.channel);
    println!(
        "{}",
        serde_json::json!({
            "x": rest.point.x,
            "y": rest.point.y,
            "yaw": rest.yaw,
            "messages": received.len(),
            "left_out": left_out,
            "topic": channel.map(|channel| &channel.topic),
            "encoding": channel.map(|channel| &channel.encoding),
            "schema_encoding": channel.map(|channel| &channel.schema_encoding),
        })
    );
    Ok(())
}
