//! The lens of a camera as a log states it (ROS's `CameraInfo`, Foxglove's `CameraCalibration`), and which one holds for a topic's images.
//!
//! Sources: `sensor_msgs/msg/CameraInfo.msg`, `foxglove/CameraCalibration.proto`.

use std::path::Path;

use logs::read::{RawMessage, read_raw};
use logs::{Limits, LogError};
use values::Rig;

use crate::wire::{Value, Wire, each_field};
use crate::{ImageError, Lens, TrackError};

/// A lens and the size of the images that it holds for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CameraInfo {
    pub(crate) lens: Lens,
    /// Width and height in px.
    pub(crate) size: [usize; 2],
    /// For rectified images, the matrix `[fx, fy, cx, cy]` that held before rectification.
    before: Option<[f64; 4]>,
}

impl CameraInfo {
    /// What a log says of the camera of an image topic, if it says anything: the first message of the topic beside it
    /// (`/camera/camera_info` for `/camera/image_raw/compressed`), or of the only such topic.
    pub(crate) fn of_log(log: &Path, images: &str) -> Result<Option<Self>, TrackError> {
        let mut others: Vec<(String, Result<Self, String>)> = Vec::new();
        let read = read_raw(log, Limits::default(), &mut |message: RawMessage<'_>| {
            let topic = &message.channel.topic;
            if !is_info(&message.channel.schema) || others.iter().any(|(known, _)| known == topic) {
                return Ok(());
            }
            let parsed = parse(&message, is_rectified(images));
            if is_beside(topic, images) {
                return Err(Stop::Found(Box::new((topic.clone(), parsed))));
            }
            others.push((topic.clone(), parsed));
            Ok(())
        });
        let (topic, info) = match read {
            Err(Stop::Found(found)) => *found,
            Err(Stop::Log(error)) => return Err(error.into()),
            Ok(_) if others.len() == 1 => others.remove(0),
            Ok(_) => return Ok(None),
        };
        let log = log.display().to_string();
        match info {
            Ok(info) => Ok(Some(info)),
            Err(why) => Err(TrackError::CameraInfo { log, topic, why }),
        }
    }
}

impl CameraInfo {
    /// Whether a lens is that of the images before they were rectified.
    pub(crate) fn is_before(&self, lens: &Lens) -> bool {
        let is_like = |matrix: &[f64; 4]| is_alike(matrix, &lens.matrix, self.size[0]);
        let is_after = is_like(&self.lens.matrix) && lens.bend() < MOST_BEND;
        self.before.as_ref().is_some_and(is_like) && !is_after
    }
}

/// A lens that bends the image's corners by more than this, of their distance from its middle, is none of rectified images.
pub(crate) const MOST_BEND: f64 = 0.02;

/// Whether two matrices (`[fx, fy, cx, cy]`) of images of this width (px) differ by no more than calibrations of one camera do.
fn is_alike(a: &[f64; 4], b: &[f64; 4], width: usize) -> bool {
    /// Greatest difference, as a share of a focal length, and of the image's width for the principal point.
    const MOST: f64 = 0.01;
    let width = width.max(1) as f64;
    let scales = [b[0], b[1], width, width];
    (0..4).all(|i| (a[i] - b[i]).abs() <= MOST * scales[i])
}

/// How the search in a log ends.
enum Stop {
    Found(Box<(String, Result<CameraInfo, String>)>),
    Log(LogError),
}

impl From<LogError> for Stop {
    fn from(error: LogError) -> Self {
        Self::Log(error)
    }
}

fn is_info(schema: &str) -> bool {
    matches!(
        schema,
        "sensor_msgs/msg/CameraInfo" | "sensor_msgs/CameraInfo" | "foxglove.CameraCalibration"
    )
}

/// Whether a topic lies in the namespace that an image topic lies in or below.
fn is_beside(topic: &str, images: &str) -> bool {
    topic
        .rsplit_once('/')
        .is_some_and(|(space, _)| !space.is_empty() && images.starts_with(&format!("{space}/")))
}

/// A camera message as it was decoded, before it is checked.
#[derive(Debug, Default)]
pub(crate) struct CameraMessage {
    size: [u32; 2],
    model: String,
    distortion: Vec<f64>,
    matrix: Vec<f64>,
    /// The projection of rectified images, row by row; nothing where the message ends before.
    projection: Vec<f64>,
}

fn parse(message: &RawMessage<'_>, is_rectified: bool) -> Result<CameraInfo, String> {
    let message = CameraMessage::of(message)?;
    if !is_rectified {
        return message.checked();
    }
    let before = match message.matrix[..] {
        [fx, _, cx, _, fy, cy, ..] => Some([fx, fy, cx, cy]),
        _ => None,
    };
    let info = message.rectified()?.checked()?;
    Ok(CameraInfo { before, ..info })
}

/// Whether the images of a topic are rectified, as drivers name it: `image_rect`, `image_rect_color`, `image_rect_raw`, `rect/image`. They
/// have no lens left.
pub(crate) fn is_rectified(images: &str) -> bool {
    let is_name = |part: &str| part.starts_with("image_rect") || part.starts_with("rect");
    images.split('/').any(is_name)
}

/// Coefficients of a distortion at the most: what no model exceeds.
const MOST_COEFFICIENTS: u32 = 14;

fn ros(mut wire: Wire<'_>) -> Result<CameraMessage, ImageError> {
    wire.u32()?;
    wire.u32()?;
    wire.text()?; // frame_id
    let (height, width) = (wire.u32()?, wire.u32()?);
    let model = wire.text()?.to_owned();
    let count = wire.u32()?;
    if count > MOST_COEFFICIENTS {
        return Err(ImageError::Message("it has too many coefficients"));
    }
    let mut numbers = |count: u32| {
        (0..count)
            .map(|_| wire.f64())
            .collect::<Result<Vec<_>, _>>()
    };
    let (distortion, matrix) = (numbers(count)?, numbers(9)?);
    let projection = numbers(9).and_then(|_rotation| numbers(12));
    Ok(CameraMessage {
        size: [width, height],
        model,
        distortion,
        matrix,
        projection: projection.unwrap_or_default(),
    })
}

fn foxglove(data: &[u8]) -> Result<CameraMessage, ImageError> {
    /// Field numbers of `CameraCalibration`.
    const WIDTH: u64 = 2;
    const HEIGHT: u64 = 3;
    const MODEL: u64 = 4;
    const DISTORTION: u64 = 5;
    const MATRIX: u64 = 6;
    const PROJECTION: u64 = 8;
    let mut camera = CameraMessage::default();
    let doubles = |bytes: &[u8], to: &mut Vec<f64>| {
        // Packed or one by one.
        let (eights, _) = bytes.as_chunks::<8>();
        to.extend(eights.iter().map(|eight| f64::from_le_bytes(*eight)));
    };
    each_field(data, &mut |number, value| {
        match (number, value) {
            (WIDTH, Value::Number(number)) => camera.size[0] = number as u32,
            (HEIGHT, Value::Number(number)) => camera.size[1] = number as u32,
            (MODEL, Value::Bytes(bytes)) => {
                camera.model = String::from_utf8_lossy(bytes).into_owned()
            }
            (DISTORTION, Value::Bytes(bytes)) => doubles(bytes, &mut camera.distortion),
            (MATRIX, Value::Bytes(bytes)) => doubles(bytes, &mut camera.matrix),
            (PROJECTION, Value::Bytes(bytes)) => doubles(bytes, &mut camera.projection),
            _ => {}
        }
        Ok(())
    })?;
    Ok(camera)
}

impl CameraMessage {
    fn of(message: &RawMessage<'_>) -> Result<Self, String> {
        let wire = match message.channel.encoding.as_str() {
            "cdr" => Wire::cdr(message.data).and_then(ros),
            "ros1" => Wire::ros1(message.data).and_then(ros),
            "protobuf" => foxglove(message.data),
            other => {
                return Err(format!(
                    "its encoding is `{other}`; cdr, ros1 and protobuf are read"
                ));
            }
        };
        wire.map_err(|error| error.to_string())
    }

    /// A message of a topic beside an image topic, where it is one of a camera that was calibrated.
    pub(crate) fn beside(message: &RawMessage<'_>, images: &str) -> Option<Self> {
        let channel = message.channel;
        let is_its = is_info(&channel.schema) && is_beside(&channel.topic, images);
        if !is_its {
            return None;
        }
        let found = Self::of(message).ok()?;
        let found = if is_rectified(images) {
            found.rectified().ok()?
        } else {
            found
        };
        let is_calibrated = found.matrix.first().is_some_and(|focal| *focal > 0.0);
        is_calibrated.then_some(found)
    }

    /// Where it contradicts the lens in use and the size of the images.
    pub(crate) fn contradictions(&self, lens: &Lens, size: Option<[usize; 2]>) -> Vec<String> {
        let mut found = Vec::new();
        let mut add = |what: String| {
            found.push(format!(
                "the log's CameraInfo contradicts the rig file: {what}; the rig file's lens is used, check [camera]"
            ));
        };
        if !self.is_plumb_bob() {
            let count = self.distortion.len();
            add(format!(
                "its distortion model is `{}` with {count} coefficients",
                self.model
            ));
        }
        if let [fx, _, cx, _, fy, cy, ..] = self.matrix[..]
            && !is_alike(&[fx, fy, cx, cy], &lens.matrix, self.size[0] as usize)
        {
            let [a, b, c, d] = lens.matrix;
            add(format!(
                "its matrix is {fx:.1}, {fy:.1}, {cx:.1}, {cy:.1} (fx, fy, cx, cy in px), the rig file's {a:.1}, {b:.1}, {c:.1}, {d:.1}"
            ));
        }
        let theirs = self.size.map(|pixels| pixels as usize);
        if let Some(size) = size.filter(|size| *size != theirs) {
            add(format!(
                "it holds for {} × {} pixels, the images have {} × {}",
                theirs[0], theirs[1], size[0], size[1]
            ));
        }
        found
    }

    /// What holds for rectified images: the projection's matrix, and no distortion.
    fn rectified(self) -> Result<Self, String> {
        let [fx, skew, cx, _, _, fy, cy, ..] = self.projection[..] else {
            return Err("the images are rectified, and it has no projection matrix (P)".into());
        };
        if fx <= 0.0 || fy <= 0.0 {
            return Err("the images are rectified, and its projection matrix (P) is zero".into());
        }
        Ok(Self {
            model: "plumb_bob".into(),
            distortion: Vec::new(),
            matrix: vec![fx, skew, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
            ..self
        })
    }

    /// Whether its model is plumb_bob, or another whose further coefficients are zero.
    fn is_plumb_bob(&self) -> bool {
        let is_zero = |number: &f64| *number == 0.0;
        match self.model.as_str() {
            "plumb_bob" => self.distortion.len() <= 5,
            "" => self.distortion.iter().all(is_zero),
            "rational_polynomial" => self.distortion.iter().skip(5).all(is_zero),
            _ => false,
        }
    }

    /// The lens, where its model is read.
    fn checked(self) -> Result<CameraInfo, String> {
        if !self.is_plumb_bob() {
            return Err(format!(
                "its distortion model is `{}` with {} coefficients; plumb_bob is read: log rectified images, or write the lens into \
                 the rig file under [camera]",
                self.model,
                self.distortion.len()
            ));
        }
        let [fx, _, cx, _, fy, cy, ..] = self.matrix[..] else {
            return Err("it has no camera matrix".into());
        };
        let numbers = self.distortion.iter().chain(&self.matrix);
        if !numbers.clone().all(|number| number.is_finite()) {
            return Err("a number in it is not finite".into());
        }
        if fx <= 0.0 || fy <= 0.0 {
            return Err(
                "its camera matrix is zero, for the camera was not calibrated: `carom camera calibrate` does it"
                    .into(),
            );
        }
        let coefficient = |i: usize| self.distortion.get(i).copied().unwrap_or(0.0);
        Ok(CameraInfo {
            lens: Lens {
                matrix: [fx, fy, cx, cy],
                distortion: [0, 1, 2, 3, 4].map(coefficient),
            },
            size: self.size.map(|pixels| pixels as usize),
            before: None,
        })
    }
}

/// A rig with the lens that holds for a topic's images.
pub(crate) struct LogLens {
    pub(crate) rig: Rig,
    /// Width and height of the images that it holds for, in px, where that is stated.
    pub(crate) size: Option<[usize; 2]>,
    /// What a person should know of it.
    pub(crate) note: Option<String>,
}

impl LogLens {
    /// The rig file's lens; where it has none, or the images were rectified and its lens is that of the images before, the log's.
    ///
    /// # Errors
    /// The log cannot be read, or what it says of the lens is of no use; the images were rectified, and nothing says to what lens.
    pub(crate) fn of(log: &Path, rig: &Rig, topic: &str) -> Result<Self, TrackError> {
        let size = rig.camera.size;
        let mut found = Self {
            rig: rig.clone(),
            size: size.map(|size| size.map(|pixels| pixels as usize)),
            note: None,
        };
        let Some(matrix) = rig.camera.matrix else {
            if let Some(info) = CameraInfo::of_log(log, topic)? {
                found.take(&info);
            }
            return Ok(found);
        };
        if !is_rectified(topic) {
            return Ok(found);
        }
        let own = Lens {
            matrix,
            distortion: rig.camera.distortion.unwrap_or_default(),
        };
        let info = match CameraInfo::of_log(log, topic) {
            Err(TrackError::CameraInfo { .. }) => None,
            other => other?,
        };
        match info.filter(|info| info.is_before(&own)) {
            Some(info) => {
                found.take(&info);
                let [fx, fy, cx, cy] = info.lens.matrix;
                found.note = Some(format!(
                    "the images of topic {topic} are rectified, and the rig file's lens is that of the images before: the projection of the log's \
                     CameraInfo is used; write matrix = [{fx:.2}, {fy:.2}, {cx:.2}, {cy:.2}] under [camera], without distortion"
                ));
            }
            None if own.bend() > MOST_BEND => {
                return Err(TrackError::Rectified {
                    log: log.display().to_string(),
                    topic: topic.to_owned(),
                    percent: 100.0 * own.bend(),
                });
            }
            None => {}
        }
        Ok(found)
    }

    fn take(&mut self, info: &CameraInfo) {
        self.rig.camera.matrix = Some(info.lens.matrix);
        self.rig.camera.distortion = Some(info.lens.distortion);
        self.size = Some(info.size);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(model: &str, distortion: &[f64]) -> CameraMessage {
        CameraMessage {
            size: [640, 480],
            model: model.into(),
            distortion: distortion.to_vec(),
            matrix: vec![600.0, 0.0, 320.0, 0.0, 610.0, 240.0, 0.0, 0.0, 1.0],
            projection: vec![
                580.0, 0.0, 310.0, 0.0, 0.0, 590.0, 230.0, 0.0, 0.0, 0.0, 1.0, 0.0,
            ],
        }
    }

    #[test]
    fn plumb_bob_is_read_and_what_bends_otherwise_is_refused() {
        let info = message("plumb_bob", &[-0.1, 0.02, 0.001])
            .checked()
            .expect("read");
        assert_eq!(info.lens.matrix, [600.0, 610.0, 320.0, 240.0]);
        assert_eq!(info.lens.distortion, [-0.1, 0.02, 0.001, 0.0, 0.0]);
        let more = [0.1, 0.2, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0];
        assert!(message("rational_polynomial", &more).checked().is_ok());
        let fish = message("equidistant", &[0.1; 4])
            .checked()
            .expect_err("fish-eye");
        assert!(
            fish.contains("equidistant") && fish.contains("plumb_bob"),
            "{fish}"
        );
        let mut zero = message("", &[]);
        zero.matrix[0] = 0.0;
        assert!(zero.checked().expect_err("zero").contains("calibrate"));
    }

    #[test]
    fn rectified_images_have_the_projection_and_no_lens() {
        assert!(is_rectified("/left/image_rect_color/compressed"));
        assert!(is_rectified("/zed/rgb/color/rect/image"));
        assert!(!is_rectified("/left/image_raw/compressed"));
        let info = message("rational_polynomial", &[0.1; 8]).rectified();
        let info = info
            .and_then(CameraMessage::checked)
            .expect("has a projection");
        assert_eq!(info.lens.matrix, [580.0, 590.0, 310.0, 230.0]);
        assert_eq!(info.lens.distortion, [0.0; 5]);
    }

    #[test]
    fn the_topic_beside_the_images_is_theirs() {
        let images = "/left/image_raw/compressed";
        assert!(is_beside("/left/camera_info", images));
        assert!(is_beside("/left/image_raw/camera_info", images));
        assert!(!is_beside("/right/camera_info", images));
        assert!(!is_beside("/camera_info", images));
    }
}
