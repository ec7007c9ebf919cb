//! The design matrix, whitened: visit by visit, in blocks of rows, and what accumulators make of it.

mod accumulate;
mod blocks;
mod lineariser;
mod misfit;
mod rows;
mod stations;
mod sums;

pub use accumulate::accumulate;
pub use blocks::{Batch, Blocks, batches};
pub(crate) use lineariser::stand;
pub use lineariser::{Block, Lineariser};
pub(crate) use misfit::misfit;
pub(crate) use rows::left_over_rows;
pub use rows::{ByVisits, Rows, by_visits, collect};
pub(crate) use stations::Stations;
pub use sums::{dense, factorise, gram, left_out, left_over, refined, triangular, triangular_of};

#[cfg(test)]
mod tests;
