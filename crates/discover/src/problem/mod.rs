//! The data linearised at a fit, and a candidate beside the model of that fit.

pub(crate) mod autocorrelation;
#[cfg(test)]
pub(crate) mod dense;
pub(crate) mod dependence;
#[cfg(test)]
mod dependence_tests;
pub(crate) mod evaluated;
pub(crate) mod joint_noise;
#[cfg(test)]
mod joint_noise_tests;
pub(crate) mod likelihood;
pub(crate) mod linear;
pub(crate) mod linearisation;
pub(crate) mod noise;
pub(crate) mod normal;
pub(crate) mod observation;
#[cfg(test)]
mod oracle;
pub(crate) mod outliers;
pub(crate) mod projection;
pub(crate) mod restricted;
pub(crate) mod sequence;
pub(crate) mod shared;
#[cfg(test)]
pub(crate) mod synthetic;
pub(crate) mod tables;
pub(crate) mod wander;
pub(crate) mod whitening;
