//! `carom camera tune`: a colour range from an image.

use std::fs;
use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};
use track::{Image, Tracker, Tuned, draw_observation, png_of};
use values::{Point, Rig};

use super::typed::load_image;
use super::typed::pixel;
use crate::Error;
use crate::error::Output;
use crate::inputs::load_rig;

/// `carom camera tune`.
#[derive(Args, Debug)]
pub struct TuneArgs {
    /// An image of the object on the table: JPEG, PNG, or a log (.mcap), whose first image (on the rig file's topic) is taken.
    #[arg(value_name = "IMAGE")]
    pub image: PathBuf,
    /// A pixel of the object [default: the pixels whose colour differs most from the table's, with --rig of what has the object's size].
    #[arg(long, value_name = "U,V", value_parser = pixel)]
    pub pixel: Option<[usize; 2]>,
    /// A rig file with the camera's lens and pose: the object is then also found as `carom track` does.
    #[arg(long, value_name = "FILE")]
    pub rig: Option<PathBuf>,
    /// Picture to write (PNG): what is outside the range is dark.
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
}

/// Proposes the range, and draws it.
pub(super) fn tune(args: &TuneArgs) -> Result<Output, Error> {
    let rig = args.rig.as_deref().map(load_rig).transpose()?;
    if fs::canonicalize(&args.out).is_ok_and(|out| fs::canonicalize(&args.image).ok() == Some(out))
    {
        let why = "write the picture over the image that is read; name another file with --out";
        return Err(Error::input(why));
    }
    let image = load_image(&args.image, rig.as_ref())?;
    // A colour that is seen elsewhere more than there is the table's.
    let is_object = |tuned: &Tuned| {
        let rig = rig.clone().map(|rig| with_colour(rig, tuned));
        let tracker = rig.and_then(|rig| Tracker::new(&rig).ok());
        let is_of_size = |tracker: Tracker| tracker.is_of_size(tuned.pixel, tuned.area as f64);
        tuned.elsewhere < tuned.area && tracker.is_none_or(is_of_size)
    };
    let tuned = Tuned::propose(&image, args.pixel, Some(&is_object)).map_err(Error::input)?;
    let mut picture = image.clone();
    let pixels = picture.rgb.chunks_exact_mut(3).zip(&tuned.found);
    for (pixel, _) in pixels.filter(|(_, found)| !**found) {
        pixel.iter_mut().for_each(|byte| *byte /= 4);
    }
    let found = rig.map(|rig| look(rig, &tuned, &image, &mut picture));
    let (seen, found) = found.unzip();
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
        "colour": colour, "pixel": tuned.pixel, "area": tuned.area, "elsewhere": tuned.elsewhere, "picture": args.out, "found": seen,
    });
    Ok(Output::done(json, text))
}

/// Finds the object as `carom track` would with the colour proposed, draws it, and reports the result: as data and in words.
fn look(rig: Rig, tuned: &Tuned, image: &Image, picture: &mut Image) -> (Value, String) {
    match Tracker::new(&with_colour(rig, tuned)) {
        Err(error) => {
            let why = format!("not tracked, for it failed to {error}\n");
            (json!({ "trusted": false, "why": why.trim() }), why)
        }
        Ok(tracker) => {
            let observation = tracker.observe(image);
            draw_observation(picture, &observation);
            match observation.centre {
                Ok(Point { x, y }) => {
                    let quality = observation.quality;
                    let found = json!({ "trusted": true, "x": x, "y": y, "quality": quality });
                    let said = format!(
                        "found at x = {x:.4} m, y = {y:.4} m on the table, quality {quality:.2}\n"
                    );
                    (found, said)
                }
                Err(reason) => {
                    let said = format!(
                        "`carom track` would not trust this frame: {}\n",
                        reason.name()
                    );
                    (json!({ "trusted": false, "reason": reason }), said)
                }
            }
        }
    }
}

fn with_colour(mut rig: Rig, tuned: &Tuned) -> Rig {
    rig.object.colour = Some(tuned.colour);
    rig
}
