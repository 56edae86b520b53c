//! Which strikes fit and choose.

use values::{Split, Strike};

use crate::{Diagnose, DiagnoseError, Input};

/// Least number of strikes: with fewer, friction, launch and their scatter leave nothing to distinguish effects by.
pub(crate) const FEWEST: usize = 8;
/// Frames that a track must have.
const FRAMES: usize = 6;

/// The strikes that fit and choose.
pub(crate) struct Usable {
    pub(crate) strikes: Vec<Strike>,
    /// Strikes whose object is pushed a second time.
    pub(crate) pushed_again: usize,
    /// Whether strikes whose object is pushed a second time are kept, because they are most, or too few others are there: no candidate makes an
    /// object speed up again.
    pub(crate) are_pushed_again: bool,
}

impl Diagnose {
    /// The strikes that fit and choose, from where their impact is over, without those whose object is pushed a second time.
    pub(crate) fn usable(&self, input: &Input) -> Result<Usable, DiagnoseError> {
        let frame = 1.0 / input.rig.camera.rate;
        let tracks: Vec<Strike> = self
            .sample(&input.strikes)
            .iter()
            .filter(|strike| strike.split != Split::Test)
            .map(|strike| strike.after_impact(frame))
            .filter(|strike| strike.track.len() >= FRAMES)
            .collect();
        let (strikes, needed) = (tracks.len(), FEWEST);
        if strikes < needed {
            return Err(DiagnoseError::TooFewStrikes { strikes, needed });
        }
        let is_free = values::free_slides(&tracks.iter().collect::<Vec<_>>());
        let pushed_again = is_free.iter().filter(|is_free| !**is_free).count();
        let are_pushed_again = strikes - pushed_again < needed || 2 * pushed_again > strikes;
        let each = tracks.into_iter().zip(is_free);
        Ok(Usable {
            strikes: each
                .filter(|(_, is_free)| *is_free || are_pushed_again)
                .map(|(strike, _)| strike)
                .collect(),
            pushed_again,
            are_pushed_again,
        })
    }
}
