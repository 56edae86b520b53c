//! What makes two strikes the same one.

use logs::Sample;
use sha2::{Digest, Sha256};
use values::Strike;

/// Centroids count until this long after the command fell back, in ns.
pub(crate) const AFTER: i64 = 250_000_000;

/// The id of a strike (16 hex digits): a hash of the stamps and values of its command, from rise to fall, and of the
/// centroids from its rise until a quarter second after its fall.
///
/// It holds nothing that depends on the file: neither its name nor its chunks, encoding or receipt times; and nothing that
/// is estimated, so that a log that begins or ends nearer to the strike gives the same id.
pub(crate) fn strike_id<'a>(
    commands: &[Sample],
    centroids: impl IntoIterator<Item = &'a Sample>,
) -> String {
    let (Some(first), Some(last)) = (commands.first(), commands.last()) else {
        return String::new();
    };
    let during = first.stamp..=last.stamp.saturating_add(AFTER);
    let mut hasher = Sha256::new();
    hasher.update(b"strike 1");
    for command in commands {
        hasher.update(canonical(command));
    }
    hasher.update(b"centroids");
    for centroid in centroids
        .into_iter()
        .filter(|centroid| during.contains(&centroid.stamp))
    {
        hasher.update(canonical(centroid));
    }
    durable::hex(&hasher.finalize()[..8])
}

/// A hash of a strike's command and of where its frames lie (16 hex digits), whatever their stamps: of two strikes that have the same one,
/// one is the other, recorded again. None where places repeat, as in steps of a coarse tracker, and may be another's by chance.
pub(crate) fn places_id(strike: &Strike) -> Option<String> {
    /// Number of places in a row that must differ.
    const DIFFER: usize = 12;
    let track = &strike.track;
    let moves = |i: &usize| track.point(*i) != track.point(*i - 1);
    if (1..track.len()).filter(moves).count() < DIFFER.max(track.len() - 1) {
        return None;
    }
    let mut hasher = Sha256::new();
    let command = [strike.command.speed, strike.command.angle];
    for number in command.iter().chain(&track.x).chain(&track.y) {
        hasher.update((number + 0.0).to_bits().to_le_bytes());
    }
    Some(durable::hex(&hasher.finalize()[..8]))
}

/// The id of a slide that no strike began (16 hex digits): a hash of its centroids.
pub(crate) fn slide_id(centroids: &[Sample]) -> String {
    let mut hasher = Sha256::new();
    hasher.update(b"slide 1");
    for centroid in centroids {
        hasher.update(canonical(centroid));
    }
    durable::hex(&hasher.finalize()[..8])
}

/// A sample in 24 bytes; both zeros are one.
fn canonical(sample: &Sample) -> [u8; 24] {
    let mut bytes = [0; 24];
    bytes[..8].copy_from_slice(&sample.stamp.to_le_bytes());
    bytes[8..16].copy_from_slice(&(sample.x + 0.0).to_bits().to_le_bytes());
    bytes[16..].copy_from_slice(&(sample.y + 0.0).to_bits().to_le_bytes());
    bytes
}
