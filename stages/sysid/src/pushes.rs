//! Which slides that no strike began may teach: those that the table brakes as it brakes what was struck.
//!
//! A hand's carry may look like a slide for a moment. It slows down as the hand likes, and a table does not.

use values::{Strike, free_slides, median};

use crate::notes::Note;

/// Least number of strikes that tell how the table brakes.
const FEWEST: usize = 8;
/// A slide agrees within so many standard deviations of the strikes' decelerations, or within this part of their median and this much (m/s²);
/// but never beyond the last part, where anything brakes at all.
const DEVIATIONS: f64 = 3.0;
const NEAR: f64 = 0.1;
const LEAST: f64 = 0.25;
const FARTHEST: f64 = 0.5;
/// Standard deviation of a normal distribution by its median absolute deviation.
const MAD_TO_SD: f64 = 1.4826;

/// The slides that identification may use, and what is told of the others.
pub(crate) struct Teaching {
    pub(crate) slides: Vec<Strike>,
    pub(crate) warning: Option<Note>,
}

/// Chooses the slides that agree with the strikes. Without strikes, all are kept, and that is said; with too few strikes, or where fewer than half of
/// the slides agree, which they may by chance, none is.
pub(crate) fn teaching(struck: &[&Strike], slides: Vec<Strike>) -> Teaching {
    let count = slides.len();
    let without = |warning| Teaching {
        slides: Vec::new(),
        warning: Some(warning),
    };
    if count == 0 {
        return Teaching {
            slides,
            warning: None,
        };
    }
    if struck.is_empty() {
        let are_free = free_slides(&slides.iter().collect::<Vec<_>>());
        let slides = slides.into_iter().zip(are_free);
        return Teaching {
            slides: slides
                .filter_map(|(slide, is_free)| is_free.then_some(slide))
                .collect(),
            warning: Some(Note::SlidesAlone { slides: count }),
        };
    }
    let braked: Vec<f64> = struck.iter().filter_map(|s| s.deceleration()).collect();
    let usual = median(braked.clone()).filter(|_| braked.len() >= FEWEST);
    let Some(usual) = usual else {
        return without(Note::TooFewToJudgeSlides {
            slides: count,
            strikes: braked.len(),
        });
    };
    let off = braked.iter().map(|braked| (braked - usual).abs()).collect();
    let deviation = MAD_TO_SD * median(off).unwrap_or(0.0);
    let most = (DEVIATIONS * deviation).max(NEAR * usual);
    let most = most.min(FARTHEST * usual).max(LEAST);
    let agrees = |slide: &Strike| {
        let braked = slide.deceleration();
        braked.is_some_and(|braked| (braked - usual).abs() <= most)
    };
    let (alike, others): (Vec<Strike>, Vec<Strike>) = slides.into_iter().partition(agrees);
    let agree = alike.len();
    let carried = Note::CarriedByHand {
        agree,
        of: count,
        are_all: 2 * agree < count,
        usual,
        agreeing: [usual - most, usual + most].map(|end| end.max(0.0)),
    };
    if 2 * agree < count {
        return without(carried);
    }
    Teaching {
        slides: alike,
        warning: (!others.is_empty()).then_some(carried),
    }
}

#[cfg(test)]
mod tests {
    use values::{Command, Point, Track};

    use super::*;

    /// A slide along x from 0.8 m/s under this braking, in m/s².
    fn slide(braking: f64) -> Strike {
        let (speed, mut track) = (0.8_f64, Track::default());
        for i in 0..90 {
            let t = f64::from(i) / 60.0;
            let moving = t.min(speed / braking);
            track.t.push(t);
            track.x.push((speed - 0.5 * braking * moving) * moving);
            track.y.push(0.0);
        }
        Strike {
            track,
            ..Strike::bare(
                Command::new(0.6, 0.0),
                Point::default(),
                Point::new(0.5 * speed * speed / braking, 0.0),
            )
        }
    }

    fn slides(braking: impl IntoIterator<Item = f64>) -> Vec<Strike> {
        braking.into_iter().map(slide).collect()
    }

    /// Number of slides that are kept beside these strikes, and what is said of the others.
    fn taught(struck: &[Strike], pushes: Vec<Strike>) -> (usize, String) {
        let found = teaching(&struck.iter().collect::<Vec<_>>(), pushes);
        let said = found
            .warning
            .map_or(String::new(), |warning| warning.to_string());
        (found.slides.len(), said)
    }

    #[test]
    fn slides_teach_that_are_braked_as_those_of_strikes() {
        let struck = slides((0..21).map(|i| 2.9 + 0.01 * f64::from(i)));
        let alike = slides([2.8, 2.9, 3.1, 3.2]);
        assert_eq!(taught(&struck, alike.clone()), (4, String::new()));
        let (count, said) = taught(&struck, [alike.clone(), slides([1.0, 4.5])].concat());
        assert!(count == 4 && said.starts_with("2 of 6 slides"), "{said}");
        assert!(
            said.contains("3.00 m/s²") && said.contains("a hand carried"),
            "{said}"
        );
        // Decelerations of all sizes agree by chance, where they do.
        let carried = slides((0..20).map(|i| 0.8 + 0.2 * f64::from(i)));
        let (count, said) = taught(&struck, carried);
        assert!(
            count == 0 && said.contains("20 slides") && said.contains("by chance"),
            "{said}"
        );
        // A table that differs from place to place says less of what a slide is, and never all.
        let uneven = slides((0..20).map(|i| 2.0 + 0.1 * f64::from(i)));
        assert_eq!(taught(&uneven, slides([2.2, 3.4])), (2, String::new()));
        assert_eq!(taught(&uneven, slides([2.9, 2.9, 1.0])).0, 2);
    }

    #[test]
    fn few_strikes_tell_nothing_of_slides_and_none_leaves_them_alone() {
        let struck = slides([3.0; 7]);
        let (count, said) = taught(&struck, slides([3.0; 30]));
        assert!(
            count == 0 && said.contains("7 strikes are too few"),
            "{said}"
        );
        let (count, said) = taught(&[], slides([3.0; 30]));
        assert!(count == 30 && said.contains("teach alone"), "{said}");
        assert_eq!(taught(&struck, Vec::new()), (0, String::new()));
    }

    #[test]
    fn where_hardly_anything_brakes_slides_agree_that_are_hardly_braked() {
        let struck = slides((0..20).map(|i| 0.1 + 0.01 * f64::from(i % 5)));
        assert_eq!(taught(&struck, slides([0.06, 0.1, 0.3, 0.9])).0, 3);
    }
}
