//! Strikes forwards and backwards, against formulas and against themselves.

mod delivery;
mod solve;
mod strike;
mod turned;
