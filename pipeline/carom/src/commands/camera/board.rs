//! A ChArUco board: as it is typed, and what its images give.

use std::path::{Path, PathBuf};

use clap::Args;
use track::{Board, Dictionary, FEWEST_CORNERS, LensFit, SeenBoard, SeenPoint};
use values::Rig;

use super::typed::load_image;
use super::typed::{places, size};
use crate::Error;

/// A board, and images of it.
#[derive(Args, Debug)]
pub struct BoardArgs {
    /// Images of the board from ten or more sides, JPEG or PNG: the lens is found from them.
    #[arg(value_name = "IMAGE", requires = "board")]
    pub images: Vec<PathBuf>,
    /// Squares of the ChArUco board; its upper left one is black, as OpenCV 4.6 and later draw it.
    #[arg(long, value_name = "COLUMNSxROWS", value_parser = size, requires_all = ["square", "marker", "dictionary"])]
    pub board: Option<[usize; 2]>,
    /// Side of a square, as measured on the print (m).
    #[arg(long, value_name = "METRES", requires = "board")]
    pub square: Option<f64>,
    /// Side of a marker, its black border included (m).
    #[arg(long, value_name = "METRES", requires = "board")]
    pub marker: Option<f64>,
    /// Dictionary of the markers, by OpenCV's name: DICT_4X4_50 to DICT_7X7_1000, or an AprilTag family as DICT_APRILTAG_36h11.
    #[arg(long, value_name = "NAME", requires = "board")]
    pub dictionary: Option<String>,
    /// An image of the board lying on the table: the pose is found from it, the better from several with the board in other places.
    #[arg(long, value_name = "IMAGE", requires_all = ["board", "corners"])]
    pub table: Vec<PathBuf>,
    /// Where the board's upper left and upper right corner (of the squares, as printed) lie on the table (m), for each --table.
    #[arg(long, value_name = "X,Y,X,Y", value_parser = places, allow_hyphen_values = true, requires = "table")]
    pub corners: Vec<[[f64; 2]; 2]>,
}

impl BoardArgs {
    /// The board, where one was typed.
    pub(super) fn board(&self) -> Result<Option<Board>, Error> {
        let (Some([columns, rows]), Some(square), Some(marker), Some(name)) =
            (self.board, self.square, self.marker, &self.dictionary)
        else {
            return Ok(None);
        };
        let dictionary = Dictionary::named(name).ok_or_else(|| {
            Error::input(format!(
                "find the dictionary `{name}`: {} are known",
                Dictionary::NAMES
            ))
        })?;
        if !(square.is_finite() && 0.0 < marker && marker < square) {
            return Err(Error::input(format!(
                "draw a board with squares of {square} m and markers of {marker} m: a marker is smaller than its square; measure both in m"
            )));
        }
        let corners = columns
            .saturating_sub(1)
            .saturating_mul(rows.saturating_sub(1));
        let markers = columns.saturating_mul(rows) / 2;
        if corners < FEWEST_CORNERS || markers > dictionary.len() {
            return Err(Error::input(format!(
                "draw a board of {columns}x{rows} squares: it has {corners} corners inside, at least {FEWEST_CORNERS} are needed, and {markers} markers, \
                 {name} has {}",
                dictionary.len()
            )));
        }
        Ok(Some(Board {
            columns,
            rows,
            square,
            marker,
            dictionary,
        }))
    }

    /// The lens, from the images; none where no image was named.
    pub(super) fn lens(&self, board: &Board, rig: &Rig) -> Result<Option<LensFit>, Error> {
        let mut views = Vec::with_capacity(self.images.len());
        let mut first: Option<(&Path, [usize; 2])> = None;
        for path in &self.images {
            let image = load_image(path, Some(rig))?;
            let size = [image.width, image.height];
            let (one, expected) = *first.get_or_insert((path, size));
            if size != expected {
                return Err(Error::input(format!(
                    "use {} ({} × {} pixels) beside {} ({} × {}): take all images with the camera as it will be used",
                    path.display(),
                    size[0],
                    size[1],
                    one.display(),
                    expected[0],
                    expected[1]
                )));
            }
            views.push(board.find(&image));
        }
        let Some((_, size)) = first else {
            return Ok(None);
        };
        let fit = LensFit::from_views(&views, size).map_err(Error::input)?;
        Ok(Some(fit))
    }

    /// What of the table is seen in the images of the board that lies on it; none where there is no such image.
    pub(super) fn on_table(&self, board: &Board, rig: &Rig) -> Result<Vec<SeenPoint>, Error> {
        if self.table.len() != self.corners.len() {
            return Err(Error::input(format!(
                "place the board on the table: {} times --table and {} times --corners; each image needs the places of its own",
                self.table.len(),
                self.corners.len()
            )));
        }
        let width = board.square * board.columns as f64;
        let mut all = Vec::new();
        for (path, corners) in self.table.iter().zip(&self.corners) {
            let seen: SeenBoard = board.find(&load_image(path, Some(rig))?);
            let points = seen.on_table(*corners, width).map_err(Error::input)?;
            if points.len() < FEWEST_CORNERS {
                return Err(Error::input(format!(
                    "find the board in {}: {} of its corners are seen, {FEWEST_CORNERS} are needed; it must be in view, sharp and evenly lit, a marker \
                     20 pixels wide or more",
                    path.display(),
                    points.len()
                )));
            }
            all.extend(points);
        }
        Ok(all)
    }
}
