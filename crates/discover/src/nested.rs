//! Nested cross-validation: the whole search inside each fold.
//!
//! Cross-validation of the coefficients alone, with effects that were selected on all data, is optimistically
//! biased. Here each fold is left out before anything is fitted, and is predicted by the model that the
//! search finds on the other folds (Stone 1974; Varma and Simon 2006).

use crate::conclude::diagnosis::Diagnosis;
use crate::conclude::fallback::Checks;
use crate::data::derived;
use crate::diagnose::on_split;
use crate::error::DiscoverError;
use crate::options::DiscoverOptions;
use crate::progress::Progress;
use rayon::prelude::*;
use truepose_errormodel::{AnyEffect, Dataset};
use truepose_identify::{Answer, Folds, Residuals, Split, Spread, proceed};
use truepose_kinematics::Chain;
use truepose_solvers::Solver;

/// Errors of every row, predicted by a run of the search without its fold.
#[derive(Debug, Clone)]
pub struct Nested {
    /// 3-D position error of the declared model, m.
    pub before: Spread,
    /// 3-D position error of the model of each run, m.
    pub after: Spread,
    /// The run of each fold.
    pub runs: Vec<Diagnosis>,
}

/// Runs the whole search once for each fold of `split`. `progress` gets the number of the fold, from zero,
/// and is called from several threads.
///
/// # Errors
/// As [`crate::diagnose`]; when there are too few configurations for the folds.
pub fn nested<A: Answer>(
    chain: &Chain,
    declared: &[Box<dyn AnyEffect>],
    data: &Dataset,
    split: &Split,
    solver: &dyn Solver,
    options: &DiscoverOptions,
    observer: &(dyn Fn(usize, Progress) -> A + Sync),
) -> Result<Nested, DiscoverError> {
    options.validate()?;
    let data = &derived::with_derived(data, &options.policy);
    let folds = Folds::new(data, split)?;
    // In parallel: each run is a function of its fold alone.
    let runs: Vec<Diagnosis> = (0..folds.count)
        .into_par_iter()
        .map(|fold| {
            let rows = (0..data.len()).partition(|&row| folds.of_visit[data.visit[row]] != fold);
            let step = |step| Ok(proceed(observer(fold, step))?);
            on_split(chain, declared, (data, rows), solver, options, Checks::UNSEEN, &step)
        })
        .collect::<Result<_, _>>()?;
    let distances = |r: &Residuals| (0..r.position.len()).filter_map(|k| r.distance(k)).collect::<Vec<_>>();
    let before: Vec<f64> = runs.iter().flat_map(|run| distances(&run.before.holdout)).collect();
    let after: Vec<f64> = runs.iter().flat_map(|run| distances(&run.after.holdout)).collect();
    Ok(Nested { before: Spread::of(before.into_iter()), after: Spread::of(after.into_iter()), runs })
}
