//! Some images of a log: the first one, and small ones that are shown beside strikes.

use std::collections::BTreeMap;
use std::path::Path;

use logs::read::{RawChannel, RawMessage, read_raw};
use logs::{Limits, LogError};

use crate::draw::jpeg_of;
use crate::image::square;
use crate::message::is_video;
use crate::video::is_key_frame;
use crate::{Decoder, Image, ImageError, ImageMessage, Payload, TrackError, is_image};

/// Pixels of the longer side, at the most; larger images are averaged down.
const LONGEST_SIDE: usize = 640;
/// A JPEG or PNG of so many bytes is taken as it is, where its sides are no longer.
const SMALL: usize = 64 << 10;
/// Topics of images that are looked at, in the order in which their first image is in the log.
const MOST_TOPICS: usize = 4;
/// Bytes of a video that wait for a frame that is wanted.
const MOST_WAITING: usize = 64 << 20;

/// A time of which images are wanted, by their stamps in ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The first stamp.
    pub from: i64,
    /// The last stamp.
    pub to: i64,
    /// Images of each topic at the most, evenly apart.
    pub most: u32,
}

impl Window {
    /// The least time between two images.
    fn step(&self) -> i64 {
        (self.to - self.from).max(0) / i64::from(self.most.max(1)) + 1
    }
}

/// An image of a window.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SmallImage {
    /// The window's place among those given.
    pub window: usize,
    /// Its topic.
    pub topic: String,
    /// Its stamp in ns; where it has none, when it was received.
    pub stamp: i64,
    /// `jpeg` or `png`.
    pub format: &'static str,
    /// The file.
    pub data: Vec<u8>,
}

/// What was found in a log.
#[derive(Clone, Debug, Default)]
pub struct Excerpt {
    /// By window, and in the log's order.
    pub images: Vec<SmallImage>,
    /// What is not shown, in sentences.
    pub notes: Vec<String>,
}

/// Images of the windows: those of `topic` where the log has it, else those of its first four topics of images. Of a window that ends before it
/// begins, or wants none, there are none.
///
/// # Errors
/// The log cannot be read.
pub fn excerpt(log: &Path, topic: Option<&str>, windows: &[Window]) -> Result<Excerpt, TrackError> {
    let mut taking = Taking::new(topic, windows);
    read_raw(log, Limits::default(), &mut |message| {
        taking.take(&message);
        Ok::<_, TrackError>(())
    })?;
    Ok(taking.finish())
}

#[derive(Default)]
struct Topic {
    /// Decoder of a video, whose images build on one another.
    decoder: Decoder,
    /// Messages since its last key frame that nobody wanted.
    waiting: Vec<Vec<u8>>,
    waiting_bytes: usize,
    /// The stamp from which each window wants its next image.
    next: BTreeMap<usize, i64>,
    undecodable: usize,
    why: Option<String>,
}

struct Taking<'a> {
    wanted: Option<&'a str>,
    /// In order of their beginnings, with their places among those given.
    windows: Vec<(usize, Window)>,
    longest: i64,
    topics: BTreeMap<String, Topic>,
    /// Topics beyond the most.
    beyond: Vec<String>,
    images: Vec<SmallImage>,
}

impl<'a> Taking<'a> {
    fn new(wanted: Option<&'a str>, windows: &[Window]) -> Self {
        let windows = windows.iter().copied().enumerate();
        let mut windows: Vec<_> = windows.filter(|(_, window)| window.most > 0).collect();
        windows.sort_by_key(|(_, window)| window.from);
        let longest = windows.iter().map(|(_, window)| window.to - window.from);
        Self {
            wanted,
            longest: longest.max().unwrap_or(0),
            windows,
            topics: BTreeMap::new(),
            beyond: Vec::new(),
            images: Vec::new(),
        }
    }

    fn take(&mut self, message: &RawMessage<'_>) {
        let channel = message.channel;
        if !is_image(&channel.schema) || self.windows.is_empty() {
            return;
        }
        let name = &channel.topic;
        let is_known = self.topics.contains_key(name);
        let is_wanted = self.wanted == Some(name);
        if !is_wanted && self.has_wanted() {
            return;
        }
        if !is_known && !is_wanted && self.topics.len() >= MOST_TOPICS {
            if !self.beyond.contains(name) {
                self.beyond.push(name.clone());
            }
            return;
        }
        let mut topic = self.topics.remove(name).unwrap_or_default();
        if let Err(error) = self.image(&mut topic, channel, message) {
            topic.undecodable += 1;
            topic.why.get_or_insert(error.to_string());
        }
        self.topics.insert(name.clone(), topic);
    }

    fn has_wanted(&self) -> bool {
        self.wanted
            .is_some_and(|wanted| self.topics.contains_key(wanted))
    }

    fn image(
        &mut self,
        topic: &mut Topic,
        channel: &RawChannel,
        message: &RawMessage<'_>,
    ) -> Result<(), ImageError> {
        let image = parsed(channel, message.data)?;
        let stamp = match image.stamp {
            0 => i64::try_from(message.log_time).unwrap_or(i64::MAX),
            stamp => stamp,
        };
        let windows = self.windows_at(topic, stamp);
        if is_video(&channel.schema) {
            if is_key_frame(image.payload.bytes()) {
                topic.forget();
            }
            if windows.is_empty() {
                topic.waiting_bytes += message.data.len();
                topic.waiting.push(message.data.to_vec());
            }
            if !windows.is_empty() || topic.waiting_bytes > MOST_WAITING {
                for earlier in std::mem::take(&mut topic.waiting) {
                    // What builds on one that is damaged says so itself.
                    let image = parsed(channel, &earlier);
                    let _ = image.and_then(|image| topic.decoder.decode(&image).map(drop));
                }
                topic.waiting_bytes = 0;
            }
        }
        if windows.is_empty() {
            return Ok(());
        }
        let (format, data) = small(&image, &mut topic.decoder)?;
        for window in windows {
            self.images.push(SmallImage {
                window,
                topic: channel.topic.clone(),
                stamp,
                format,
                data: data.clone(),
            });
        }
        Ok(())
    }

    /// Windows that want an image of this stamp, which they have then.
    fn windows_at(&self, topic: &mut Topic, stamp: i64) -> Vec<usize> {
        let end = self
            .windows
            .partition_point(|(_, window)| window.from <= stamp);
        let mut windows = Vec::new();
        for (place, window) in self.windows[..end].iter().rev() {
            if window.from < stamp.saturating_sub(self.longest) {
                break;
            }
            let next = topic.next.entry(*place).or_insert(window.from);
            if stamp <= window.to && stamp >= *next {
                *next = stamp.saturating_add(window.step());
                windows.push(*place);
            }
        }
        windows
    }

    fn finish(mut self) -> Excerpt {
        // The rig's own topic alone, where the log has it.
        if let Some(wanted) = self.wanted
            && self.has_wanted()
        {
            self.images.retain(|image| image.topic == wanted);
            self.topics.retain(|name, _| name == wanted);
            self.beyond.clear();
        }
        let undecodable = self.topics.iter().filter_map(|(name, topic)| {
            let why = topic.why.as_ref()?;
            let count = topic.undecodable;
            Some(format!("{count} images of {name} are not shown: {why}"))
        });
        let mut notes: Vec<String> = undecodable.collect();
        if !self.beyond.is_empty() {
            let names = self.beyond.join(", ");
            notes.push(format!(
                "images of {names} are not shown: no more than {MOST_TOPICS} topics are"
            ));
        }
        self.images.sort_by_key(|image| image.window);
        Excerpt {
            images: self.images,
            notes,
        }
    }
}

fn parsed<'a>(channel: &RawChannel, data: &'a [u8]) -> Result<ImageMessage<'a>, ImageError> {
    ImageMessage::parse(&channel.schema, &channel.encoding, data)
}

impl Topic {
    /// What waited is no part of what follows a key frame.
    fn forget(&mut self) {
        self.waiting.clear();
        self.waiting_bytes = 0;
    }
}

/// A file of an image that is no larger than it needs to be to be looked at.
fn small(
    image: &ImageMessage<'_>,
    decoder: &mut Decoder,
) -> Result<(&'static str, Vec<u8>), ImageError> {
    let decoded = decoder.decode(image)?;
    let averaged = decoded.averaged(LONGEST_SIDE);
    if let Payload::Compressed(data) = image.payload
        && data.len() <= SMALL
        && averaged.width == decoded.width
    {
        if data.starts_with(&[0xff, 0xd8]) {
            return Ok(("jpeg", data.to_vec()));
        }
        if data.starts_with(b"\x89PNG") {
            return Ok(("png", data.to_vec()));
        }
    }
    let jpeg = jpeg_of(&averaged);
    let jpeg = jpeg.ok_or(ImageError::Message("it is too large for JPEG"))?;
    Ok(("jpeg", jpeg))
}

/// How many pixels of an image of this width and height are one pixel of its small image, along each side.
pub fn averaged_by([width, height]: [u32; 2]) -> u32 {
    square([width as usize, height as usize], LONGEST_SIDE) as u32
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Image;

    const TOPIC: &str = "/camera/image";

    fn image(width: usize, height: usize) -> Image {
        Image {
            width,
            height,
            rgb: [200, 100, 50].repeat(width * height),
            grey: false,
        }
    }

    /// A log with a JPEG every 10 ms for a second, from 5 s on.
    fn log(folder: &Path, image: &Image) -> std::path::PathBuf {
        let path = folder.join("log.mcap");
        let mut writer = logs::write::CopyWriter::create(&path).expect("a file");
        let jpeg = jpeg_of(image).expect("a JPEG");
        for frame in 0..100 {
            let stamp = 5_000_000_000 + 10_000_000 * frame;
            let topic = if frame % 2 == 0 { TOPIC } else { "/other" };
            writer.jpeg(topic, stamp, stamp, &jpeg).expect("written");
        }
        writer.finish().expect("a log");
        path
    }

    fn window(from: i64, to: i64, most: u32) -> Window {
        let ms = 1_000_000;
        Window {
            from: from * ms,
            to: to * ms,
            most,
        }
    }

    #[test]
    fn each_window_has_its_images_evenly_apart_and_no_more_than_it_wants() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = log(folder.path(), &image(40, 30));
        let windows = [
            window(5_100, 5_900, 8),
            window(5_200, 5_300, 100),
            window(5_200, 5_900, 0),
            window(7_000, 8_000, 9),
        ];
        let found = excerpt(&path, Some(TOPIC), &windows).expect("images");
        let stamps = |window: usize| -> Vec<i64> {
            let images = found.images.iter();
            let images = images.filter(|image| image.window == window);
            images.map(|image| image.stamp / 1_000_000).collect()
        };
        assert_eq!(stamps(0), [5_100, 5_220, 5_340, 5_460, 5_580, 5_700, 5_820]);
        assert_eq!(stamps(1), [5_200, 5_220, 5_240, 5_260, 5_280, 5_300]);
        assert!(stamps(2).is_empty() && stamps(3).is_empty());
        assert!(found.images.iter().all(|image| image.topic == TOPIC));
        assert!(found.notes.is_empty(), "{:?}", found.notes);

        // Where the rig names no topic, or another, all are shown.
        let found = excerpt(&path, Some("/none"), &windows[1..2]).expect("images");
        let other = found.images.iter().filter(|image| image.topic == "/other");
        assert_eq!((found.images.len(), other.count()), (11, 5));
    }

    #[test]
    fn a_large_image_is_averaged_down_and_a_small_file_stays_as_it_is() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut noisy = image(1500, 900);
        let mut state = 1_u32;
        for byte in &mut noisy.rgb {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *byte = (state >> 24) as u8;
        }
        let path = log(folder.path(), &noisy);
        let found = excerpt(&path, None, &[window(5_000, 5_009, 1)]).expect("images");
        let mut decoder = Decoder::default();
        let data = &found.images[0].data;
        let decoded = decoder.decode(&ImageMessage {
            stamp: 0,
            payload: Payload::Compressed(data),
        });
        let decoded = decoded.expect("an image");
        assert_eq!((decoded.width, decoded.height), (500, 300));
        let mean = decoded.rgb.iter().map(|byte| f64::from(*byte)).sum::<f64>();
        let mean = mean / decoded.rgb.len() as f64;
        assert!((mean - 127.5).abs() < 2.0, "{mean}");

        let small = image(40, 30);
        let path = log(folder.path(), &small);
        let found = excerpt(&path, None, &[window(5_000, 5_009, 1)]).expect("images");
        assert_eq!(found.images[0].data, jpeg_of(&small).expect("a JPEG"));
    }
}
