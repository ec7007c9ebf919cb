//! The scores of a screen that something rests on, with the columns of all rows.
//!
//! Where a function is small in all rows of the sample but not in all, as that of a load that is rarely carried, the sample says too little of
//! its length, and its score comes out too large. (Where the sample has more of it than all rows have, too small: a cause that is not among the best for that
//! stays where it is.) First come those that would be compared next, then those that take the place of others that fell, until none does; each further pass
//! takes twice as many causes.

use crate::census::all_rows::AllRows;
use crate::census::blocks::Blocks;
use crate::census::details::Detail;
use crate::census::sums::sums;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::options::DiscoverOptions;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;
use crate::significance::rotation::NullDistribution;
use std::collections::BTreeSet;

/// Candidates whose columns are taken at most.
const MOST: usize = 288;

/// Puts exact gains in the place of those that are significant, of the causes that may be compared and of the smallest p.
pub(crate) fn confirmed(
    (screen, linearisation): (&mut Screen, &Linearisation<'_>),
    null: &NullDistribution,
    (all, blocks): (&AllRows, &Blocks),
    options: &DiscoverOptions,
) -> Result<(), DiscoverError> {
    let mut open: Vec<usize> = (0..screen.candidates.len())
        .filter(|&k| matches!(screen.candidates[k].candidate.change, Change::Add(_)))
        .filter(|&k| surprisal(screen, k).is_some_and(|surprisal| null.p_value(surprisal) <= options.alpha))
        .collect();
    let mut room = MOST;
    let most = options.budget.causes + options.budget.contests.saturating_sub(1);
    let mut taken = most;
    loop {
        if asked_for(screen, linearisation, &open, most).is_empty() {
            return Ok(());
        }
        let mut next = asked_for(screen, linearisation, &open, taken);
        taken *= 2;
        next.sort_by(|&a, &b| {
            surprisal(screen, b).unwrap_or(0.0).total_cmp(&surprisal(screen, a).unwrap_or(0.0))
        });
        // What is not looked at closely does not count.
        for k in next.split_off(room.min(next.len())) {
            put(screen, k, None);
            open.retain(|&other| other != k);
        }
        room -= next.len();
        let which: Vec<Candidate> = next.iter().map(|&k| (*screen.candidates[k].candidate).clone()).collect();
        for (&k, sums) in next.iter().zip(sums(&which, (all, blocks), 1, options)?) {
            put(screen, k, sums.and_then(|sums| Detail::of(&sums, all, 1, &options.policy)).as_ref());
        }
        open.retain(|k| !next.contains(k));
    }
}

fn surprisal(screen: &Screen, candidate: usize) -> Option<f64> {
    screen.candidates[candidate].score.as_ref().map(|score| score.surprisal)
}

fn put(screen: &mut Screen, candidate: usize, detail: Option<&Detail>) {
    if let Some(score) = &mut screen.candidates[candidate].score {
        (score.gain, score.surprisal) = detail.map_or((0.0, 0.0), |detail| (detail.gain, detail.surprisal));
    }
}

/// Those of the open candidates that are variants of one of the `best` causes, or have the smallest p.
fn asked_for(screen: &Screen, linearisation: &Linearisation<'_>, open: &[usize], best: usize) -> Vec<usize> {
    let leading: BTreeSet<String> =
        screen.causes(linearisation).iter().take(best).map(|cause| cause.variants[0].0.words()).collect();
    let largest = screen.largest();
    let wanted = |k: usize| {
        surprisal(screen, k) == Some(largest) || leading.contains(&screen.candidates[k].candidate.words())
    };
    open.iter().copied().filter(|&k| wanted(k)).collect()
}
