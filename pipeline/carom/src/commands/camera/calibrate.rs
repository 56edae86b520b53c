//! `carom camera calibrate`: a lens from images of a board, a pose from points of the table or from the board on it.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;
use track::{Calibration, KnownLens, Lens, LensFit, SeenPoint, Workspace};
use values::Rig;

use super::board::BoardArgs;
use super::typed::{point, size};
use crate::Error;
use crate::error::Output;
use crate::inputs::load_rig;
use crate::outputs::{ORDINARY, write_new};

/// `carom camera calibrate`.
#[derive(Args, Debug)]
pub struct CalibrateArgs {
    /// The rig file: the table, the object, and the lens where it is known.
    #[arg(long, value_name = "FILE")]
    pub rig: PathBuf,
    /// A board and images of it.
    #[command(flatten)]
    pub board: BoardArgs,
    /// A point and its pixel: X,Y,U,V on the table or X,Y,Z,U,V above it (m, px); four or more.
    #[arg(long = "point", value_name = "X,Y[,Z],U,V", value_parser = point, allow_hyphen_values = true, conflicts_with = "table")]
    pub points: Vec<SeenPoint>,
    /// Pixels of the image; needed where neither the rig file nor a board gives the lens.
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = size)]
    pub size: Option<[usize; 2]>,
    /// Write the rig file with the camera found, which must not be there yet.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Finds lens and pose, as far as the images or points given determine them.
pub(super) fn calibrate(args: &CalibrateArgs) -> Result<Output, Error> {
    let mut rig = load_rig(&args.rig)?;
    let board = args.board.board()?;
    let lens = match &board {
        Some(board) => args.board.lens(board, &rig)?,
        None => None,
    };
    if let Some(fit) = &lens {
        rig.camera.matrix = Some(fit.lens.matrix);
        rig.camera.distortion = Some(fit.lens.distortion);
        rig.camera.size = Some(fit.size.map(|pixels| pixels as u32));
    }
    let on_table = match &board {
        Some(board) => args.board.on_table(board, &rig)?,
        None => Vec::new(),
    };
    let pose = pose(args, &rig, &on_table)?;
    if let Some(pose) = &pose {
        if let (None, Some(size)) = (rig.camera.matrix, args.size) {
            rig.camera.size = Some(size.map(|pixels| pixels as u32));
        }
        rig.camera.matrix = Some(pose.lens.matrix);
        rig.camera.position = Some(pose.position);
        rig.camera.orientation = Some(pose.orientation);
    }
    if lens.is_none() && pose.is_none() {
        return Err(Error::input(
            "calibrate without points and images: type four points or more with --point, or name images of a board, or --table",
        ));
    }
    if let Some(path) = &args.out {
        write_new(path, ORDINARY, rig.to_toml().as_bytes())?;
    }
    Ok(said(args, &rig, lens.as_ref(), pose.as_ref()))
}

fn pose(
    args: &CalibrateArgs,
    rig: &Rig,
    on_table: &[SeenPoint],
) -> Result<Option<Calibration>, Error> {
    let known = rig.camera.matrix.map(|matrix| Lens {
        matrix,
        distortion: rig.camera.distortion.unwrap_or_default(),
    });
    let workspace = Workspace {
        table: [rig.table.x, rig.table.y],
        height: rig.object.solid.half_height(),
    };
    let found = match (known, args.size) {
        _ if on_table.is_empty() && args.points.is_empty() => return Ok(None),
        (Some(lens), _) if args.points.is_empty() => {
            Calibration::from_board(on_table, lens, workspace)
        }
        (None, _) if args.points.is_empty() => {
            return Err(Error::input(
                "find camera.matrix in the rig file: name images of the board from other sides as well, and the lens is found from them",
            ));
        }
        (Some(lens), _) => Calibration::from_points(&args.points, KnownLens::Lens(lens), workspace),
        (None, Some(size)) => {
            Calibration::from_points(&args.points, KnownLens::Size(size), workspace)
        }
        (None, None) => {
            return Err(Error::input(
                "find camera.matrix in the rig file: give the image's size with --size WIDTHxHEIGHT, and the focal length is found as well",
            ));
        }
    };
    found.map(Some).map_err(Error::input)
}

fn said(
    args: &CalibrateArgs,
    rig: &Rig,
    lens: Option<&LensFit>,
    pose: Option<&Calibration>,
) -> Output {
    let mut text = String::from("[camera]\n");
    let line = |key: &str, numbers: Option<&[f64]>, digits: usize| match numbers {
        Some(numbers) => format!("{key} = [{}]\n", listed(numbers, digits)),
        None => String::new(),
    };
    let camera = &rig.camera;
    text += &line("matrix", camera.matrix.as_ref().map(|all| &all[..]), 2);
    if let Some([width, height]) = camera.size {
        text += &format!("size = [{width}, {height}]\n");
    }
    if lens.is_some() {
        let distortion = camera.distortion.as_ref();
        text += &line("distortion", distortion.map(|all| &all[..]), 6);
    }
    if let Some(pose) = pose {
        text += &line("position", Some(&pose.position), 4);
        text += &line("orientation", Some(&pose.orientation), 6);
    }
    text += "\n";
    let mut unused = Vec::new();
    if let Some(fit) = lens {
        let views = args.board.images.iter().zip(&fit.views);
        unused.extend(
            views
                .filter(|(_, view)| view.is_none())
                .map(|(path, _)| path),
        );
        text += &format!(
            "lens       reprojection error {:.2} px rms ({} corners in {} of {} images), focal length known to {:.2} % (standard error)\n",
            fit.error,
            fit.corners,
            fit.views.len() - unused.len(),
            fit.views.len(),
            100.0 * fit.unsure
        );
        for path in &unused {
            text += &format!("           too little of the board in {}\n", path.display());
        }
    }
    match pose {
        Some(pose) => {
            text += &format!(
                "pose       reprojection error {:.2} px rms, {:.2} px at worst ({} points)\n\
                 \x20          the object's place is known to {:.1} mm or better over the table (standard error)\n",
                pose.error,
                pose.worst,
                pose.points,
                1e3 * pose.unsure
            );
        }
        None => {
            text += "pose       not found yet: lay the board on the table and name an image of it with --table, or type points with --point\n";
        }
    }
    if let Some(path) = &args.out {
        text += &format!("rig file   {}\n", path.display());
    }
    let json = json!({
        "matrix": camera.matrix, "size": camera.size, "distortion": camera.distortion.unwrap_or_default(),
        "position": pose.map(|pose| pose.position), "orientation": pose.map(|pose| pose.orientation),
        "points": pose.map(|pose| pose.points), "reprojection_error": pose.map(|pose| pose.error),
        "worst": pose.map(|pose| pose.worst), "place_error": pose.map(|pose| pose.unsure),
        "lens": lens.map(|fit| json!({
            "reprojection_error": fit.error, "corners": fit.corners, "images": fit.views, "unused": unused, "focal_length_error": fit.unsure,
        })),
        "rig": args.out,
    });
    Output::done(json, text)
}

fn listed(numbers: &[f64], digits: usize) -> String {
    let numbers: Vec<_> = numbers
        .iter()
        .map(|number| format!("{number:.digits$}"))
        .collect();
    numbers.join(", ")
}
