//! One measured number, and what the instrument states of it.

use truepose_errormodel::Dataset;

/// One measured number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Observation {
    pub row: usize,
    /// 0…2 position, 3…5 orientation.
    pub component: usize,
    pub visit: usize,
}

/// What the instrument states of a position's component in the median, m; NaN where it states nothing.
pub(crate) fn typical_sd(data: &Dataset) -> f64 {
    let mut stated: Vec<f64> = data.position_sd.iter().flatten().copied().filter(|v| !v.is_nan()).collect();
    stated.sort_by(f64::total_cmp);
    stated.get(stated.len() / 2).copied().unwrap_or(f64::NAN)
}
