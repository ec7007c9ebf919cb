//! The largest scores of a screen, with the columns of all rows.
//!
//! Where a function is small in all rows of the sample but not in all, as that of a load that is rarely carried, the sample says too little of
//! its length, and its score comes out too large.

use crate::census::all_rows::AllRows;
use crate::census::blocks::Blocks;
use crate::census::details::Detail;
use crate::census::sums::sums;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::options::DiscoverOptions;
use crate::screen::candidates::Screen;
use crate::significance::rotation::NullDistribution;

/// Candidates whose columns are taken at most.
const MOST: usize = 288;

/// Puts exact gains in the place of those that are significant, the largest first.
pub(crate) fn confirmed(
    screen: &mut Screen,
    null: &NullDistribution,
    (all, blocks): (&AllRows, &Blocks),
    options: &DiscoverOptions,
) -> Result<(), DiscoverError> {
    let mut open: Vec<(usize, f64)> = screen
        .candidates
        .iter()
        .enumerate()
        .filter(|(_, screened)| matches!(screened.candidate.change, Change::Add(_)))
        .filter_map(|(k, screened)| Some((k, screened.score.as_ref()?.surprisal)))
        .filter(|(_, surprisal)| null.p_value(*surprisal) <= options.alpha)
        .collect();
    open.sort_by(|a, b| b.1.total_cmp(&a.1));
    // What is not looked at closely does not count.
    for &(k, _) in open.iter().skip(MOST) {
        if let Some(score) = &mut screen.candidates[k].score {
            (score.gain, score.surprisal) = (0.0, 0.0);
        }
    }
    open.truncate(MOST);
    if open.is_empty() {
        return Ok(());
    }
    let which: Vec<Candidate> = open.iter().map(|&(k, _)| screen.candidates[k].candidate.clone()).collect();
    for (&(k, _), sums) in open.iter().zip(sums(&which, (all, blocks), 1, options)?) {
        let detail = sums.and_then(|sums| Detail::of(&sums, all, 1, &options.policy));
        if let Some(score) = &mut screen.candidates[k].score {
            (score.gain, score.surprisal) = detail.map_or((0.0, 0.0), |d| (d.gain, d.surprisal));
        }
    }
    Ok(())
}
