//! Who vouches for a version: a signature of its manifest, in minisign's format.
//!
//! The manifest holds the hash of every file, so its signature covers them all. It lies beside it as
//! `manifest.json.minisig`; `minisign -Vm manifest.json -p KEY.pub` checks it. Its trusted comment, which is signed too,
//! names the version and counts what was put to use: an executor that has seen a higher count does not go back. Taking an
//! earlier version into use signs it anew, with the next count.

use std::fmt::Debug;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

use minisign_verify::{PublicKey, Signature};

use crate::version::number;
use crate::{ArtifactError, Fault};

/// The signature of a version's manifest.
pub const SIGNATURE: &str = "manifest.json.minisig";

/// Longest signature that is read, in bytes; one of ours has some 300.
const LONGEST: u64 = 4096;

/// A public key: what it signed is trusted.
#[derive(Clone, Debug)]
pub struct Key(PublicKey);

/// Signs manifests with a secret key.
pub trait Signer: Debug + Send + Sync {
    /// The public key to its secret one.
    fn key(&self) -> &Key;

    /// The text of a signature of `content` with this trusted comment; an error completes "failed to …".
    fn sign(&self, content: &[u8], trusted_comment: &str) -> Result<String, String>;
}

impl Key {
    /// Reads a public key: minisign's file of two lines, or its second line alone.
    pub fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let key = if text.contains('\n') {
            PublicKey::decode(text)
        } else {
            PublicKey::from_base64(text)
        };
        key.map(Self)
            .map_err(|error| format!("it holds no public key of minisign ({error})"))
    }

    /// Whether a version's signature is another key's, going by what it says of itself.
    pub(crate) fn is_anothers(&self, dir: &Path) -> bool {
        let signature = read(&dir.join(SIGNATURE)).ok().flatten();
        let signature = signature.and_then(|text| Signature::decode(&text).ok());
        let said = signature.map(|signature| self.0.verify(&[], &signature, false));
        matches!(said, Some(Err(minisign_verify::Error::UnexpectedKeyId)))
    }

    /// The count of a version's signature, if this key made it for this version and these bytes of its manifest.
    pub(crate) fn check(&self, dir: &Path, version: &str, manifest: &[u8]) -> Result<u64, Fault> {
        let bad = Fault::BadSignature;
        let text = read(&dir.join(SIGNATURE))?.ok_or(Fault::NotSigned)?;
        let signature = Signature::decode(&text).map_err(|error| bad(error.to_string()))?;
        self.0
            .verify(manifest, &signature, false)
            .map_err(|error| bad(error.to_string()))?;
        let comment = signature.trusted_comment();
        match parse_comment(comment) {
            Some((signed, sequence)) if signed == version => Ok(sequence),
            Some((signed, _)) => Err(bad(format!("it was made for {signed}"))),
            None => Err(bad(format!("its comment {comment:?} names no version"))),
        }
    }
}

/// Whether a version's folder holds a signature, of whatever key.
pub(crate) fn is_signed(dir: &Path) -> bool {
    dir.join(SIGNATURE).exists()
}

/// The text of a signature that puts a version to use as the `sequence`-th.
pub(crate) fn sign(
    signer: &dyn Signer,
    version: &str,
    manifest: &[u8],
    sequence: u64,
) -> Result<String, ArtifactError> {
    signer
        .sign(manifest, &format!("carom {version} sequence {sequence}"))
        .map_err(|why| ArtifactError::Signing {
            version: version.into(),
            why,
        })
}

fn parse_comment(comment: &str) -> Option<(&str, u64)> {
    let (version, sequence) = comment.strip_prefix("carom ")?.split_once(" sequence ")?;
    number(version)?;
    Some((version, sequence.parse().ok()?))
}

/// The text of a signature; none where there is no file. Bytes that are no text are as good as a wrong signature.
fn read(path: &Path) -> Result<Option<String>, durable::Error> {
    let mut bytes = Vec::new();
    let reading = File::open(path).and_then(|file| file.take(LONGEST).read_to_end(&mut bytes));
    match reading {
        Ok(_) => Ok(Some(String::from_utf8_lossy(&bytes).into_owned())),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(durable::Error::new("read", path, error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comment_names_a_version_and_a_count() {
        assert_eq!(
            parse_comment("carom v0003 sequence 17"),
            Some(("v0003", 17))
        );
        for text in [
            "",
            "carom v3 sequence 17",
            "carom v0003 sequence -1",
            "carom v0003",
            "timestamp:1700000000",
        ] {
            assert_eq!(parse_comment(text), None, "{text}");
        }
    }

    #[test]
    fn what_is_no_key_is_reported() {
        for text in ["", "RWQ", "untrusted comment: x\nRWQ=\n"] {
            assert!(Key::parse(text).is_err(), "{text}");
        }
    }
}
