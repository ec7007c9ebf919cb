//! Distributions and linear algebra that know nothing of robots.

pub(crate) mod beta;
pub(crate) mod bootstrap;
pub(crate) mod chi_square;
pub(crate) mod coefficients;
pub(crate) mod gross;
pub(crate) mod paired;
pub(crate) mod product;
pub(crate) mod triangular;
