//! Least squares over a stream of rows: accumulators of constant size that merge in any order.
//!
//! [`Triangular`] keeps the triangular factor of [A | Y] and all digits; [`Gram`] keeps AᵀA, is three times cheaper on
//! tall blocks and keeps half the digits. Both finish into a [`Factor`], on which everything else works. Merge in a
//! fixed order and the result is the same bit for bit, whoever made the parts.

mod bytes;
mod directions;
mod factor;
mod gram;
mod left_out;
mod pieces;
mod sets;
mod solve;
mod triangular;

pub use directions::Directions;
pub use factor::{ColumnScale, Factor, NullSpace};
pub use gram::Gram;
pub use left_out::LeftOut;
pub use triangular::Triangular;
