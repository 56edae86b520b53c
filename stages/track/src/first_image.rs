//! The first image of a log: what a camera's colour range or pose is found from.

use std::path::Path;

use logs::read::read_raw;
use logs::{Limits, LogError};

use crate::{Decoder, Image, ImageMessage, TrackError, is_image};

/// Why reading ends.
enum End {
    Found(Box<Image>),
    Failed(LogError),
}

impl From<LogError> for End {
    fn from(error: LogError) -> Self {
        Self::Failed(error)
    }
}

/// The first image of a log that can be decoded, of this topic or, without one, of any topic of images.
///
/// # Errors
/// The log cannot be read, or holds no such image.
pub fn first_image(log: &Path, topic: Option<&str>) -> Result<Image, TrackError> {
    let mut decoder = Decoder::default();
    let mut why = None;
    let read = read_raw(log, Limits::default(), &mut |message| {
        let channel = message.channel;
        let is_other = topic.is_some_and(|topic| channel.topic != topic);
        if is_other || !is_image(&channel.schema) {
            return Ok(());
        }
        let parsed = ImageMessage::parse(&channel.schema, &channel.encoding, message.data);
        match parsed.and_then(|message| decoder.decode(&message).cloned()) {
            Ok(image) => Err(End::Found(Box::new(image))),
            Err(error) => {
                why.get_or_insert(error.to_string());
                Ok(())
            }
        }
    });
    match read {
        Err(End::Found(image)) => Ok(*image),
        Err(End::Failed(error)) => Err(TrackError::Log(error)),
        Ok(_) => Err(TrackError::NoImage {
            log: log.display().to_string(),
            why: why.unwrap_or_else(|| match topic {
                Some(topic) => format!("no images are on the rig file's topic {topic}"),
                None => "no topic of it holds images".into(),
            }),
        }),
    }
}
