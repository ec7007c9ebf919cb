//! The data linearised at a fit, and a candidate beside the model of that fit.

pub(crate) mod likelihood;
pub(crate) mod linearisation;
pub(crate) mod normal;
pub(crate) mod observation;
pub(crate) mod outliers;
pub(crate) mod projection;
pub(crate) mod tables;
pub(crate) mod whitening;
