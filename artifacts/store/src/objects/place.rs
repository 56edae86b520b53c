//! A prefix of a store, and its objects.

use std::ffi::OsString;
use std::future::Future;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use durable::Lock;
use futures_util::TryStreamExt;
use object_store::aws::AmazonS3Builder;
use object_store::azure::MicrosoftAzureBuilder;
use object_store::gcp::GoogleCloudStorageBuilder;
use object_store::local::LocalFileSystem;
use object_store::path::Path as Key;
use object_store::{
    BackoffConfig, GetOptions, GetRange, ObjectMeta, ObjectStore, ObjectStoreExt, PutMode,
    RetryConfig, UpdateVersion,
};
use url::Url;

use super::http::Connector;
use super::{Object, ObjectError};

/// A request is tried again so often, and no longer than that; so is what must not be done twice and was not done.
const TRIES: usize = 6;
const PATIENCE: Duration = Duration::from_secs(60);
/// More than this is read by several requests.
const PIECE: u64 = 8 << 20;

/// A prefix of a bucket or container, or a folder.
#[derive(Clone, Debug)]
pub struct Place {
    store: Arc<dyn ObjectStore>,
    prefix: Key,
    url: String,
    /// Of `file://`: a folder has no conditions, and is locked in place of them.
    folder: Option<PathBuf>,
}

/// Whether a variable of the environment is a store's own address.
fn is_endpoint(name: &str) -> bool {
    name.ends_with("ENDPOINT") || name.contains("ENDPOINT_URL")
}

/// The variables of the environment that stores read.
fn variables() -> impl Iterator<Item = (String, OsString)> {
    let is_theirs = |name: &str| {
        let prefixes = ["AWS_", "GOOGLE_", "AZURE_"];
        prefixes.iter().any(|prefix| name.starts_with(prefix))
    };
    let all =
        std::env::vars_os().filter_map(|(name, value)| Some((name.into_string().ok()?, value)));
    all.filter(move |(name, _)| is_theirs(name))
}

/// What no request can be made of.
fn check_environment() -> Result<(), String> {
    for (name, value) in variables() {
        let text = value.to_str().unwrap_or("\n");
        // Google's key may be a text of many lines.
        if text.contains(char::is_control) && !name.starts_with("GOOGLE_") {
            return Err(format!(
                "{name} holds a line break, or what is no text; set it anew"
            ));
        }
        let is_address = |url: &Url| ["http", "https"].contains(&url.scheme()) && url.has_host();
        let has_ascii_host = |url: &Url| url.host_str().is_some_and(|host| text.contains(host));
        if is_endpoint(&name)
            && !Url::parse(text).is_ok_and(|url| is_address(&url) && has_ascii_host(&url))
        {
            return Err(format!(
                "{name} is no address; give https://HOST or http://HOST:PORT"
            ));
        }
    }
    Ok(())
}

impl Place {
    /// A place by its URL; nothing is asked yet.
    pub fn open(url: &str) -> Result<Self, ObjectError> {
        // Nothing of a URL that may hold a secret is repeated.
        let shown = url.split(['?', '#']).next().unwrap_or_default();
        let shown = match shown.split_once("://") {
            Some((scheme, rest)) => {
                format!("{scheme}://{}", rest.rsplit('@').next().unwrap_or_default())
            }
            None => shown.into(),
        };
        let shown = shown.trim_end_matches('/').to_owned();
        let wrong = |why: &str| ObjectError::Url {
            url: shown.clone(),
            why: why.into(),
        };
        let parsed = Url::parse(url).map_err(|error| wrong(&format!("it is no URL ({error})")))?;
        if !parsed.username().is_empty() || parsed.password().is_some() || parsed.query().is_some()
        {
            return Err(wrong(
                "credentials are given in the environment, and in no URL",
            ));
        }
        check_environment().map_err(|why| wrong(&why))?;
        let retry = RetryConfig {
            backoff: BackoffConfig {
                init_backoff: Duration::from_millis(50),
                max_backoff: Duration::from_secs(5),
                base: 2.0,
            },
            max_retries: TRIES,
            retry_timeout: PATIENCE,
        };
        let mut folder = None;
        let built: object_store::Result<Arc<dyn ObjectStore>> = match parsed.scheme() {
            "s3" => AmazonS3Builder::from_env()
                .with_url(url)
                .with_retry(retry)
                .with_http_connector(Connector)
                .build()
                .map(|store| Arc::new(store) as _),
            "gs" => GoogleCloudStorageBuilder::from_env()
                .with_url(url)
                .with_retry(retry)
                .with_http_connector(Connector)
                .build()
                .map(|store| Arc::new(store) as _),
            "az" => MicrosoftAzureBuilder::from_env()
                .with_url(url)
                .with_retry(retry)
                .with_http_connector(Connector)
                .build()
                .map(|store| Arc::new(store) as _),
            "file" => {
                let path = parsed
                    .to_file_path()
                    .map_err(|()| wrong("give file:///PATH"))?;
                durable::create_dir(&path)?;
                folder = Some(path.clone());
                LocalFileSystem::new_with_prefix(path).map(|store| Arc::new(store) as _)
            }
            _ => {
                return Err(wrong(
                    "give s3://BUCKET/PREFIX, gs://BUCKET/PREFIX, az://CONTAINER/PREFIX or file:///PATH",
                ));
            }
        };
        let store = built.map_err(|error| ObjectError::of(shown.clone(), &error))?;
        let prefix = match &folder {
            Some(_) => Key::default(),
            None => Key::from_url_path(parsed.path()).map_err(|error| wrong(&error.to_string()))?,
        };
        Ok(Self {
            store,
            prefix,
            url: shown,
            folder,
        })
    }

    /// A place in memory, for tests.
    #[doc(hidden)]
    pub fn in_memory() -> Self {
        Self {
            store: Arc::new(object_store::memory::InMemory::new()),
            prefix: Key::default(),
            url: "memory://".into(),
            folder: None,
        }
    }

    /// Its URL, without anything secret.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Where copies of it lie below a folder: `s3/BUCKET/PREFIX`, of a store at an address of its own `s3/ADDRESS/BUCKET/PREFIX`.
    pub fn below(&self, folder: &Path) -> PathBuf {
        let (scheme, rest) = self.url.split_once("://").unwrap_or(("", &self.url));
        let of_s3 = |name: &str| name.starts_with("AWS_ENDPOINT") && is_endpoint(name);
        let at = variables().find(|(name, _)| scheme == "s3" && of_s3(name));
        let at = at.map(|(_, at)| at.to_string_lossy().into_owned());
        let at = at.as_deref().and_then(|at| at.split_once("://"));
        let parts = [scheme, at.map_or("", |(_, at)| at)];
        let parts = parts.into_iter().chain(rest.split('/'));
        let parts = parts.filter(|part| !part.is_empty() && *part != "..");
        parts.fold(folder.into(), |path, part| {
            path.join(part.trim_end_matches('/'))
        })
    }

    /// Every object below the prefix, or the one that the URL names, in the order of their names.
    pub fn list(&self) -> Result<Vec<Object>, ObjectError> {
        let below = || {
            self.store
                .list(Some(&self.prefix))
                .try_collect::<Vec<ObjectMeta>>()
        };
        let mut found = self.ask("", below())?;
        if found.is_empty() && !self.prefix.as_ref().is_empty() {
            found = match self.ask("", self.store.head(&self.prefix)) {
                Ok(one) => vec![one],
                Err(ObjectError::NotFound { .. }) => Vec::new(),
                Err(error) => return Err(error),
            };
        }
        let object = |meta: ObjectMeta| {
            let name = meta.location.as_ref().strip_prefix(self.prefix.as_ref())?;
            Some(Object {
                name: name.trim_start_matches('/').into(),
                size: meta.size,
                tag: meta
                    .e_tag
                    .unwrap_or_else(|| meta.last_modified.to_rfc3339()),
                modified: meta.last_modified.timestamp(),
            })
        };
        let mut objects: Vec<Object> = found.into_iter().filter_map(object).collect();
        objects.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(objects)
    }

    /// An object's bytes and its tag.
    pub fn get(&self, name: &str) -> Result<(Vec<u8>, Option<String>), ObjectError> {
        self.ask(name, async {
            let found = self.store.get(&self.key(name)).await?;
            let tag = found.meta.e_tag.clone();
            Ok((found.bytes().await?.to_vec(), tag))
        })
    }

    /// A part of an object as it was listed; an error where it has changed since.
    pub fn read(&self, object: &Object, range: Range<u64>) -> Result<Vec<u8>, ObjectError> {
        let mut bytes = Vec::new();
        let mut at = range.start;
        while at < range.end {
            let end = range.end.min(at + PIECE);
            let options = GetOptions {
                if_match: Some(object.tag.clone()).filter(|_| self.folder.is_none()),
                range: Some(GetRange::Bounded(at..end)),
                ..GetOptions::default()
            };
            let piece = self.ask(&object.name, async {
                self.store
                    .get_opts(&self.key(&object.name), options)
                    .await?
                    .bytes()
                    .await
            })?;
            if piece.len() as u64 != end - at {
                return Err(ObjectError::Changed {
                    url: self.of(&object.name),
                });
            }
            bytes.extend_from_slice(&piece);
            at = end;
        }
        Ok(bytes)
    }

    /// Writes an object where none of that name is; whether one with these bytes is there now. What was written is read back: an answer
    /// that was lost on its way says nothing of what the store holds.
    pub fn create(&self, name: &str, bytes: &[u8]) -> Result<bool, ObjectError> {
        let mut tries = TRIES;
        loop {
            tries -= 1;
            let written = self.put(name, bytes, PutMode::Create);
            match (self.get(name), written) {
                (Ok((found, _)), _) => return Ok(found == bytes),
                // It never came there: once more does no harm.
                (Err(error), Err(_)) if error.is_not_found() && tries > 0 => {}
                (Err(_), Err(error)) | (Err(error), Ok(())) => return Err(error),
            }
        }
    }

    /// Replaces an object if it is still the one with this tag, or there is still none; whether these bytes are in its place now.
    pub fn swap(&self, name: &str, bytes: &[u8], tag: Option<&str>) -> Result<bool, ObjectError> {
        let mut tries = TRIES;
        loop {
            tries -= 1;
            let Err(error) = self.replace(name, bytes, tag) else {
                return Ok(true);
            };
            // Refused, or done and the answer lost, or never there: what is there tells.
            let (is_ours, now) = match self.get(name) {
                Ok((found, now)) => (found == bytes, now),
                Err(error) if error.is_not_found() => (false, None),
                Err(_) => return Err(error),
            };
            match (is_ours, now.as_deref() == tag) {
                (true, _) => return Ok(true),
                (false, false) => return Ok(false),
                (false, true) if tries == 0 => return Err(error),
                (false, true) => {}
            }
        }
    }

    fn replace(&self, name: &str, bytes: &[u8], tag: Option<&str>) -> Result<(), ObjectError> {
        let Some(tag) = tag else {
            return self.put(name, bytes, PutMode::Create);
        };
        let Some(folder) = &self.folder else {
            let version = UpdateVersion {
                e_tag: Some(tag.into()),
                version: None,
            };
            return self.put(name, bytes, PutMode::Update(version));
        };
        let _lock = Lock::acquire(&folder.join(".lock")).map_err(|error| ObjectError::Store {
            url: self.of(name),
            why: error.to_string(),
        })?;
        match self.get(name)?.1.as_deref() == Some(tag) {
            true => self.put(name, bytes, PutMode::Overwrite),
            false => Err(ObjectError::Changed { url: self.of(name) }),
        }
    }

    fn put(&self, name: &str, bytes: &[u8], mode: PutMode) -> Result<(), ObjectError> {
        let key = self.key(name);
        let put = self
            .store
            .put_opts(&key, bytes.to_vec().into(), mode.into());
        self.ask(name, put).map(drop)
    }

    /// An object's key, as a list gives it.
    fn key(&self, name: &str) -> Key {
        let key = format!("{}/{name}", self.prefix);
        let key = key.trim_matches('/');
        Key::parse(key).unwrap_or_else(|_| Key::from(key))
    }

    fn of(&self, name: &str) -> String {
        match name {
            "" => self.url.clone(),
            name => format!("{}/{name}", self.url),
        }
    }

    /// Waits for an answer, on this thread.
    fn ask<T>(
        &self,
        name: &str,
        answer: impl Future<Output = object_store::Result<T>>,
    ) -> Result<T, ObjectError> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_time()
            .build();
        let runtime = runtime.map_err(|source| {
            durable::Error::new("start asking for", Path::new(&self.of(name)), source)
        })?;
        runtime
            .block_on(answer)
            .map_err(|error| ObjectError::of(self.of(name), &error))
    }
}
