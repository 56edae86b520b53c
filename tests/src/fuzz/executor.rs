//! What the executor reads: lines of a batch, and signatures.

use std::fs;

use anyhow::anyhow;
use serde_json::Value;
use store::{Key, Model, SIGNATURE, Store};
use strike::{Planner, batch};

use super::Reads;
use super::seeds;

/// Lines of a batch that are planned or refused.
pub(super) fn lines() -> Vec<Vec<u8>> {
    [
        "{\"from\": [0.25, 0.05], \"to\": [0.65, 0.05]}\n",
        "{\"from\":[0.25,0.05],\"to\":[9.0,0.05]}\n\n{\"from\":[0.25,0.05],\"to\":[0.65,0.05]}",
        "{\"to\": [0.65, 0.05]}\n[1, 2]\nnull\n",
    ]
    .map(|text| text.as_bytes().to_vec())
    .into()
}

/// Plans a batch: every line that is not empty has one answer, an object on a line of its own.
pub(super) fn batch_reader() -> impl Fn(&[u8]) -> anyhow::Result<()> {
    let folder = tempfile::tempdir().expect("a folder");
    let store = Store::open(folder.path());
    store.publish(&seeds::contents()).expect("a version");
    let artifact = store.load(None).expect("a whole version");
    let planner = Planner::new(&artifact, Model::Nominal).expect("a planner");
    move |input| {
        let mut output = Vec::new();
        let tally = batch::run(&planner, input, &mut output)?;
        let answers: Vec<Value> = output
            .split(|byte| *byte == b'\n')
            .filter(|line| !line.is_empty())
            .map(|line| serde_json::from_slice(line).expect("an answer is an object"))
            .collect();
        assert_eq!(answers.len(), tally.planned + tally.refused);
        match answers
            .iter()
            .find(|answer| answer.get("refused").is_some())
        {
            None => Ok(()),
            Some(refusal) => Err(anyhow!(refusal["detail"].to_string())),
        }
    }
}

/// A true signature, and what reads another in its place: none may pass with another count than the one that was signed.
pub(super) fn signatures() -> (Vec<Vec<u8>>, Reads) {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    let store = Store::open(folder.path());
    let version = store.publish(&seeds::contents()).expect("a version");
    for line in [
        format!("key new --out {dir}/key"),
        format!("artifacts sign --artifacts {dir} --key {dir}/key"),
    ] {
        crate::carom(&line).expect("a signature");
    }
    let key = fs::read_to_string(folder.path().join("key.pub")).expect("a key");
    let key = Key::parse(&key).expect("a key");
    let path = store.version_dir(&version).join(SIGNATURE);
    let whole = fs::read(&path).expect("a signature");
    let read = move |input: &[u8]| {
        let _kept = &folder;
        fs::write(&path, input)?;
        let (_, sequence) = store.load_trusted(None, &key)?;
        assert_eq!(sequence, 1, "a forged count passes");
        Ok(())
    };
    (vec![whole], Box::new(read))
}
