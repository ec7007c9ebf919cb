//! The model as it stands during the search: fitted, refitted, validated.

pub(crate) mod admissible;
pub(crate) mod current;
pub(crate) mod installation;
pub(crate) mod nonlinear;
pub(crate) mod refits;
pub(crate) mod wide;
