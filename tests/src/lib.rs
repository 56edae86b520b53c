//! What proves the whole: the hidden-effect benchmark ([`blind`]), the real strikes of a KUKA arm ([`kuka`]), tables that change ([`living`]), fuzzing ([`fuzz`]) and a hundred nights with faults ([`soak`]);
//! the integration tests are in `whole/`.

pub mod blind;
pub mod fuzz;
pub mod kuka;
pub mod living;
pub mod soak;
