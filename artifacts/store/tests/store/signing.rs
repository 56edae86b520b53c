//! A key pair of minisign, as the pipeline signs with it.

use std::sync::Arc;

use store::{Key, Signer};

#[derive(Debug)]
pub struct Signing {
    pub pair: minisign::KeyPair,
    key: Key,
}

impl Signing {
    pub fn new() -> Arc<Self> {
        let pair = minisign::KeyPair::generate_unencrypted_keypair().unwrap();
        let key = Key::parse(&pair.pk.to_base64()).unwrap();
        Arc::new(Self { pair, key })
    }
}

impl Signer for Signing {
    fn key(&self) -> &Key {
        &self.key
    }

    fn sign(&self, content: &[u8], trusted_comment: &str) -> Result<String, String> {
        let (pk, sk) = (&self.pair.pk, &self.pair.sk);
        minisign::sign(Some(pk), sk, content, Some(trusted_comment), None)
            .map(minisign::SignatureBox::into_string)
            .map_err(|error| error.to_string())
    }
}
