//! Reduction to what can be identified (Eq. 8–16): c = B β.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | c | coefficients of the model | p | each its own |
//! | β | grouped errors | r | as the kept column |
//! | C | relations of dropped columns | (p − r) × p | unscaled |
//!
//! A dropped column p with `J^p = −Σ_j c_j J^j` is left at zero and its error passes into the kept ones:
//! `β_j = ε_j − c_j ε_p`. So B is a selection, and what it selects from is said in words, group by group.
//!
//! Two null spaces are kept apart: the *structural* one, over postures spread within the limits, that no data on this
//! robot with this kind of measurement can fill; and the *practical* one, further directions that this data set
//! leaves unexcited.

mod echelon;
mod grouped;
mod groups;
mod priority;
mod reduce;
mod structural;
mod words;

pub use echelon::{Echelon, echelon};
pub use grouped::grouped;
pub use groups::{Cause, Dropped, Group, Reduction};
pub use priority::{column_word, preference};
pub use reduce::{reduce, reduce_further};
pub use structural::{joint_ranges, spread_factor};
pub use words::group_words;

#[cfg(test)]
mod tests;
