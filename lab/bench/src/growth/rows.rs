//! Points of the paper's robot in blocks.

use crate::prelude::*;
use truepose_identify::{IdentifyError, Source};
use truepose_micro::points;

/// Rows of a block, and how many different blocks there are.
const BLOCK: usize = 16_384;
const DIFFERENT: usize = 16;

/// Blocks of rows, the same ones again and again.
pub struct Blocks<'a> {
    chain: &'a Chain,
    blocks: Vec<Dataset>,
    /// How many rows are handed out.
    pub rows: usize,
}

impl<'a> Blocks<'a> {
    /// Nothing is made before it is asked for.
    pub fn new(chain: &'a Chain) -> Self {
        Blocks { chain, blocks: Vec::new(), rows: 0 }
    }
}

impl Source for Blocks<'_> {
    type Error = Failure;

    fn sample(&mut self, rows: usize) -> Outcome<Dataset> {
        Ok(points(self.chain, 0, rows.min(self.rows)))
    }

    fn each(&mut self, take: &mut dyn FnMut(&Dataset) -> Result<(), IdentifyError>) -> Outcome {
        let mut left = self.rows;
        let mut k = 0;
        while left > 0 {
            if k % DIFFERENT >= self.blocks.len() {
                self.blocks.push(points(self.chain, k * BLOCK, BLOCK));
            }
            let block = &self.blocks[k % DIFFERENT];
            match left < BLOCK {
                true => take(&block.select(&(0..left).collect::<Vec<_>>()))?,
                false => take(block)?,
            }
            left = left.saturating_sub(BLOCK);
            k += 1;
        }
        Ok(())
    }
}
