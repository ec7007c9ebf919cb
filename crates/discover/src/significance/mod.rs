//! Family-wise p-values by resampling.

#[cfg(test)]
mod calibration;
pub(crate) mod sign_flips;
