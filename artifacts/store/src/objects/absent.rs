//! A program without a client of object stores: there is no place.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::{Object, ObjectError};

/// A place that cannot be: this program has no client of object stores.
#[derive(Clone, Debug)]
pub enum Place {}

type Refused<T> = Result<T, ObjectError>;

#[expect(missing_docs, reason = "those of the place with a client")]
impl Place {
    pub fn open(url: &str) -> Refused<Self> {
        Err(ObjectError::Url {
            // What comes before may be a secret.
            url: url.rsplit('@').next().unwrap_or_default().into(),
            why: "this program was built without object stores; copy what lies there into a folder and name that, or build it with the feature `url`".into(),
        })
    }

    pub fn url(&self) -> &str {
        match *self {}
    }

    pub fn below(&self, _folder: &Path) -> PathBuf {
        match *self {}
    }

    pub fn list(&self) -> Refused<Vec<Object>> {
        match *self {}
    }

    pub fn get(&self, _name: &str) -> Refused<(Vec<u8>, Option<String>)> {
        match *self {}
    }

    pub fn read(&self, _object: &Object, _range: Range<u64>) -> Refused<Vec<u8>> {
        match *self {}
    }

    pub fn create(&self, _name: &str, _bytes: &[u8]) -> Refused<bool> {
        match *self {}
    }

    pub fn swap(&self, _name: &str, _bytes: &[u8], _tag: Option<&str>) -> Refused<bool> {
        match *self {}
    }
}
