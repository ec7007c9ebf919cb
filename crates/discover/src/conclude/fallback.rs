//! The enlarged model against the declared one, on data that the search has not seen.
//!
//! A search selects, and what was selected fits the rows that selected it. So before anything is written, the whole of what was found is held
//! against the declared model where no choice has looked:
//!
//! | check | rows | when |
//! | --- | --- | --- |
//! | [`Check::Refits`] | training rows, each predicted by a refit without its fold | the search had all training rows |
//! | [`Check::UnsearchedRows`] | training rows outside of the sample that was searched | the search had a sample |
//! | [`Check::NestedFolds`] | training rows, each predicted by a whole run of the loop without its fold | fewer than [`FEW`] poses |
//! | [`Check::TestSet`] | the held-out test set | the run drew it itself |
//!
//! A model that fails one of them is withdrawn as a whole: the declared model stands. Single effects were judged when they were added
//! ([`crate::model::refits`]). The last check makes a choice of two by the test set; its figure is the smaller of two, which is told.

use crate::accept::model::Model;
use crate::conclude::diagnosis::{Check, Diagnosis, Withdrawn};
use crate::conclude::whole::Whole;
use crate::data::payload::with_loads;
use crate::error::DiscoverError;
use crate::model::current::Ground;
use crate::model::refits::{Comparison, compared};
use crate::problem::linearisation::Scene;
use crate::problem::outliers::outliers;
use nalgebra::Vector3;
use truepose_errormodel::{Dataset, Visits, configurations};
use truepose_identify::{Fit, Folds, Residuals, Split};

/// With fewer training poses than this the loop itself is validated: a search that a handful of poses can lead astray has to be seen as a whole.
pub(crate) const FEW: usize = 100;
/// Folds of that validation.
const FOLDS: usize = 5;

/// Which checks a run makes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Checks {
    /// The test set is the run's own; in a validation from outside it has to stay unseen.
    pub test_set: bool,
    /// The loop is validated where poses are few.
    pub nested: bool,
}

impl Checks {
    /// Of a run that a user starts.
    pub const ALL: Checks = Checks { test_set: true, nested: true };
    /// Of a run whose test rows belong to a validation from outside.
    pub const UNSEEN: Checks = Checks { test_set: false, nested: true };
    /// Of a run inside such a run.
    const INNERMOST: Checks = Checks { test_set: false, nested: false };
}

/// Another run of the loop on other parts (training, test) of the training rows.
pub(crate) type Again<'a> =
    dyn Fn((Vec<usize>, Vec<usize>), Checks) -> Result<Diagnosis, DiscoverError> + Sync + 'a;

/// Holds what was found against the declared model and takes it back where it is worse; `train` are the training rows, with the residuals of
/// [`unsearched`] where only a sample of them was searched.
pub(crate) fn withdrawn(
    context: &Ground<'_>,
    model: &Model,
    whole: &Whole<'_>,
    (train, unsearched): (&Dataset, Option<[Residuals; 2]>),
    checks: Checks,
    again: &Again<'_>,
) -> Result<Option<Withdrawn>, DiscoverError> {
    if model.findings.is_empty() {
        return Ok(None);
    }
    let failed = match failed(context, model, whole, (train, unsearched), checks, again)? {
        Some(failed) => failed,
        None => return Ok(None),
    };
    let (check, declared, enlarged) = failed;
    let findings = model.findings.iter().map(|a| (a.candidate.clone(), a.evidence.clone())).collect();
    Ok(Some(Withdrawn { check, declared, enlarged, findings }))
}

/// (check, RMS of the declared model, RMS of the enlarged one).
type Failed = (Check, f64, f64);

fn failed(
    context: &Ground<'_>,
    model: &Model,
    whole: &Whole<'_>,
    (train, unsearched): (&Dataset, Option<[Residuals; 2]>),
    checks: Checks,
    again: &Again<'_>,
) -> Result<Option<Failed>, DiscoverError> {
    let noise = model.declared.fit.noise;
    let loss = |check: Check, pair: &[Residuals; 2], worse: &dyn Fn(Comparison) -> bool| {
        let compared = compared(&pair[0], &pair[1], noise)?;
        worse(compared).then(|| (check, rms(pair, 0), rms(pair, 1)))
    };
    let out = &model.current.outliers.suspects;
    let any_loss = |compared: Comparison| compared.deviation > 1.0;
    let (check, pair) = match unsearched {
        Some(pair) => (Check::UnsearchedRows, pair),
        None => (Check::Refits, model.both_refitted(context)?),
    };
    if let Some(failed) = loss(check, &blank(pair, out), &any_loss) {
        return Ok(Some(failed));
    }
    if checks.nested && Visits::of(train).len() < FEW {
        // A fold or two that find nothing leave both alike: no loss.
        let pair = nested(train, context.options.seed, again)?;
        if let Some(failed) = loss(Check::NestedFolds, &blank(pair, out), &any_loss) {
            return Ok(Some(failed));
        }
    }
    if checks.test_set {
        let held = whole.data.select(&whole.holdout_rows);
        let of = |fit: &Fit, held: &Dataset| Residuals::of(&fit.fitted, held);
        let out = gross(model, whole)?;
        let found = &model.current.found;
        let pair = [of(&model.declared.fit, &held)?, of(&model.current.fit, &with_loads(&held, found))?];
        if let Some(failed) = loss(Check::TestSet, &blank(pair, &out), &any_loss) {
            return Ok(Some(failed));
        }
    }
    Ok(None)
}

/// Both models, as the sample made them, on the training rows that are not in it; a row in the sample is blank.
pub(crate) fn unsearched(model: &Model, train: &Dataset, seed: u64) -> Result<[Residuals; 2], DiscoverError> {
    let sampled = crate::data::sample::sampled(train, seed);
    let rows: Vec<usize> = (0..train.len()).filter(|&row| sampled[row]).collect();
    let found = &model.current.found;
    let first = Residuals::of(&model.declared.fit.fitted, train)?;
    let now = Residuals::of(&model.current.fit.fitted, &with_loads(train, found))?;
    Ok(blank([first, now], &rows))
}

/// Both models on the training rows, each row by a run of the loop that has not seen it.
fn nested(train: &Dataset, seed: u64, again: &Again<'_>) -> Result<[Residuals; 2], DiscoverError> {
    let count = configurations(train).iter().max().map_or(0, |last| last + 1);
    let folds = Folds::new(train, &Split::Random { folds: FOLDS.min(count), seed })?;
    let nothing = Residuals {
        position: vec![Vector3::repeat(f64::NAN); train.len()],
        orientation: vec![None; train.len()],
    };
    let mut pair = [nothing.clone(), nothing];
    for fold in 0..folds.count {
        let rows: (Vec<usize>, Vec<usize>) =
            (0..train.len()).partition(|&row| folds.of_visit[train.visit[row]] != fold);
        let held = rows.1.clone();
        // Without a fold there may be too few poses for a search: then there is nothing to compare.
        let Ok(run) = again(rows, Checks::INNERMOST) else { continue };
        for (all, part) in pair.iter_mut().zip([&run.before.holdout, &run.after.holdout]) {
            for (k, &row) in held.iter().enumerate() {
                all.position[row] = part.position[k];
                all.orientation[row] = part.orientation[k];
            }
        }
    }
    Ok(pair)
}

/// Held-out rows, counted within the test set, that nothing explains: a gross error is neither model's.
fn gross(model: &Model, whole: &Whole<'_>) -> Result<Vec<usize>, DiscoverError> {
    let all = with_loads(whole.data, &model.current.found);
    let judged = Scene::new(&model.current.fit, &all)?;
    let residual = &judged.y - &judged.base * judged.coefficients();
    let suspects = outliers(&judged, residual.as_slice(), model.current.fit.noise).suspects;
    let held = whole.holdout_rows.iter().enumerate();
    Ok(held.filter(|(_, row)| suspects.contains(row)).map(|(k, _)| k).collect())
}

/// Residuals without those of some rows.
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
