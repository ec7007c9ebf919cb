//! The rounds of a fit: solve, move, look at the noise and the prior, until nothing moves.

mod finish;
mod first_look;
mod follow;
mod iterate;
mod second_reduction;
mod settle;
mod solve;
mod state;
mod trust;
mod whole;

pub(super) use follow::doubted;
pub(super) use state::{Outcome, State};
pub(crate) use whole::from_factor;
