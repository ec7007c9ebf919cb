//! Parameters in which an effect is not linear: searched for, refined, and given their intervals.

mod grid;
mod interval;
mod judge;
mod late;
mod mixture;
mod picture;
mod profile;
mod refine;
mod scan;

pub use judge::{descend_nonlinear, judge_nonlinear};
pub(crate) use profile::{fit, wanted};
