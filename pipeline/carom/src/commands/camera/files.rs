//! Images in, pictures and rig files out.

use std::fs;
use std::path::Path;

use track::{Decoder, Image, ImageMessage, Payload, first_image};
use values::Rig;

use crate::Error;

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
