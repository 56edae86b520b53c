//! What is known of a log's images before each is looked at.

use crate::Image;
use crate::aligned::Aligned;
use crate::background::Background;
use crate::edges::Side;

/// What is known before an image is looked at.
#[derive(Clone, Debug)]
pub(crate) struct Learned {
    pub(crate) background: Option<Background>,
    /// The brightness of the object's sides, where images tell it.
    pub(crate) side: Option<Side>,
    /// How much larger the object is seen (px), and how well that is known (standard deviation, px).
    pub(crate) larger: [f64; 2],
}

impl Default for Learned {
    fn default() -> Self {
        Self {
            background: None,
            side: None,
            larger: [0.0, LARGER],
        }
    }
}

/// Blur and sharpening make an object so much larger or smaller (standard deviation, px).
const LARGER: f64 = 0.4;

impl Learned {
    /// How the background lies in an image; as it was where nothing is known of it; none where it is elsewhere.
    pub(crate) fn align(&self, image: &Image) -> Option<Aligned> {
        match &self.background {
            Some(background) => background.align(image),
            None => Some(Aligned::still()),
        }
    }
}
