//! What may be wrong with a table: columns swapped, a unit, an order, a sign, single rows.

mod cause;
mod constants;
mod detect;
mod hypotheses;
mod outlying;
pub(crate) mod registration;

pub use cause::{Cause, Suspicion};
pub use detect::{suspicion, suspicions};

#[cfg(test)]
mod tests;
