//! The data linearised at a fit, and a candidate beside the model of that fit.
//!
//! There is one problem, `min ‖V^{-1/2} (y − A β − X γ)‖² + ‖W β‖² + ‖γ‖²/κ²`, and each question about a candidate X is a solution of its
//! normal equations ([`equations`]):
//!
//! | question | observations | columns | where |
//! | --- | --- | --- | --- |
//! | score of every candidate, V of the model | all | A eliminated once, one step in X | [`projection`], by pose in [`tables`] |
//! | likelihood, V of the candidate | all | A, X | [`likelihood`], by groups that are alike in [`normal`]; where joints scatter [`restricted`], A eliminated once a noise ([`anchor`]) |
//! | gain beside another candidate, V of that one | all | A and the other one eliminated, one step in X | [`beside`] |
//! | prediction of unseen poses | all but a fold | A, X | [`likelihood::Likelihood::held_out`] |
//! | estimate on a half | a half | A, X | [`likelihood::Likelihood::on_halves`] |
//! | error without some effects, or with another in their place | rows of the fit | some of A, X | [`linear`] |
//!
//! [`tables`], [`normal`] and the blocks of [`crate::census`] are accelerations: each has a test against whole matrices (`dense`).

pub(crate) mod anchor;
pub(crate) mod autocorrelation;
pub(crate) mod basis;
pub(crate) mod beside;
#[cfg(test)]
pub(crate) mod dense;
pub(crate) mod dependence;
#[cfg(test)]
mod dependence_tests;
pub(crate) mod emitted;
pub(crate) mod equations;
pub(crate) mod evaluated;
pub(crate) mod heavier;
pub(crate) mod joint_noise;
#[cfg(test)]
mod joint_noise_tests;
pub(crate) mod likelihood;
pub(crate) mod linear;
pub(crate) mod linearisation;
pub(crate) mod loads;
pub(crate) mod noise;
pub(crate) mod normal;
pub(crate) mod observation;
#[cfg(test)]
mod oracle;
pub(crate) mod outliers;
pub(crate) mod outside;
pub(crate) mod projection;
pub(crate) mod residuals;
pub(crate) mod restricted;
pub(crate) mod sequence;
pub(crate) mod shared;
#[cfg(test)]
pub(crate) mod synthetic;
pub(crate) mod tables;
pub(crate) mod variance;
pub(crate) mod wander;
pub(crate) mod whitening;
