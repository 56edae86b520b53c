//! What the headers of an H.264 video say of the order of its images.
//!
//! Source: ITU-T H.264, sections 7.3.2.1.1, 7.3.3 and 7.4.3.

/// How a video's reference images are numbered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Numbering {
    /// Bits of an image's number, which begins again at 0.
    bits: u32,
}

/// The beginning of the header of a slice, which is an image or a part of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SliceStart {
    /// Whether it builds on images that are shown after it.
    pub(crate) is_bidirectional: bool,
    /// Its image's number, where the numbering is known.
    pub(crate) number: Option<u32>,
}

impl Numbering {
    /// The numbering by a sequence parameter set; none where numbers may be left out, or where they stand behind scaling lists.
    pub(crate) fn of(parameters: &[u8]) -> Option<Self> {
        /// Profiles whose parameter sets state the chroma format.
        const HIGH: [u32; 13] = [100, 110, 122, 244, 44, 83, 86, 118, 128, 138, 139, 134, 135];
        /// Chroma at the full resolution.
        const FULL: u32 = 3;
        let mut bits = Bits::new(parameters);
        let profile = bits.read(8)?;
        bits.read(16)?;
        bits.number()?;
        if HIGH.contains(&profile) {
            if bits.number()? == FULL {
                bits.read(1)?;
            }
            bits.number()?;
            bits.number()?;
            bits.read(1)?;
            if bits.read(1)? == 1 {
                return None;
            }
        }
        let length = bits.number()?.checked_add(4)?;
        match bits.number()? {
            0 => {
                bits.number()?;
            }
            1 => {
                bits.read(1)?;
                bits.number()?;
                bits.number()?;
                for _ in 0..bits.number()?.min(u8::MAX.into()) {
                    bits.number()?;
                }
            }
            _ => {}
        }
        bits.number()?;
        let may_leave_out = bits.read(1)? == 1;
        (!may_leave_out && length <= 16).then_some(Self { bits: length })
    }

    /// The number of an image behind a reference image of this number.
    pub(crate) fn after(self, number: u32) -> u32 {
        (number + 1) % (1 << self.bits)
    }
}

impl SliceStart {
    /// Reads the beginning of a slice's bytes; none where they end within it.
    pub(crate) fn of(slice: &[u8], numbering: Option<Numbering>) -> Option<Self> {
        /// Types of slices whose blocks may be predicted from two images; the second where all slices of the image do.
        const BIDIRECTIONAL: [u32; 2] = [1, 6];
        let mut bits = Bits::new(slice);
        bits.number()?; // first_mb_in_slice
        let kind = bits.number()?;
        bits.number()?; // pic_parameter_set_id
        let number = match numbering {
            Some(numbering) => Some(bits.read(numbering.bits)?),
            None => None,
        };
        let is_bidirectional = BIDIRECTIONAL.contains(&kind);
        Some(Self {
            is_bidirectional,
            number,
        })
    }
}

/// Bits of a header from its first byte on.
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Bits<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Reads `count` bits as a number, 31 at the most.
    fn read(&mut self, count: u32) -> Option<u32> {
        let mut number = 0;
        for _ in 0..count {
            let byte = self.bytes.get(self.at / 8)?;
            number = number << 1 | u32::from(byte >> (7 - self.at % 8) & 1);
            self.at += 1;
        }
        Some(number)
    }

    /// An Exp-Golomb number; the same bits hold a signed one.
    fn number(&mut self) -> Option<u32> {
        const MOST_ZEROS: u32 = 30;
        let mut zeros = 0;
        while self.read(1)? == 0 {
            zeros += 1;
            if zeros > MOST_ZEROS {
                return None;
            }
        }
        Some((1 << zeros) - 1 + self.read(zeros)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes of bits written as 0 and 1.
    fn bytes(bits: &str) -> Vec<u8> {
        let bits: Vec<u8> = bits.bytes().filter(|bit| *bit != b' ').collect();
        let byte = |bits: &[u8]| {
            (0..8).fold(0, |sum, at| {
                2 * sum + bits.get(at).map_or(0, |bit| bit - b'0')
            })
        };
        bits.chunks(8).map(byte).collect()
    }

    #[test]
    fn a_slice_tells_its_kind_and_its_images_number() {
        // Profile, flags, level | set 0 | numbers of 5 bits | order of kind 2 | 1 reference | none left out.
        let head = "01000010 11000000 00011110";
        let numbering =
            Numbering::of(&bytes(&format!("{head} 1 010 011 010 0 1"))).expect("numbers");
        assert_eq!(numbering, Numbering { bits: 5 });
        assert_eq!((numbering.after(30), numbering.after(31)), (31, 0));
        assert_eq!(
            Numbering::of(&bytes(&format!("{head} 1 010 011 010 1 1"))),
            None
        );
        // First block 0, the kind, parameter set 0, the number.
        for (kind, is_bidirectional) in [
            ("1", false),
            ("010", true),
            ("00111", true),
            ("011", false),
            ("00110", false),
        ] {
            let slice = bytes(&format!("1 {kind} 1 01101"));
            let start = SliceStart::of(&slice, Some(numbering)).expect("a header");
            assert_eq!(start.is_bidirectional, is_bidirectional, "{kind}");
            assert_eq!(start.number, Some(13), "{kind}");
        }
        assert_eq!(SliceStart::of(&[0, 0, 0, 0, 0], None), None);
        assert_eq!(SliceStart::of(&[], None), None);
    }
}
