//! Family-wise p-values by random rotations, and their check by sign flips.

#[cfg(test)]
mod calibration;
pub(crate) mod rotation;
pub(crate) mod sign_flips;
