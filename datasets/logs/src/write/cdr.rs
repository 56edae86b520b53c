//! The little of CDR (OMG's Common Data Representation, version 1, little-endian) that the writer's messages need.

/// Marks plain little-endian CDR; alignment counts from its end.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// Appends primitive values to a buffer, each aligned to its own size.
pub(super) struct Cdr<'a> {
    buffer: &'a mut Vec<u8>,
}

impl<'a> Cdr<'a> {
    /// Starts a message in an empty buffer.
    pub(super) fn new(buffer: &'a mut Vec<u8>) -> Self {
        buffer.extend_from_slice(&ENCAPSULATION);
        Self { buffer }
    }

    fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        while !(self.buffer.len() - ENCAPSULATION.len()).is_multiple_of(N) {
            self.buffer.push(0);
        }
        self.buffer.extend_from_slice(&bytes);
    }

    pub(super) fn int32(&mut self, value: i32) {
        self.put(value.to_le_bytes());
    }

    pub(super) fn uint32(&mut self, value: u32) {
        self.put(value.to_le_bytes());
    }

    pub(super) fn float64(&mut self, value: f64) {
        self.put(value.to_le_bytes());
    }

    /// A sequence of bytes: its length, and they.
    pub(super) fn bytes(&mut self, bytes: &[u8]) {
        self.uint32(u32::try_from(bytes.len()).unwrap_or(u32::MAX));
        self.buffer.extend_from_slice(bytes);
    }

    /// A string: its length with the closing zero, its bytes, the zero.
    pub(super) fn string(&mut self, text: &str) {
        self.uint32(u32::try_from(text.len() + 1).unwrap_or(u32::MAX));
        self.buffer.extend_from_slice(text.as_bytes());
        self.buffer.push(0);
    }
}
