//! What proves the whole: the hidden-effect benchmark ([`blind`]); the integration tests are in `whole/`.

pub mod blind;
