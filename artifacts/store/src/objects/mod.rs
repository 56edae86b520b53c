//! Objects by URL: `s3://`, `gs://`, `az://` and `file://`, read by ranges, listed, and written on conditions.
//!
//! Credentials come from the environment as each store's own tools name them (`AWS_…`, `GOOGLE_…`, `AZURE_…`), and are in no text that this
//! module gives. Requests are made one after another on the thread that asks, and repeated where a store is busy or a connection breaks.

#[cfg(not(feature = "client"))]
mod absent;
mod error;
#[cfg(feature = "client")]
mod http;
mod object;
#[cfg(feature = "client")]
mod place;

#[cfg(not(feature = "client"))]
pub use absent::Place;
pub use error::ObjectError;
pub use object::{Object, is_url, own_folder, path_of};
#[cfg(feature = "client")]
pub use place::Place;
