//! What proves the whole: the hidden-effect benchmark ([`blind`]), fuzzing ([`fuzz`]) and a hundred nights with faults ([`soak`]);
//! the integration tests are in `whole/`.

pub mod blind;
pub mod fuzz;
pub mod soak;
