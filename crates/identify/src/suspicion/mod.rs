//! What may be wrong with a table: columns swapped, a unit, an order, a sign, single rows.

mod cause;
mod constants;
mod detect;
mod hypotheses;
mod outlying;
pub(crate) mod registration;

pub use cause::{Cause, Suspicion};
pub use detect::{suspicion, suspicions};

/// Whether a mistake, undone, leaves so little of what it left (m) that it is the cause, although the arm is coarse beside its length (m): a servo arm,
/// whose dimensions are good to some per cent. Conventions.
pub(crate) fn decisive(before: f64, after: f64, length: f64) -> bool {
    const LEFT: f64 = 0.1;
    const COARSE: f64 = 0.05;
    after < LEFT * before && after < COARSE * length
}

#[cfg(test)]
mod tests;
