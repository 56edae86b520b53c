//! What a target of the fuzzer is.

/// Something that reads bytes.
pub struct Target {
    pub name: &'static str,
    pub seeds: Vec<Vec<u8>>,
    pub words: &'static [&'static str],
    /// Reads an input, or says why not.
    pub read: Reads,
}

/// Reads an input, or says why not.
pub type Reads = Box<dyn Fn(&[u8]) -> Result<(), String> + Send + Sync>;
