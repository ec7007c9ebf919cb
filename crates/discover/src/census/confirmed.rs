//! The largest scores of a screen, with the columns of all rows.
//!
//! Where a function is small in all rows of the sample but not in all, as that of a load that is rarely carried, the sample says too little of
//! its length, and its score comes out too large.

use crate::census::all_rows::AllRows;
use crate::census::blocks::Blocks;
use crate::census::details::Detail;
use crate::census::scores::sums;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::options::DiscoverOptions;
use crate::screen::candidates::Screen;
use crate::significance::rotation::NullDistribution;

/// Candidates whose columns are taken in one pass.
const AT_ONCE: usize = 48;
/// Passes.
const PASSES: usize = 6;

/// Puts exact gains in the place of those that are significant, the largest first, until the largest is exact.
pub(crate) fn confirmed(
    screen: &mut Screen,
    null: &NullDistribution,
    (all, blocks): (&AllRows, &Blocks),
    options: &DiscoverOptions,
) -> Result<(), DiscoverError> {
    let mut exact = vec![false; screen.candidates.len()];
    for _ in 0..PASSES {
        let mut open: Vec<(usize, f64)> = screen
            .candidates
            .iter()
            .enumerate()
            .filter(|(k, screened)| !exact[*k] && matches!(screened.candidate.change, Change::Add(_)))
            .filter_map(|(k, screened)| Some((k, screened.score.as_ref()?.surprisal)))
            .filter(|(_, surprisal)| null.p_value(*surprisal) <= options.alpha)
            .collect();
        open.sort_by(|a, b| b.1.total_cmp(&a.1));
        open.truncate(AT_ONCE);
        if open.is_empty() {
            return Ok(());
        }
        let which: Vec<Candidate> =
            open.iter().map(|&(k, _)| screen.candidates[k].candidate.clone()).collect();
        for (&(k, _), sums) in open.iter().zip(sums(&which, (all, blocks), 1, options)?) {
            exact[k] = true;
            let detail = sums.and_then(|sums| Detail::of(&sums, all, 1, &options.policy));
            if let Some(score) = &mut screen.candidates[k].score {
                (score.gain, score.surprisal) = detail.map_or((0.0, 0.0), |d| (d.gain, d.surprisal));
            }
        }
    }
    // More than that are significant: what is not looked at closely does not count.
    for (screened, exact) in screen.candidates.iter_mut().zip(exact) {
        if let Some(score) =
            screened.score.as_mut().filter(|score| !exact && null.p_value(score.surprisal) <= options.alpha)
        {
            (score.gain, score.surprisal) = (0.0, 0.0);
        }
    }
    Ok(())
}
