//! The result: figures on data that no choice has seen, the final fit, the verdict.

pub(crate) mod diagnosis;
pub(crate) mod errors;
pub(crate) mod fallback;
pub(crate) mod final_fit;
pub(crate) mod floor;
pub(crate) mod interim;
pub(crate) mod linear;
pub(crate) mod report;
pub(crate) mod trace;
pub(crate) mod trial;
pub(crate) mod whole;
