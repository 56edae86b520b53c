//! From logs to strikes: what is kept and how it is measured, and what is rejected and why.

mod bags;
mod common;
mod cuts;
mod demo;
mod faults;
mod hostile;
mod kuka;
mod streams;
mod strikes;
