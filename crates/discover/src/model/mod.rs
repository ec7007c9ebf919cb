//! The fit of a model during the search: fit, refits, nonlinear parameters, physical bounds.

pub(crate) mod admissible;
pub(crate) mod current;
pub(crate) mod first_side;
pub(crate) mod installation;
pub(crate) mod nonlinear;
pub(crate) mod prepared;
pub(crate) mod refits;
pub(crate) mod wide;
