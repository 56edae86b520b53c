//! `slides.parquet`: a row for each frame of the slides that no strike began.

use std::path::Path;

use values::Strike;

use crate::TableError;
use crate::layout::{Table, real, text};
use crate::write::{Cell, write};

/// `t_start` is the stamp of a slide's first frame, `t` the time since. `end` is a track's, as in `strikes.parquet`.
pub(crate) const SLIDES: Table<7> = Table {
    name: "slides",
    columns: [
        text("slide_id"),
        text("log"),
        real("t_start", "s"),
        text("end"),
        real("t", "s"),
        real("x", "m"),
        real("y", "m"),
    ],
};

/// Writes the table of these slides, in their order.
pub fn write_slides(dir: &Path, slides: &[Strike]) -> Result<(), TableError> {
    let rows = slides.iter().flat_map(|slide| {
        (0..slide.track.len()).map(|frame| {
            let at = slide.track.point(frame);
            [
                Cell::Text(&slide.id),
                Cell::Text(&slide.log),
                Cell::Real(slide.t_start),
                Cell::Text(slide.track.end.name()),
                Cell::Real(slide.track.t[frame]),
                Cell::Real(at.x),
                Cell::Real(at.y),
            ]
        })
    });
    write(dir, &SLIDES, rows)
}
