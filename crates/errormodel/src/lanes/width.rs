//! The size of a block.

/// How many rows a block has at most.
pub const LANES: usize = 128;
