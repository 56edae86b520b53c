//! Points, sizes and pixels as they are typed.

use std::fs;
use std::path::Path;

use track::{Decoder, Image, ImageMessage, Payload, SeenPoint, first_image};
use values::Rig;

use crate::Error;

/// Numbers between commas.
fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{part}` is no number")),
    };
    text.split(',').map(number).collect()
}

/// `X,Y,U,V` or `X,Y,Z,U,V`.
pub(super) fn point(text: &str) -> Result<SeenPoint, String> {
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

/// `X,Y,X,Y`: two places on the table.
pub(super) fn places(text: &str) -> Result<[[f64; 2]; 2], String> {
    match numbers(text)?[..] {
        [x, y, other_x, other_y] => Ok([[x, y], [other_x, other_y]]),
        _ => Err("four numbers X,Y,X,Y are needed".into()),
    }
}

fn whole(text: &str, separator: char) -> Option<[usize; 2]> {
    let (first, second) = text.split_once(separator)?;
    Some([first.trim().parse().ok()?, second.trim().parse().ok()?])
}

/// `WIDTHxHEIGHT`.
pub(super) fn size(text: &str) -> Result<[usize; 2], String> {
    let size = whole(text, 'x').filter(|size| size.iter().all(|pixels| *pixels > 0));
    size.ok_or_else(|| "two whole numbers such as 1280x720 are needed".into())
}

/// `U,V`.
pub(super) fn pixel(text: &str) -> Result<[usize; 2], String> {
    whole(text, ',').ok_or_else(|| "two whole numbers such as 412,233 are needed".into())
}

/// Reads a JPEG or PNG, or the first image of a log: of the rig file's topic, where it names one.
pub(super) fn load_image(path: &Path, rig: Option<&Rig>) -> Result<Image, Error> {
    if logs::is_log(path) {
        let topic = rig.and_then(|rig| rig.topics.image.as_ref());
        return first_image(path, topic.map(|topic| topic.name.as_str())).map_err(Error::input);
    }
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
