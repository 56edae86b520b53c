//! `carom key`: keys that versions are signed with.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Subcommand;
use minisign::{KeyPair, SecretKeyBox};
use serde_json::json;

use crate::Error;
use crate::args::examples;
use crate::error::Output;
use crate::outputs::write_new;

/// `carom key`.
#[derive(Debug, Subcommand)]
pub enum KeyCommand {
    /// Write a key pair: a secret key to sign versions with, and FILE.pub for the robots.
    #[command(after_help = examples(&["carom key new --out carom.key"]))]
    New {
        /// File of the secret key, which must not be there yet; the public key's ends in `.pub`.
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
    },
}

/// Does what was asked.
pub fn run(command: &KeyCommand) -> Result<Output, Error> {
    let KeyCommand::New { out } = command;
    new_key(out)
}

/// Writes a secret key that only its owner may read, and its public one beside it, ending in `.pub`.
fn new_key(secret: &Path) -> Result<Output, Error> {
    let public = secret.with_extension("pub");
    let pair = KeyPair::generate_unencrypted_keypair().map_err(Error::failed)?;
    let text = |made: Result<String, minisign::PError>| made.map_err(Error::failed);
    let secret_text = text(pair.sk.to_box(None).map(SecretKeyBox::into_string))?;
    let public_text = text(pair.pk.to_box().map(minisign::PublicKeyBox::into_string))?;
    write_new(&public, 0o644, public_text.as_bytes())?;
    if let Err(error) = write_new(secret, 0o600, secret_text.as_bytes()) {
        // A public key without its secret one is of no use; the first error is the one to report.
        let _ = fs::remove_file(&public);
        return Err(error);
    }
    Ok(Output::done(
        json!({ "secret": secret, "public": public, "key": pair.pk.to_base64() }),
        format!(
            "secret key  {}: sign with `--key` of run, publish, nightly and artifacts; keep a copy where no robot is\n\
             public key  {}: copy it to the robots, `strike --key`\n",
            secret.display(),
            public.display()
        ),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signing::{SecretSigner, public_key};
    use store::Signer;

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
