//! The result of a search: errors on the held-out test set, competing hypotheses, and the final fit of all
//! rows.

use crate::accept::accepted::Accepted;
use crate::accept::outcome::Outcome;
use crate::conclude::cross_validated::CrossValidated;
use crate::conclude::diagnosis::{Alternative, CompetingFit, Diagnosis, Finding, Parameter, Withdrawn};
use crate::conclude::errors::{Errors, with_missing};
use crate::conclude::extrapolation::extrapolations;
use crate::conclude::fallback::Folded;
use crate::conclude::final_fit::{DeclaredFit, Final, enlarged, training};
use crate::conclude::floor::NoiseFloor;
use crate::conclude::held_out::{HeldOutIntervals, clusters};
use crate::conclude::outside::outlier_finding;
use crate::conclude::partition::{HeldOut, Partition};
use crate::conclude::reach::fallback;
use crate::conclude::trace::trace;
use crate::conclude::trial::Trial;
use crate::conclude::verdict::{Doubts, Variances, verdict};
use crate::contest::names::{NameProbabilities, name_probabilities};
use crate::data::{derived, payload};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::model::current::Context;
use crate::model::prepared::{with_found, without};
use crate::problem::dependence::dependence;
use crate::problem::linearisation::Linearisation;
use crate::problem::observation::typical_sd;
use crate::screen::untestable::Untestable;
use crate::termination::Termination;
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;
use truepose_errormodel::{Dataset, Domain, LoadCorrection, Sample, Visits};
use truepose_identify::{
    Fit, FittedNonlinear, ResidualVariance, Residuals, fit_again, repeats, student_quantile,
};

/// Forms the result.
pub(crate) fn conclude(
    context: &Context<'_>,
    outcome: Outcome,
    partition: Partition<'_>,
    (withdrawn, nested): (Option<Withdrawn>, Option<Folded>),
    declared_fit: &DeclaredFit<'_>,
) -> Result<Diagnosis, DiscoverError> {
    let held = partition.data.select(&partition.holdout_rows);
    let wanted = context.options.competing_fits;
    let Outcome { model, refused, untestable, last, stopped, joints } = outcome;
    let (mut accepted, current) = (model.findings.clone(), Arc::clone(&model.current));
    for finding in &mut accepted {
        // Periods that were added, and a place that moved, make an earlier competing hypothesis the finding itself.
        let own = finding.candidate.words();
        finding.competitors.retain(|(other, _)| other.words() != own);
    }
    let found: Vec<Candidate> = accepted.iter().map(|a| a.candidate.clone()).collect();
    let declared = match found.is_empty() {
        true => current.fit.clone(),
        false => context.fitted(&[], &context.prepared(&[], &current.outliers.suspects))?,
    };
    let mut before = errors(&declared, context.data, &held)?;
    let mut after = errors(&current.fit, &with_found(context.data, &found), &with_found(&held, &found))?;
    let (pair, fold_runs) = nested.map_or((None, Vec::new()), |folded| (Some(folded.pair), folded.runs));
    if partition.held_out == HeldOut::NestedFolds {
        let [declared, enlarged] = match pair {
            Some(pair) => pair,
            None => model.both_refitted(context)?,
        };
        let enlarged = if found.is_empty() { declared.clone() } else { enlarged };
        // Rows that no fit uses are unseen by all of them.
        let suspects = &current.outliers.suspects;
        before.holdout = with_missing(declared, &before.holdout, suspects);
        after.holdout = with_missing(enlarged, &after.holdout, suspects);
    }

    let all = with_found(partition.data, &found);
    let judged = Linearisation::new(&current.fit, &all, context.options)?;
    let trial = Trial::new(context, &current, &found, &judged, &partition)?;
    // Errors with the first findings only, on the same training rows. In nested folds other searches may have found other effects: their
    // error is that of the whole search, and no step of one finding.
    let last_step =
        if partition.held_out == HeldOut::NestedFolds { found.len() } else { found.len().max(1) - 1 };
    let between: Vec<_> =
        (1..=last_step).into_par_iter().map(|count| trial.first(count)).collect::<Result<_, _>>()?;
    let steps: Vec<_> = [before.rms()].into_iter().chain(between).chain([after.rms()]).collect();

    let Final { fit, found, data, outside } = match (declared_fit.full_report, found.is_empty()) {
        (true, true) => declared_fit.fit(context, &current, &all)?,
        (true, false) => enlarged(context, &current, &found, &all)?,
        (false, _) => training(context, &current, &found, &all)?,
    };
    let (mut fit, mut outside) = (fit, outside);
    let together = outside.together(partition.data, context.policy());
    at_run_time(&mut fit, &found, partition.data);

    let mut findings = Vec::new();
    for (k, accepted) in accepted.iter().enumerate() {
        let effects = context.effects_of(&found, k);
        let names = name_probabilities(
            (&found[k], accepted.evidence.p_surrogates),
            &accepted.competitors,
            context.policy(),
        );
        findings.push(Finding {
            parameters: parameters(&fit, &found[k], effects.clone()),
            shape: shape(&fit, &effects),
            rows: match accepted.candidate.change {
                Change::CorrectLoad { level, during, .. } => {
                    payload::rows_at(partition.data, (level, during))
                }
                Change::Add(_) | Change::Exclude { .. } => Vec::new(),
            },
            poses: Vec::new(),
            candidate: found[k].clone(),
            p_value: accepted.evidence.p_value,
            name_probability: names.own,
            unnamed_probability: names.unnamed,
            evidence: Some(accepted.evidence.clone()),
            train: (steps[k].0, steps[k + 1].0),
            holdout: (steps[k].1, steps[k + 1].1),
            alternatives: match declared_fit.full_report {
                true => alternatives(context, &trial, (k, &names), accepted)?,
                false => Vec::new(),
            },
            trace: match declared_fit.full_report {
                true => trace(&fit, &data, &found[k], effects.start)?,
                false => None,
            },
        });
    }
    let competitors = if wanted {
        competing_fits(context, &trial, &accepted, &outside.suspects, partition.data)?
    } else {
        Vec::new()
    };
    let within = |part: &[usize]| -> Vec<usize> {
        (0..part.len()).filter(|&k| outside.suspects.contains(&part[k])).collect()
    };
    before.outliers = [within(&partition.train_rows), within(&partition.holdout_rows)];
    after.outliers.clone_from(&before.outliers);
    if !outside.certain.is_empty() {
        let judged = Residuals::of(&fit.fitted, partition.data)?;
        let good: Vec<usize> =
            (0..judged.position.len()).filter(|row| !outside.certain.contains(row)).collect();
        let all: Vec<usize> = (0..judged.position.len()).collect();
        let rms = (judged.positions_of(&all).rms, judged.positions_of(&good).rms);
        let held = after.holdout.positions().rms;
        let visits = Visits::of(partition.data);
        findings.push(outlier_finding((&outside, together.as_ref()), &visits, rms, (held, held)));
    }
    let stopped = if withdrawn.is_some() { Termination::Withdrawn } else { stopped };
    let trusted = partition.stated_scale.is_one();
    let variances = Variances {
        before: ResidualVariance::of(&declared, &context.prepared(&[], &current.outliers.suspects)),
        after: match &joints {
            None => ResidualVariance::of(&current.fit, &current.data),
            Some(joints) => {
                let weights =
                    joints.weights(&Linearisation::new(&current.fit, &current.data, context.options)?);
                ResidualVariance::of(&weighed(&current.fit, &weights), &current.data)
            }
        },
    };
    let weights = match &joints {
        None => None,
        Some(joints) => Some(joints.weights(&Linearisation::new(&fit, &data, context.options)?)),
    };
    // Repeats of the test set count as well: what poses of one configuration scatter by is no matter of the model.
    let left = variances.after.as_ref();
    let noise_floor =
        NoiseFloor::of(&fit.fitted, (&data, weights.as_deref()), left, trusted, context.policy())?;
    let last = (last.p_value, last.detectable_gain);
    let dependence =
        dependence(&Linearisation::new(&current.fit, &current.data, context.options)?, context.options.seed);
    let clusters = clusters(&held, dependence.as_ref());
    let folds = match partition.held_out {
        HeldOut::TestSet => None,
        HeldOut::NestedFolds => Some(context.budget().nested_folds),
        HeldOut::Refits => Some(context.budget().refit_folds),
    };
    let folds = folds.map(|folds| CrossValidated::of([&declared, &fit], folds));
    let (draws, seed) = (context.budget().bootstrap, context.options.seed);
    let intervals = HeldOutIntervals::of([&before, &after], &clusters, folds, draws, seed);
    let doubts = Doubts {
        unseen: intervals.as_ref().map(|intervals| intervals.after),
        joints_scatter: joints.is_some(),
        outliers_together: together.is_some(),
        wander: dependence.as_ref().and_then(|dependence| dependence.wander),
    };
    let (verdict, unexplained) =
        self::verdict(&noise_floor, stopped, variances, last, doubts, context.policy());
    // Findings were testable, in the directions that the model does not absorb.
    let found_there = |u: &Untestable| {
        accepted.iter().any(|a| a.candidate.family == u.family && a.candidate.place == u.place)
    };
    let assumed = current.fit.noise.floor(typical_sd(&current.data));
    let ratio = noise_floor.rms.map_or(1.0, |rms| rms / assumed);
    let untestable = untestable.into_iter().map(|u| u.with_noise(ratio));
    let untestable = untestable.filter(|u| u.holds(context.policy()) && !found_there(u)).collect();
    let unseen = match declared_fit.full_report {
        true => extrapolations(context, [&declared, &fit], &found, partition.data, &outside.suspects),
        false => Vec::new(),
    };
    let (mut extrapolations, parts): (Vec<_>, Vec<_>) = unseen.into_iter().unzip();
    if declared_fit.full_report && !found.is_empty() {
        let as_declared = without(partition.data, &outside.suspects);
        let alone = fit_again(&declared, &as_declared, context.solver, &context.fit)?;
        let fallback = fallback((&alone.fitted, &as_declared), (&fit.fitted, &data), &parts)?;
        for (figures, part) in extrapolations.iter_mut().zip(&parts) {
            figures.fallen_back = Some(part.mean_square(fallback.scale).sqrt());
        }
        fit.fitted.fallback = Some(fallback);
    }
    Ok(Diagnosis {
        fold_runs,
        rows: partition.data.len(),
        visits: Visits::of(partition.data).len(),
        placement: partition.placement.clone(),
        findings,
        refused,
        competitors,
        repeats_before: repeats(&declared, context.data),
        repeats_after: repeats(&current.fit, &current.data),
        before,
        after,
        withdrawn,
        noise_floor,
        dependence,
        joints,
        verdict,
        unexplained,
        intervals,
        extrapolations,
        stated_scale: partition.stated_scale,
        stopped,
        fit,
        declared,
        data,
        untestable,
        held_out: partition.held_out,
        suspects: outside.suspects.iter().copied().filter(|row| !outside.certain.contains(row)).collect(),
        holdout_rows: partition.holdout_rows,
    })
}

/// The fit with its position residuals times a weight of their row.
fn weighed(fit: &Fit, weights: &[f64]) -> Fit {
    let mut fit = fit.clone();
    fit.residuals.position.iter_mut().zip(weights).for_each(|(residual, weight)| *residual *= *weight);
    fit
}

/// Sets loads, domain and channels of the fitted model as the data declares them: this is what a user
/// declares at run time.
pub(crate) fn at_run_time(fit: &mut Fit, found: &[Candidate], data: &Dataset) {
    fit.fitted.loads = found
        .iter()
        .filter_map(|candidate| match candidate.change {
            Change::CorrectLoad { level, mass, during, .. } => {
                Some(LoadCorrection { declared: level, carried: mass, during })
            }
            Change::Add(_) | Change::Exclude { .. } => None,
        })
        .collect();
    let own = derived::own_channels(data);
    fit.fitted.domain = Domain::of(&own);
    // The sample keeps the derived channels of the model: they cannot be derived from a sample.
    let model = fit.fitted.model();
    // Without a time there is no lagged channel in the model either.
    let derived = data.derived_for(model).unwrap_or(Cow::Borrowed(data));
    let sample = Sample::of(&derived).for_model(model);
    fit.fitted.domain.sample = sample;
    fit.fitted.channels.clone_from(&own.schema.channels);
}

pub(crate) fn errors(fit: &Fit, train: &Dataset, held: &Dataset) -> Result<Errors, DiscoverError> {
    let (train, holdout) = (Residuals::of(&fit.fitted, train)?, Residuals::of(&fit.fitted, held)?);
    Ok(Errors { train, holdout, outliers: Default::default() })
}

/// Coefficients of a finding with their intervals.
pub(crate) fn parameters(fit: &Fit, found: &Candidate, effects: Range<usize>) -> Vec<Parameter> {
    let half = fit.half_widths();
    let model = fit.fitted.model();
    let mut list = Vec::new();
    for effect in effects {
        for column in model.columns_of(effect) {
            if fit.reduction.kept.contains(&column) {
                let value = fit.fitted.coefficients()[column];
                list.push(Parameter {
                    name: model.columns()[column].name.clone(),
                    value,
                    unit: model.columns()[column].unit.clone(),
                    ci95: [value - half[column], value + half[column]],
                });
            }
        }
    }
    if let Change::CorrectLoad { mass, deviation, .. } = found.change {
        let half = student_quantile(0.975, fit.degrees_of_freedom()) * deviation;
        let ci95 = [mass - half, mass + half];
        list.push(Parameter { name: "mass".into(), value: mass, unit: "kg".into(), ci95 });
    }
    list
}

/// Nonlinear parameters of a finding with their intervals.
fn shape(fit: &Fit, effects: &Range<usize>) -> Vec<Parameter> {
    let own: Vec<&FittedNonlinear> =
        fit.shapes.iter().filter(|shape| effects.contains(&shape.effect)).collect();
    let parameter = |(k, shape): (usize, &&FittedNonlinear)| Parameter {
        name: if own.len() > 1 { format!("{} {}", shape.name, k + 1) } else { shape.name.clone() },
        value: shape.value,
        unit: shape.unit.clone(),
        ci95: shape.interval,
    };
    own.iter().enumerate().map(parameter).collect()
}

/// Competing hypotheses in place of a finding, with their error on the test set.
fn alternatives(
    context: &Context<'_>,
    trial: &Trial<'_>,
    (which, names): (usize, &NameProbabilities),
    accepted: &Accepted,
) -> Result<Vec<Alternative>, DiscoverError> {
    let competitors = &accepted.competitors;
    let simplest = accepted.simplest(context.policy());
    let unnamed =
        competitors.iter().filter(|(r, _)| !r.family.is_named()).nth(context.budget().listed_unnamed);
    let last = unnamed.map_or(f64::INFINITY, |(_, behind)| *behind);
    let listed = competitors.iter().zip(&names.each);
    let listed = listed.filter(|((r, behind), _)| r.family.is_named() || *behind < last);
    let listed: Vec<_> = listed.take(context.budget().listed).collect();
    listed
        .par_iter()
        .map(|((candidate, behind), probability)| {
            Ok(Alternative {
                probability: **probability,
                family: candidate.family,
                place: candidate.place.clone(),
                holdout: trial.instead(which, candidate)?.1,
                behind: *behind,
                equivalent: *behind < context.policy().tie,
                simplest: simplest.is_some_and(|simplest| simplest.same_cause(candidate)),
            })
        })
        .collect()
}

/// Fits, to all rows except outliers, of the competing hypotheses that are not distinguishable from the
/// findings.
fn competing_fits(
    context: &Context<'_>,
    trial: &Trial<'_>,
    accepted: &[Accepted],
    out: &[usize],
    data: &Dataset,
) -> Result<Vec<CompetingFit>, DiscoverError> {
    let mut fits = Vec::new();
    for (finding, accepted) in accepted.iter().enumerate() {
        // The likeliest names first: a curve without one is the last that a plan needs.
        let own = (&accepted.candidate, accepted.evidence.p_surrogates);
        let names = name_probabilities(own, &accepted.competitors, context.policy());
        let mut tied: Vec<_> = accepted
            .competitors
            .iter()
            .zip(&names.each)
            .filter(|((_, behind), _)| *behind < context.policy().tie)
            .collect();
        tied.sort_by(|a, b| b.1.total_cmp(a.1));
        for ((candidate, _), _) in tied.into_iter().take(context.budget().fitted) {
            let (mut fit, found) = trial.fit_instead(finding, candidate, out)?;
            at_run_time(&mut fit, &found, data);
            fits.push(CompetingFit { finding, candidate: candidate.clone(), fit });
        }
    }
    Ok(fits)
}
