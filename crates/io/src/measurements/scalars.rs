//! Columns of measured numbers: channels where no column `kind` stands beside them.

use crate::Quantity;

/// Their names.
pub(super) const SCALARS: [&str; 4] = ["distance", "value", "u", "v"];

/// What they are, in words.
pub(super) const MEANINGS: [&str; 4] =
    ["measured distance", "measured value", "place in the image, to the right", "place in the image, down"];

/// What they measure.
pub(super) fn quantity(k: usize) -> Quantity {
    if k < 2 { Quantity::Length } else { Quantity::Pixels }
}

/// The usual unit, for messages.
pub(super) fn usual_unit(k: usize) -> &'static str {
    if k < 2 { "mm" } else { "px" }
}
