//! ArUco's dictionaries and AprilTag's families.

/// The markers of a dictionary.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dictionary {
    /// Cells across a marker, without its black border.
    pub(crate) across: usize,
    /// Bits (white is 1) from the upper left, row by row, the first is the highest.
    codes: Vec<u64>,
}

/// OpenCV's, as `tests/peers/markers.py` writes them.
const CODES: &str = include_str!("dictionaries.txt");

fn codes(heading: &str) -> Option<Vec<u64>> {
    let lines = CODES.lines().skip_while(|line| *line != heading).skip(1);
    // A heading is a single word.
    let lines = lines.take_while(|line| line.contains(' '));
    let codes = lines.flat_map(str::split_whitespace);
    let codes: Option<Vec<u64>> = codes
        .map(|code| u64::from_str_radix(code, 16).ok())
        .collect();
    codes.filter(|codes| !codes.is_empty())
}

/// Bits that a light or a fold may turn: the markers of every dictionary differ by more in most pairs.
const MOST_WRONG: u32 = 1;

impl Dictionary {
    /// The names that are known, as a person reads them.
    pub const NAMES: &str = "DICT_4X4_50 to DICT_7X7_1000 (50, 100, 250 or 1000), DICT_APRILTAG_16h5, _25h9, _36h10 or _36h11";

    /// The dictionary of OpenCV's name, `DICT_4X4_50` to `DICT_7X7_1000` or an AprilTag family as `DICT_APRILTAG_36h11`; none where there is
    /// none.
    pub fn named(name: &str) -> Option<Self> {
        let name = name.strip_prefix("DICT_")?;
        if let Some(family) = name.strip_prefix("APRILTAG_") {
            let (bits, _) = family.split_once('h')?;
            let codes = codes(family)?;
            let across = usize::isqrt(bits.parse().ok()?);
            return Some(Self { across, codes });
        }
        let (size, count) = name.split_once('_')?;
        let (across, high) = size.split_once('X')?;
        let count: usize = count.parse().ok()?;
        if across != high || ![50, 100, 250, 1000].contains(&count) {
            return None;
        }
        let mut codes = codes(across)?;
        codes.truncate(count);
        Some(Self {
            across: across.parse().ok()?,
            codes,
        })
    }

    /// The bits of the marker of this number.
    pub(crate) fn code(&self, id: usize) -> Option<u64> {
        self.codes.get(id).copied()
    }

    /// Markers that it has.
    pub fn len(&self) -> usize {
        self.codes.len()
    }

    /// Whether it has none.
    pub fn is_empty(&self) -> bool {
        self.codes.is_empty()
    }

    /// The marker that is nearest to these bits, and by how many quarters they are to be turned clockwise to be upright.
    pub(crate) fn find(&self, seen: u64) -> Option<(usize, usize)> {
        let mut turned = seen;
        let mut best = (MOST_WRONG + 1, None);
        for quarters in 0..4 {
            for (id, code) in self.codes.iter().enumerate() {
                let wrong = (code ^ turned).count_ones();
                if wrong < best.0 {
                    best = (wrong, Some((id, quarters)));
                }
            }
            turned = self.turned(turned);
        }
        best.1
    }

    /// Bits turned by a quarter clockwise.
    fn turned(&self, bits: u64) -> u64 {
        let n = self.across;
        let bit = |row: usize, column: usize| (bits >> (n * n - 1 - (row * n + column))) & 1;
        let cells = (0..n * n).map(|k| bit(n - 1 - k % n, k / n));
        cells.fold(0, |bits, bit| (bits << 1) | bit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dictionaries_are_known_by_name_and_their_markers_from_every_side() {
        assert_eq!(Dictionary::named("DICT_5X5_42"), None);
        assert_eq!(Dictionary::named("DICT_5X4_50"), None);
        assert_eq!(Dictionary::named("DICT_APRILTAG_36h12"), None);
        for (name, count) in [
            ("DICT_4X4_50", 50),
            ("DICT_5X5_100", 100),
            ("DICT_6X6_250", 250),
            ("DICT_7X7_1000", 1000),
            ("DICT_APRILTAG_16h5", 30),
            ("DICT_APRILTAG_36h11", 587),
        ] {
            let dictionary = Dictionary::named(name).expect("known");
            assert_eq!(dictionary.len(), count);
            let mut bits = dictionary.codes[17];
            for quarters in [0, 3, 2, 1] {
                assert_eq!(dictionary.find(bits), Some((17, quarters)), "{name}");
                assert_eq!(dictionary.find(bits ^ 4), Some((17, quarters)), "{name}");
                bits = dictionary.turned(bits);
            }
        }
    }
}
