//! Keys and signatures: `carom key`, and what `--key` names.

use std::fmt;
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::Arc;

use minisign::{KeyPair, PublicKey, SecretKey, SecretKeyBox, SignatureBox};
use serde_json::json;
use store::{Key, Signer, Store};

use crate::Error;
use crate::commands::Said;

/// A secret key and its public one.
pub struct SecretSigner {
    secret: SecretKey,
    key: Key,
}

/// By its public key: the library's own text of a secret key tells the secret.
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

/// `carom key new`: a secret key that only its owner may read, and its public one beside it, ending in `.pub`.
pub fn new_key(secret: &Path) -> Result<Said, Error> {
    let public = secret.with_extension("pub");
    let pair = KeyPair::generate_unencrypted_keypair().map_err(Error::failed)?;
    let text = |made: Result<String, minisign::PError>| made.map_err(Error::failed);
    let secret_text = text(pair.sk.to_box(None).map(SecretKeyBox::into_string))?;
    let public_text = text(pair.pk.to_box().map(minisign::PublicKeyBox::into_string))?;
    create(&public, 0o644, &public_text)?;
    if let Err(error) = create(secret, 0o600, &secret_text) {
        // A public key without its secret one is of no use; the first error is the one to tell.
        let _ = fs::remove_file(&public);
        return Err(error);
    }
    Ok(Said::done(
        json!({ "secret": secret, "public": public, "key": pair.pk.to_base64() }),
        format!(
            "secret key  {}: sign with `--key` of run, publish, nightly and artifacts; keep a copy where no robot is\n\
             public key  {}: copy it to the robots, `strike --key`\n",
            secret.display(),
            public.display()
        ),
    ))
}

/// Creates a file that is not there yet.
fn create(path: &Path, mode: u32, text: &str) -> Result<(), Error> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true).mode(mode);
    options
        .open(path)
        .and_then(|mut file| {
            file.write_all(text.as_bytes())?;
            file.sync_all()
        })
        .map_err(|error| {
            Error::input(format!(
                "create {}: {error}; keys are never overwritten, name another file",
                path.display()
            ))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_signs_is_read_by_its_owner_alone_and_never_overwritten() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().expect("folder");
        let secret = dir.path().join("carom.key");
        new_key(&secret).expect("made");
        let mode = fs::metadata(&secret).expect("there").permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
        let signer = SecretSigner::load(&secret).expect("its own key");
        assert!(format!("{signer:?}").starts_with("SecretSigner { key:"));
        let public = dir.path().join("carom.pub");
        public_key(&public).expect("its own key");

        // Checked by code that shares none with what signs.
        let text = signer
            .sign(b"abc", "carom v0001 sequence 1")
            .expect("signs");
        let signature = minisign_verify::Signature::decode(&text).expect("a signature");
        let public = minisign_verify::PublicKey::from_file(public).expect("a key");
        public.verify(b"abc", &signature, false).expect("holds");
        assert!(public.verify(b"abd", &signature, false).is_err());
        let before = fs::read(&secret).expect("there");
        assert!(new_key(&secret).is_err());
        assert_eq!(fs::read(&secret).expect("there"), before);
        for (path, said) in [("carom.pub", "carom key new"), ("none", "none")] {
            let error = SecretSigner::load(&dir.path().join(path)).expect_err(path);
            assert!(error.to_string().contains(said), "{error}");
        }
    }
}
