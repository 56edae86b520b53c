//! How a run behaves: what it computes, what it reuses, and what a kill, damage or a second run does to it.

mod faults;
mod fixture;
mod reuse;
mod workers;
