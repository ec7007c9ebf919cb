//! Work that is done block by block of visits, in a fixed order.

use super::lineariser::Lineariser;
use crate::IdentifyError;
use rayon::prelude::*;
use std::ops::Range;
use truepose_errormodel::Visits;
use truepose_solvers::accumulator::Triangular;

/// Folds these visits into the triangular factor of `[A | r]`, over these columns.
///
/// # Errors
/// When the model and the data do not fit, or a number is not finite.
pub fn accumulate(
    mut lineariser: Lineariser<'_>,
    visits: &Visits,
    which: impl Iterator<Item = usize>,
) -> Result<Triangular, IdentifyError> {
    let mut factor = Triangular::new(lineariser.width() - 1, 1);
    for visit in which {
        factor.update_rows(lineariser.visit(&visits.rows[visit]).rows)?;
    }
    Ok(factor)
}

/// How many visits one block of work takes at the most: many, since rows of a kind are brought together within it.
const VISITS_PER_BLOCK: usize = 4096;
/// From so many visits times columns on there are two blocks at least: with fewer, bringing two triangles together costs what it gains,
/// and two sums of products next to nothing.
pub(super) const WORTH_TWO_TRIANGLES: usize = 150_000;
pub(super) const WORTH_TWO_SUMS: usize = 15_000;

/// Does one thing to every block of visits, in parallel; what comes of it is in their order. Blocks are a function of the
/// number of visits and columns alone, so that results do not depend on the number of threads, of which each block is told its share.
pub(super) fn by_blocks<T: Send>(
    visits: &Visits,
    columns: usize,
    worth_two: usize,
    work: impl Fn(Range<usize>, usize) -> Result<T, IdentifyError> + Sync,
) -> Result<Vec<T>, IdentifyError> {
    let count = visits.len();
    let two = count * columns >= worth_two;
    let length = if two { VISITS_PER_BLOCK.min(count.div_ceil(2)) } else { VISITS_PER_BLOCK };
    let blocks = count.div_ceil(length);
    let each = rayon::current_num_threads().div_ceil(blocks.max(1));
    (0..blocks)
        .into_par_iter()
        .map(|block| work(block * length..((block + 1) * length).min(count), each))
        .collect()
}
