//! Fallback: the enlarged model is compared with the declared one on data that the search has not used.
//!
//! Selection is biased towards the rows that were used for it. Before a model is written, all findings
//! together are compared with the declared model on other rows:
//!
//! | check | rows | when |
//! | --- | --- | --- |
//! | [`Check::Refits`] | training rows, each predicted by a refit without its fold | the search had all training rows |
//! | [`Check::UnsearchedRows`] | training rows outside of the sample that was searched | the search had a sample |
//! | [`Check::NestedFolds`] | training rows, each predicted by a whole run of the loop without its fold | fewer than [`crate::Policy::few_poses`] |
//! | [`Check::TestSet`] | the held-out test set | the run drew one itself |
//!
//! A check fails when Σ ‖e/σ‖² of the enlarged model is larger. Then all findings are withdrawn and the
//! declared model is the result. Single effects were tested when they were added ([`crate::model::refits`]).
//! The last check selects one of two models by the test set, so that its error is the smaller of two; the
//! report says so.

use crate::accept::model::Model;
use crate::conclude::diagnosis::{Check, Diagnosis, Withdrawn};
use crate::conclude::fold_run::FoldRun;
use crate::conclude::partition::{HeldOut, Partition, by_folds};
use crate::error::DiscoverError;
use crate::model::current::Context;
use crate::model::prepared::with_found;
use crate::model::refits::{Comparison, compared};
use crate::options::{DiscoverOptions, FEWEST_ROTATIONS};
use crate::problem::linearisation::Linearisation;
use crate::problem::outliers::outliers;
use nalgebra::Vector3;
use rayon::prelude::*;
use truepose_errormodel::{Dataset, Visits};
use truepose_identify::{Fit, Residuals};

/// Which checks a run makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Checks {
    /// All of them: a run of its own.
    All,
    /// Refits alone: a run without a fold of a cross-validation. The fold belongs to the cross-validation and stays unused, and the search is
    /// not cross-validated again.
    OfFold,
}

/// The options of a run without a fold: fewer rotations, since only the side of α on which p lies matters ([`crate::screen::multiplicity`]).
pub(crate) fn of_fold(options: &DiscoverOptions) -> DiscoverOptions {
    DiscoverOptions { rotations: FEWEST_ROTATIONS.min(options.rotations), ..options.clone() }
}

/// Residuals of the declared and of the enlarged model on rows that the fitted coefficients, or the whole search, have not seen.
pub(crate) struct Unseen {
    /// Those of [`unsearched`], where only a sample of the rows was searched.
    pub unsearched: Option<[Residuals; 2]>,
    /// Those of [`nested`], where poses are few.
    pub nested: Option<Folded>,
    /// Those of all held-out rows, where the data of the run is a part of them.
    pub held: Option<[Residuals; 2]>,
}

/// The residuals of both models on the training rows, by whole runs without each fold, with these runs; none where the model has no findings,
/// or where a fold could not be searched.
pub(crate) struct Folded {
    pub pair: [Residuals; 2],
    pub runs: Vec<FoldRun>,
}

/// Runs the search on another partition (training, test) of the training rows.
pub(crate) type Again<'a> = dyn Fn((Vec<usize>, Vec<usize>)) -> Result<Diagnosis, DiscoverError> + Sync + 'a;

/// Compares the model with the declared one; returns the findings with the failed check when they have to be
/// withdrawn.
pub(crate) fn withdrawn(
    context: &Context<'_>,
    model: &Model,
    partition: &Partition<'_>,
    unseen: &Unseen,
    checks: Checks,
) -> Result<Option<Withdrawn>, DiscoverError> {
    if model.findings.is_empty() {
        return Ok(None);
    }
    let noise = model.declared.fit.noise;
    let loss = |check: Check, pair: &[Residuals; 2], worse: &dyn Fn(Comparison) -> bool| {
        let compared = compared(&pair[0], &pair[1], noise)?;
        let findings = || model.findings.iter().map(|a| (a.candidate.clone(), a.evidence.clone())).collect();
        worse(compared).then(|| Withdrawn {
            check,
            declared: rms(pair, 0),
            enlarged: rms(pair, 1),
            findings: findings(),
        })
    };
    let out = &model.current.outliers.suspects;
    let any_loss = |compared: Comparison| compared.deviation > 1.0;
    let (check, pair) = match &unseen.unsearched {
        Some(pair) => (Check::UnsearchedRows, pair.clone()),
        None => (Check::Refits, model.both_refitted(context)?),
    };
    if let Some(failed) = loss(check, &blank(pair, out), &any_loss) {
        return Ok(Some(failed));
    }
    if let Some(Folded { pair, .. }) = &unseen.nested
        && let Some(failed) = loss(Check::NestedFolds, &blank(pair.clone(), out), &any_loss)
    {
        return Ok(Some(failed));
    }
    if checks == Checks::All && partition.held_out == HeldOut::TestSet {
        let pair = match &unseen.held {
            Some(pair) => pair.clone(),
            None => {
                let held = partition.data.select(&partition.holdout_rows);
                let of = |fit: &Fit, held: &Dataset| Residuals::of(&fit.fitted, held);
                let found = &model.current.found;
                let pair =
                    [of(&model.declared.fit, &held)?, of(&model.current.fit, &with_found(&held, found))?];
                blank(pair, &gross(context, model, partition)?)
            }
        };
        if let Some(failed) = loss(Check::TestSet, &pair, &any_loss) {
            return Ok(Some(failed));
        }
    }
    Ok(None)
}

/// Residuals of the declared and of the enlarged model, fitted to the sample, on the training rows outside of
/// it; NaN in rows of the sample.
pub(crate) fn unsearched(
    context: &Context<'_>,
    model: &Model,
    train: &Dataset,
) -> Result<[Residuals; 2], DiscoverError> {
    let sampled = crate::data::sample::sampled(train, context.options.seed, context.budget().sample_rows);
    let rows: Vec<usize> = (0..train.len()).filter(|&row| sampled[row]).collect();
    let found = &model.current.found;
    let first = Residuals::of(&model.declared.fit.fitted, train)?;
    let current = Residuals::of(&model.current.fit.fitted, &with_found(train, found))?;
    Ok(blank([first, current], &rows))
}

/// Residuals of the declared and of the enlarged model on the training rows, each row by a run of the search
/// without its fold; `None` where neither the checks nor the held-out errors need them. Without findings both are those of the declared
/// model, by refits.
pub(crate) fn nested(
    context: &Context<'_>,
    model: &Model,
    (partition, train): (&Partition<'_>, &Dataset),
    checks: Checks,
    again: &Again<'_>,
) -> Result<Option<Folded>, DiscoverError> {
    let (policy, poses) = (context.policy(), Visits::of(train).len());
    let wanted =
        partition.held_out == HeldOut::NestedFolds || (checks == Checks::All && poses < policy.few_poses);
    if !wanted {
        return Ok(None);
    }
    if model.findings.is_empty() {
        let refits = partition.held_out == HeldOut::NestedFolds;
        return Ok(refits.then_some(Folded { pair: model.both_refitted(context)?, runs: Vec::new() }));
    }
    let nothing = Residuals {
        position: vec![Vector3::repeat(f64::NAN); train.len()],
        orientation: vec![None; train.len()],
    };
    let mut pair = [nothing.clone(), nothing];
    let folds = context.budget().nested_folds * if poses < policy.small_campaign { 2 } else { 1 };
    let runs: Vec<(Vec<usize>, Result<Diagnosis, DiscoverError>)> =
        by_folds(train, folds, context.options.seed)?
            .into_par_iter()
            .map(|(kept, held)| (held.clone(), again((kept, held))))
            .collect();
    // Without a fold there may be too few poses for a search, or for a fit: then its rows are not compared.
    if runs.iter().all(|(_, run)| run.is_err())
        && let Some((_, Err(error))) = runs.first()
    {
        return Err(error.clone());
    }
    let (count, mut fold_runs) = (runs.len(), Vec::new());
    for (fold, (held, run)) in runs.into_iter().enumerate() {
        // In a fold without findings both models are equal.
        let Ok(run) = run else { continue };
        fold_runs.push(FoldRun::of((fold, count), &run, train));
        for (all, part) in pair.iter_mut().zip([&run.before.holdout, &run.after.holdout]) {
            for (k, &row) in held.iter().enumerate() {
                all.position[row] = part.position[k];
                all.orientation[row] = part.orientation[k];
            }
        }
    }
    if fold_runs.len() < count {
        fold_runs.clear();
    }
    Ok(Some(Folded { pair, runs: fold_runs }))
}

/// Outliers of the test set, as indices into it: gross errors decide for neither model.
fn gross(
    context: &Context<'_>,
    model: &Model,
    partition: &Partition<'_>,
) -> Result<Vec<usize>, DiscoverError> {
    let all = with_found(partition.data, &model.current.found);
    let judged = Linearisation::new(&model.current.fit, &all, context.options)?;
    let residual = &judged.y - &judged.base * judged.coefficients();
    let suspects = outliers(&judged, residual.as_slice(), model.current.fit.noise).suspects;
    let held = partition.holdout_rows.iter().enumerate();
    Ok(held.filter(|(_, row)| suspects.contains(row)).map(|(k, _)| k).collect())
}

/// The residuals with NaN in these rows.
fn blank(mut pair: [Residuals; 2], rows: &[usize]) -> [Residuals; 2] {
    for residuals in &mut pair {
        let count = residuals.position.len();
        for &row in rows.iter().filter(|&&row| row < count) {
            residuals.position[row] = Vector3::repeat(f64::NAN);
            residuals.orientation[row] = None;
        }
    }
    pair
}

/// 3-D RMS of one of two models over the rows that both predict, m.
fn rms(pair: &[Residuals; 2], which: usize) -> f64 {
    let rows = 0..pair[0].position.len();
    let both = rows.filter(|&row| pair.iter().all(|r| r.distance(row).is_some()));
    pair[which].positions_of(&both.collect::<Vec<_>>()).rms
}
