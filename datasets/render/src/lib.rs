//! What a camera over the table sees: pictures of a known object at a known place, for demos and for tests of `track`.
//!
//! It shares no code with `track`, and works the other way round: rays go from every part of a pixel, at every part of the
//! exposure, through the lens to the object or the table, and the light that comes back is added up. So perspective, lens,
//! the sides of a tall object, soft shadows, motion blur and a rolling shutter are all what they are, to the number of rays.
//!
//! - [`Scene`] is what is there; [`Renderer`] is a camera that looks at it; [`Picture`] is what it gives, also of a flat print.
//! - [`case`] holds the cases that trackers are measured on, [`hostile`] scenes that they should not trust.

pub mod case;
mod encode;
pub mod hostile;
mod light;
mod noise;
mod optics;
mod print;
mod renderer;
mod scene;
mod solid;

pub use encode::{EncodeError, Picture};
pub use optics::Optics;
pub use renderer::{Renderer, Rendering};
pub use scene::{Cover, Glare, Scene, Shade};
pub use solid::{Form, Moment};
