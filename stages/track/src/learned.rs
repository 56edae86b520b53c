//! What is known of a log's images before each is looked at.

use crate::Image;
use crate::aligned::Aligned;
use crate::background::Background;
use crate::edges::Side;
use crate::height::HeightOff;

/// What is known before an image is looked at.
#[derive(Clone, Debug)]
pub(crate) struct Learned {
    pub(crate) background: Option<Background>,
    /// The brightness of the object's sides, where images tell it.
    pub(crate) side: Option<Side>,
    /// How much larger the object is seen (px), and how well that is known (standard deviation, px).
    pub(crate) larger: [f64; 2],
    /// Mean square of the deviations (m) that the log's images show, where they show any.
    pub(crate) variance: Option<f64>,
    /// How much taller than stated the object is seen to be, where that is sure.
    pub(crate) height: Option<HeightOff>,
}

impl Default for Learned {
    fn default() -> Self {
        Self {
            background: None,
            side: None,
            larger: [0.0, LARGER],
            variance: None,
            height: None,
        }
    }
}

/// Blur and sharpening make an object so much larger or smaller (standard deviation, px).
const LARGER: f64 = 0.4;

/// What one image's own edges count where the log's other images say as well how well a centre is known: the edges of one are few, and those
/// that happen to agree know it no better.
const OWN: f64 = 1.0 / 3.0;

impl Learned {
    /// The standard deviation (m) of a centre whose own edges say this one, and what they cannot tell beside that.
    pub(crate) fn deviation(&self, own: f64, beside: f64) -> f64 {
        self.variance.map_or(own, |of_log| {
            (OWN * own * own + (1.0 - OWN) * of_log + beside * beside).sqrt()
        })
    }

    /// How the background lies in an image; as it was where nothing is known of it; none where it is elsewhere.
    pub(crate) fn align(&self, image: &Image) -> Option<Aligned> {
        match &self.background {
            Some(background) => background.align(image),
            None => Some(Aligned::still()),
        }
    }
}
