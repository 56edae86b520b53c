//! What `--key` names: the secret key that signs versions, the public key that checks them.

use std::fmt;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use minisign::{PublicKey, SecretKey, SecretKeyBox, SignatureBox};
use store::{Key, Signer, Store};

use crate::Error;

/// A secret key and its public one.
pub struct SecretSigner {
    secret: SecretKey,
    key: Key,
}

/// By its public key: the library's own text of a secret key shows the secret.
impl fmt::Debug for SecretSigner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SecretSigner")
            .field("key", &self.key)
            .finish_non_exhaustive()
    }
}

impl SecretSigner {
    /// Reads a secret key of `carom key new`, which has no password: who signs at night cannot be asked. Those of
    /// `minisign -GW` hold no checksum and are not read.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let text = fs::read_to_string(path).map_err(|error| Error::unreadable(path, &error))?;
        let bad = |why: String| {
            Error::input(format!(
                "use the secret key {}: {why}; `carom key new` writes one",
                path.display()
            ))
        };
        let secret = SecretKeyBox::from_string(&text)
            .and_then(SecretKeyBox::into_unencrypted_secret_key)
            .map_err(|error| bad(error.to_string()))?;
        let public = PublicKey::from_secret_key(&secret).map_err(|error| bad(error.to_string()))?;
        let key = Key::parse(&public.to_base64()).map_err(bad)?;
        Ok(Self { secret, key })
    }
}

impl Signer for SecretSigner {
    fn key(&self) -> &Key {
        &self.key
    }

    fn sign(&self, content: &[u8], trusted_comment: &str) -> Result<String, String> {
        let comment = "signature by carom; check with minisign -Vm manifest.json";
        minisign::sign(
            None,
            &self.secret,
            content,
            Some(trusted_comment),
            Some(comment),
        )
        .map(SignatureBox::into_string)
        .map_err(|error| format!("use the secret key: {error}"))
    }
}

/// A run's store, which signs where a secret key is given.
pub fn store(dir: &Path, key: Option<&Path>) -> Result<Store, Error> {
    let store = Store::open(dir);
    Ok(match key {
        Some(path) => store.signed_by(Arc::new(SecretSigner::load(path)?)),
        None => store,
    })
}

/// Reads a public key's file.
pub fn public_key(path: &Path) -> Result<Key, Error> {
    let text = fs::read_to_string(path).map_err(|error| Error::unreadable(path, &error))?;
    Key::parse(&text)
        .map_err(|why| Error::input(format!("use the public key {}: {why}", path.display())))
}
