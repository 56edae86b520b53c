//! What the store promises: whole versions, refusals that name the damage, and a way back.

mod damage;
mod fixture;
mod publishing;
mod remote;
mod versions;
