//! Least squares over a stream of rows: accumulators of constant size that merge in any order.
//!
//! [`Triangular`] keeps the triangular factor of [A | Y] and all digits; [`Gram`] keeps AᵀA, is three times cheaper on
//! tall blocks and keeps half the digits. Both finish into a [`Factor`], on which everything else works. Merge in a
//! fixed order and the result is the same bit for bit, whoever made the parts.

use crate::SolveError;

mod bytes;
mod directions;
mod factor;
mod gram;
mod left_out;
mod null_space;
mod pieces;
mod solve;
mod triangular;

pub use directions::Directions;
pub use factor::{ColumnScale, Factor};
pub use gram::Gram;
pub use left_out::LeftOut;
pub use null_space::NullSpace;
pub use triangular::Triangular;

/// Whether a block holds `rows` numbers of each of these columns of a problem and of its right-hand sides, one column `stride` numbers
/// behind the other.
fn fits(
    columns: usize,
    active: &[usize],
    rhs: usize,
    (rows, stride): (usize, usize),
    numbers: &[f64],
) -> Result<(), SolveError> {
    let width = active.len() + rhs;
    let need = if width == 0 || rows == 0 { 0 } else { (width - 1) * stride + rows };
    if numbers.len() < need || (rows > stride && width > 1) {
        let what = "the numbers of the columns";
        return Err(SolveError::Shape { what, expected: need, found: numbers.len() });
    }
    match active.iter().find(|&&column| column >= columns) {
        Some(&far) => Err(SolveError::Shape { what: "the columns", expected: columns, found: far + 1 }),
        None => Ok(()),
    }
}
