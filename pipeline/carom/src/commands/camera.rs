//! `carom camera`: where the camera is, how its lens bends, and which colour the object has.

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use serde_json::json;
use track::{
    Calibration, Decoder, Image, ImageMessage, KnownLens, Lens, Payload, SeenPoint, Tracker, Tuned,
    Workspace, draw_observation, png_of,
};
use values::{Object, Rig, Shape};

use crate::Error;
use crate::args::examples;
use crate::inputs::load_rig;
use crate::output::Output;

/// `carom camera`.
#[derive(Debug, Subcommand)]
pub enum CameraCommand {
    /// Find the camera's pose, and its focal length where the rig file has no lens, from points of the table and their pixels.
    #[command(after_help = examples(&[
        "carom camera calibrate --rig rig.toml --point 0.20,-0.30,912,596 --point 0.20,0.40,121,604 --point 0.80,0.40,118,31 --point 0.80,-0.30,915,27",
        "carom camera calibrate --rig rig.toml --size 1280x720 --point 0.2,-0.3,0.15,930,610 --point 0.2,0.4,0.15,110,618 --point 0.8,0.4,120,31 --point 0.8,-0.3,914,28 --out calibrated.toml",
    ]))]
    Calibrate(CalibrateArgs),
    /// Propose the object's colour range from an image, and write a picture of what it finds.
    #[command(after_help = examples(&[
        "carom camera tune frame.png --rig rig.toml --out found.png",
        "carom camera tune frame.jpg --pixel 412,233 --out found.png",
    ]))]
    Tune(TuneArgs),
}

/// `carom camera calibrate`.
#[derive(Args, Debug)]
pub struct CalibrateArgs {
    /// The rig file: the table, the object, and the lens where it is known.
    #[arg(long, value_name = "FILE")]
    pub rig: PathBuf,
    /// A point and its pixel: X,Y,U,V on the table or X,Y,Z,U,V above it (m, px); four or more.
    #[arg(long = "point", required = true, value_name = "X,Y[,Z],U,V", value_parser = point, allow_hyphen_values = true)]
    pub points: Vec<SeenPoint>,
    /// Pixels of the image; needed where the rig file has no `camera.matrix`.
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = size)]
    pub size: Option<[usize; 2]>,
    /// Write the rig file with the camera found, which must not be there yet.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// `carom camera tune`.
#[derive(Args, Debug)]
pub struct TuneArgs {
    /// An image of the object on the table, JPEG or PNG.
    #[arg(value_name = "IMAGE")]
    pub image: PathBuf,
    /// A pixel of the object [default: the pixels whose colour differs most from the table's].
    #[arg(long, value_name = "U,V", value_parser = pixel)]
    pub pixel: Option<[usize; 2]>,
    /// A rig file with the camera's lens and pose: the object is then also found as `carom track` does.
    #[arg(long, value_name = "FILE")]
    pub rig: Option<PathBuf>,
    /// Picture to write (PNG): what is outside the range is dark.
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
}

/// Does what was asked.
pub fn run(command: &CameraCommand) -> Result<Output, Error> {
    match command {
        CameraCommand::Calibrate(args) => calibrate(args),
        CameraCommand::Tune(args) => tune(args),
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{part}` is no number")),
    };
    text.split(',').map(number).collect()
}

fn point(text: &str) -> Result<SeenPoint, String> {
    match numbers(text)?[..] {
        [x, y, u, v] => Ok(SeenPoint {
            at: [x, y, 0.0],
            pixel: [u, v],
        }),
        [x, y, z, u, v] => Ok(SeenPoint {
            at: [x, y, z],
            pixel: [u, v],
        }),
        _ => Err("four numbers X,Y,U,V or five X,Y,Z,U,V are needed".into()),
    }
}

fn whole(text: &str, separator: char) -> Option<[usize; 2]> {
    let (first, second) = text.split_once(separator)?;
    Some([first.trim().parse().ok()?, second.trim().parse().ok()?])
}

fn size(text: &str) -> Result<[usize; 2], String> {
    let size = whole(text, 'x').filter(|size| size.iter().all(|pixels| *pixels > 0));
    size.ok_or_else(|| "two whole numbers such as 1280x720 are needed".into())
}

fn pixel(text: &str) -> Result<[usize; 2], String> {
    whole(text, ',').ok_or_else(|| "two whole numbers such as 412,233 are needed".into())
}

fn calibrate(args: &CalibrateArgs) -> Result<Output, Error> {
    let mut rig = load_rig(&args.rig)?;
    let known = match (rig.camera.matrix, args.size) {
        (Some(matrix), _) => KnownLens::Lens(Lens {
            matrix,
            distortion: rig.camera.distortion.unwrap_or_default(),
        }),
        (None, Some(size)) => KnownLens::Size(size),
        (None, None) => {
            return Err(Error::input(
                "find camera.matrix in the rig file: give the image's size with --size WIDTHxHEIGHT, and the focal length is found as well",
            ));
        }
    };
    let used = Workspace {
        table: [rig.table.x, rig.table.y],
        height: half_height(&rig.object),
    };
    let found = Calibration::from_points(&args.points, known, used).map_err(Error::input)?;
    rig.camera.matrix = Some(found.lens.matrix);
    rig.camera.position = Some(found.position);
    rig.camera.orientation = Some(found.orientation);
    let keys = [
        ("matrix", &found.lens.matrix[..], 2),
        ("position", &found.position[..], 4),
        ("orientation", &found.orientation[..], 6),
    ];
    let lines: String = keys
        .iter()
        .map(|(key, numbers, digits)| format!("{key} = [{}]\n", listed(numbers, *digits)))
        .collect();
    let written = match &args.out {
        None => String::new(),
        Some(path) => {
            write_new(path, rig.to_toml().as_bytes())?;
            format!("rig file   {}\n", path.display())
        }
    };
    let text = format!(
        "[camera]\n{lines}\nreprojection error {:.2} px rms, {:.2} px at worst ({} points)\n\
         the object's place is known to {:.1} mm or better over the table (standard error)\n{written}",
        found.error,
        found.worst,
        args.points.len(),
        1e3 * found.unsure
    );
    let json = json!({
        "matrix": found.lens.matrix, "distortion": found.lens.distortion, "position": found.position,
        "orientation": found.orientation, "points": args.points.len(), "reprojection_error": found.error,
        "worst": found.worst, "place_error": found.unsure, "rig": args.out,
    });
    Ok(Output::done(json, text))
}

fn half_height(object: &Object) -> f64 {
    let height = match object.shape {
        Shape::Cylinder => object.half_height,
        Shape::Sphere => object.radius,
        Shape::Box => object.half_size.map(|[_, _, z]| z),
    };
    height.unwrap_or_default()
}

fn listed(numbers: &[f64], digits: usize) -> String {
    let numbers: Vec<_> = numbers
        .iter()
        .map(|number| format!("{number:.digits$}"))
        .collect();
    numbers.join(", ")
}

fn tune(args: &TuneArgs) -> Result<Output, Error> {
    let rig = args.rig.as_deref().map(load_rig).transpose()?;
    let image = load_image(&args.image)?;
    let tuned = Tuned::propose(&image, args.pixel).map_err(Error::input)?;
    let mut picture = image.clone();
    let pixels = picture.rgb.chunks_exact_mut(3).zip(&tuned.found);
    for (pixel, _) in pixels.filter(|(_, found)| !**found) {
        pixel.iter_mut().for_each(|byte| *byte /= 4);
    }
    let found = rig.map(|rig| look(rig, &tuned, &image, &mut picture));
    let png = png_of(&picture).ok_or_else(|| Error::failed("encode the picture"))?;
    fs::write(&args.out, png)
        .map_err(|error| Error::input(format!("write {}: {error}", args.out.display())))?;

    let colour = &tuned.colour;
    let ends = |interval: values::Interval| format!("[{}, {}]", interval.low, interval.high);
    let [u, v] = tuned.pixel;
    let elsewhere = if tuned.elsewhere == 0 {
        String::new()
    } else {
        format!(
            "{} pixels of the range lie elsewhere in the image, {:.0} % of the object's: see the picture\n",
            tuned.elsewhere,
            100.0 * tuned.elsewhere as f64 / tuned.area as f64
        )
    };
    let text = format!(
        "[object]\ncolour = {{ hue = {}, saturation = {}, value = {} }}\n\n\
         {} pixels about {u:.0}, {v:.0}\n{elsewhere}{}picture    {}\n",
        ends(colour.hue),
        ends(colour.saturation),
        ends(colour.value),
        tuned.area,
        found.as_deref().unwrap_or_default(),
        args.out.display()
    );
    let json = json!({
        "colour": colour, "pixel": tuned.pixel, "area": tuned.area, "elsewhere": tuned.elsewhere, "picture": args.out,
    });
    Ok(Output::done(json, text))
}

/// Finds the object as `carom track` would with the colour proposed, draws it, and says what came of it.
fn look(mut rig: Rig, tuned: &Tuned, image: &Image, picture: &mut Image) -> String {
    rig.object.colour = Some(tuned.colour);
    match Tracker::new(&rig) {
        Err(error) => format!("not tracked, for it failed to {error}\n"),
        Ok(tracker) => {
            let observation = tracker.observe(image);
            draw_observation(picture, &observation);
            match observation.centre {
                Ok(centre) => format!(
                    "found at x = {:.4} m, y = {:.4} m on the table, quality {:.2}\n",
                    centre.x, centre.y, observation.quality
                ),
                Err(reason) => format!(
                    "`carom track` would not trust this frame: {}\n",
                    reason.name()
                ),
            }
        }
    }
}

fn load_image(path: &Path) -> Result<Image, Error> {
    let data = fs::read(path).map_err(|error| Error::unreadable(path, &error))?;
    let message = ImageMessage {
        stamp: 0,
        payload: Payload::Compressed(&data),
    };
    let mut decoder = Decoder::default();
    let image = decoder
        .decode(&message)
        .map_err(|error| Error::input(format!("read the image {}: {error}", path.display())))?;
    Ok(image.clone())
}

fn write_new(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    use std::io::Write;
    let created = fs::File::create_new(path);
    let written = created.and_then(|mut file| file.write_all(bytes));
    written.map_err(|error| {
        Error::input(format!(
            "write {}: {error}; name a file that is not there yet",
            path.display()
        ))
    })
}
