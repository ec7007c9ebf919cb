//! Much data is searched on a sample: what is found there is fitted to everything at the end.
//!
//! A cause that matters shows in a few thousand numbers.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use std::borrow::Cow;
use truepose_errormodel::{Dataset, Visits};

/// Rows that are searched at once.
const ROWS: usize = 1000;

/// The data, or whole visits of it, in their order.
pub(crate) fn sample(data: &Dataset, seed: u64) -> Cow<'_, Dataset> {
    if data.len() <= ROWS + ROWS / 4 {
        return Cow::Borrowed(data);
    }
    let taken = sampled(data, seed);
    let rows: Vec<usize> = (0..data.len()).filter(|&row| taken[row]).collect();
    Cow::Owned(data.select(&rows))
}

/// Which rows are in the sample.
pub(crate) fn sampled(data: &Dataset, seed: u64) -> Vec<bool> {
    if data.len() <= ROWS + ROWS / 4 {
        return vec![true; data.len()];
    }
    let visits = Visits::of(data);
    let mut order: Vec<usize> = (0..visits.len()).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed ^ 0x5a3f_1e77));
    let mut taken = vec![false; visits.len()];
    let mut rows = 0;
    for visit in order {
        if rows >= ROWS {
            break;
        }
        taken[visit] = true;
        rows += visits.rows[visit].len();
    }
    (0..data.len()).map(|row| taken[data.visit[row]]).collect()
}
