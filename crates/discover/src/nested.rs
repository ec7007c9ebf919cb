//! How good the loop is where it has seen nothing: the whole of it inside each fold.
//!
//! Selecting effects on all data and cross-validating only their coefficients flatters: what was selected by chance fits the
//! held-out rows as well. Here each fold is left out before anything is looked at, and predicted by whatever the loop
//! finds on the others.

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

/// The loop judged on every row by a run that did not see it.
#[derive(Debug, Clone)]
pub struct Nested {
    /// With the declared model, m.
    pub before: Spread,
    /// With what each run found, m.
    pub after: Spread,
    /// Each fold's run.
    pub runs: Vec<Diagnosis>,
}

/// Runs the whole loop once a fold.
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
    let data = &derived::with_derived(data);
    let folds = Folds::new(data, split)?;
    // Side by side: each run is a function of its fold alone.
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
