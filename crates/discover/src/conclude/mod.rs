//! The result: errors on held-out data, the final fit, the verdict.

pub(crate) mod cross_validated;
pub(crate) mod diagnosis;
pub(crate) mod errors;
pub(crate) mod extrapolation;
pub(crate) mod fallback;
pub(crate) mod final_fit;
pub(crate) mod floor;
pub(crate) mod fold_run;
pub(crate) mod held_out;
pub(crate) mod interim;
pub(crate) mod outside;
pub(crate) mod partition;
pub(crate) mod reach;
pub(crate) mod report;
pub(crate) mod stated;
pub(crate) mod trace;
pub(crate) mod trial;
pub(crate) mod verdict;
