//! Nested cross-validation: the whole search inside each fold.
//!
//! Cross-validation of the coefficients alone, with effects that were selected on all data, is optimistically
//! biased. Here each fold is left out before anything is fitted, and is predicted by the model that the
//! search finds on the other folds (Stone 1974; Varma and Simon 2006).

use crate::conclude::cross_validated::CrossValidated;
use crate::conclude::diagnosis::Diagnosis;
use crate::conclude::errors::Errors;
use crate::conclude::fallback::Checks;
use crate::conclude::held_out::{HeldOutIntervals, clusters};
use crate::data::derived;
use crate::diagnose::on_split;
use crate::error::DiscoverError;
use crate::options::DiscoverOptions;
use crate::problem::dependence::Dependence;
use crate::progress::Progress;
use nalgebra::Vector3;
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
    /// Their intervals and that of the gain, on rows that no decision has seen; `None` of too few configurations.
    pub intervals: Option<HeldOutIntervals>,
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
    let data = &derived::with_derived(data, declared, &options.policy);
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
    let merged = |which: fn(&Diagnosis) -> &Errors| {
        let mut all = Residuals {
            position: vec![Vector3::repeat(f64::NAN); data.len()],
            orientation: vec![None; data.len()],
        };
        for run in &runs {
            let rows = run.holdout_rows.iter().zip(&which(run).holdout.position);
            rows.for_each(|(&row, residual)| all.position[row] = *residual);
        }
        Errors { holdout: all, ..Errors::default() }
    };
    let (before, after) = (merged(|run| &run.before), merged(|run| &run.after));
    // The one that most runs would report.
    let mut each: Vec<&Dependence> = runs.iter().filter_map(|run| run.dependence.as_ref()).collect();
    each.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    let dependence = each.get(runs.len() / 2).copied();
    // Of the fold whose final model has the most unknowns: none of them is the fit to all rows.
    let largest = runs.iter().max_by_key(|run| run.fit.reduction.rank());
    let judged = largest.map(|run| CrossValidated::of([&run.declared, &run.fit], folds.count));
    let (draws, seed) = (options.budget.bootstrap, options.seed);
    let intervals = HeldOutIntervals::of([&before, &after], &clusters(data, dependence), judged, draws, seed);
    Ok(Nested { before: before.holdout.positions(), after: after.holdout.positions(), intervals, runs })
}
