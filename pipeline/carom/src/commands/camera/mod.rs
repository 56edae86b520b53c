//! `carom camera`: where the camera is, how its lens bends, and which colour the object has.

mod board;
mod calibrate;
mod tune;
mod typed;

use clap::Subcommand;

use crate::Error;
use crate::args::examples;
use crate::error::Output;

/// `carom camera`.
#[derive(Debug, Subcommand)]
pub enum CameraCommand {
    /// Find the camera's lens from images of a ChArUco board, and its pose from points of the table and their pixels or from the board on it.
    #[command(after_help = examples(&[
        "carom camera calibrate views/*.png --board 5x7 --square 0.04 --marker 0.028 --dictionary DICT_5X5_100 --rig rig.toml --out lens.toml",
        "carom camera calibrate views/*.png --board 5x7 --square 0.04 --marker 0.028 --dictionary DICT_5X5_100 --table lying.png --corners 0.72,0.10,0.72,-0.10 --rig rig.toml --out calibrated.toml",
        "carom camera calibrate --rig lens.toml --point 0.20,-0.40,520,418 --point 0.20,0.40,119,418 --point 0.90,0.40,137,87 --point 0.90,-0.40,502,87 --point 0.55,0.00,319,244",
        "carom camera calibrate --rig rig.toml --size 640x480 --point 0.20,-0.40,524,420 --point 0.20,0.40,115,420 --point 0.90,0.40,135,85 --point 0.90,-0.40,504,85 --point 0.30,-0.30,0.20,501,373 --point 0.30,0.30,0.20,138,373 --point 0.80,0.30,0.20,153,89 --point 0.80,-0.30,0.20,486,89 --out calibrated.toml",
    ]))]
    Calibrate(calibrate::CalibrateArgs),
    /// Propose the object's colour range from an image, and write a picture of what it finds.
    #[command(after_help = examples(&[
        "carom camera tune frame.png --rig rig.toml --out found.png",
        "carom camera tune session.mcap --rig rig.toml --out found.png",
        "carom camera tune frame.jpg --pixel 412,233 --out found.png",
    ]))]
    Tune(tune::TuneArgs),
}

/// Does what was asked.
pub fn run(command: &CameraCommand) -> Result<Output, Error> {
    match command {
        CameraCommand::Calibrate(args) => calibrate::calibrate(args),
        CameraCommand::Tune(args) => tune::tune(args),
    }
}
