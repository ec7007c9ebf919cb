//! Family-wise p-values by resampling.

pub(crate) mod sign_flips;
