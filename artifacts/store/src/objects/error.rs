//! What goes wrong with a store, and how to mend it. A store's own words are not repeated: they may hold a key's name.

#[cfg(feature = "client")]
use std::error::Error as _;

/// Why an object was not read or written. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum ObjectError {
    #[error("use {url}: {why}")]
    Url { url: String, why: String },
    #[error("read {url}: there is none; name what is there")]
    NotFound { url: String },
    #[error("read {url}: it was replaced while it was read; run again")]
    Changed { url: String },
    #[error("reach {url}: {why}")]
    Store { url: String, why: String },
    #[error(transparent)]
    Io(#[from] durable::Error),
}

/// A store's codes, and what to do about them. Sources: S3's list of error codes; Azure's, of the Blob service.
#[cfg(feature = "client")]
const CODES: &str = "
NoSuchBucket there is no such bucket; make it, or mend the URL
ContainerNotFound there is no such container; make it, or mend the URL
RequestTimeTooSkewed this computer's clock is more than 15 minutes off the store's; set it, as by `timedatectl set-ntp true`
SignatureDoesNotMatch the secret key is not that of the access key; set AWS_SECRET_ACCESS_KEY anew
InvalidAccessKeyId the store does not know the access key; set AWS_ACCESS_KEY_ID anew
ExpiredToken the session's token has expired; set the credentials anew
InvalidToken the session's token makes no sense; set the credentials anew
AuthenticationFailed the credentials do not hold; set them anew, and look at the clock
AccessDenied the credentials do not allow that; have whoever owns it allow it
";
#[cfg(feature = "client")]
const CREDENTIALS: &str = "there are no credentials; set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY (or AWS_SKIP_SIGNATURE=true for a public bucket), \
                           GOOGLE_APPLICATION_CREDENTIALS, or AZURE_STORAGE_ACCOUNT_NAME and AZURE_STORAGE_ACCOUNT_KEY";

impl ObjectError {
    #[cfg(feature = "client")]
    /// The error of asking for `url`, without what may be secret in the store's answer.
    pub(crate) fn of(url: String, error: &object_store::Error) -> Self {
        use object_store::Error as E;
        let (all, lowest) = chain(error);
        let told = |code: &str| {
            let mut known = CODES.lines().filter_map(|line| line.split_once(' '));
            known.find(|(name, _)| *name == code).map(|(_, why)| why)
        };
        let code = all.split_once("<Code>");
        let code = code.and_then(|(_, rest)| Some(rest.split_once("</Code>")?.0));
        // Without keys in the environment a computer of the cloud is asked for its own.
        let is_computer = all.contains("169.254.") || all.contains("metadata.google");
        let why = match (error, code.and_then(told)) {
            (_, Some(why)) => why.into(),
            (E::NotFound { .. }, None) => return Self::NotFound { url },
            (E::Precondition { .. }, None) => return Self::Changed { url },
            (E::PermissionDenied { .. }, None) => told("AccessDenied").unwrap_or_default().into(),
            (E::Unauthenticated { .. }, None) => CREDENTIALS.into(),
            (_, None) if is_computer => CREDENTIALS.into(),
            (_, None) => format!("{lowest}; try again when it can be reached"),
        };
        Self::Store { url, why }
    }

    /// Whether there is no such object.
    pub fn is_not_found(&self) -> bool {
        matches!(self, Self::NotFound { .. })
    }
}

#[cfg(feature = "client")]
/// An error and all below it; and the lowest, a status or a connection's error, up to where a store's own words begin.
fn chain(error: &object_store::Error) -> (String, String) {
    let (mut all, mut lowest) = (error.to_string(), error.to_string());
    let mut below = error.source();
    while let Some(source) = below {
        lowest = source.to_string();
        all += &lowest;
        below = source.source();
    }
    let lowest = lowest.split(['<', '{', '\n']).next().unwrap_or_default();
    let lowest = lowest.trim_end_matches([':', ' ']);
    (all, lowest.chars().take(200).collect())
}
