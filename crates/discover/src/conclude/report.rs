//! The end of the loop: the ledger, on rows that took part in nothing, and the fit on all rows.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::{Evidence, Gain};
use crate::accept::model::Model;
use crate::accept::outcome::{LastScreen, Outcome};
use crate::conclude::diagnosis::{
    Alternative, Diagnosis, Finding, Parameter, RivalFit, Unexplained, Withdrawn,
};
use crate::conclude::errors::Errors;
use crate::conclude::final_fit::{Final, Plain, enlarged, training};
use crate::conclude::floor::{NoiseFloor, Verdict};
use crate::conclude::trace::trace;
use crate::conclude::trial::Trial;
use crate::conclude::whole::Whole;
use crate::data::payload::with_loads;
use crate::data::{derived, payload};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::{Candidate, Change};
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::model::current::Ground;
use crate::policy::TIE;
use crate::problem::linearisation::Scene;
use crate::problem::outliers::Outliers;
use crate::termination::Stop;
use rayon::prelude::*;
use std::ops::Range;
use truepose_errormodel::{Dataset, Domain, LoadCorrection, Sample};
use truepose_identify::{Fit, FittedNonlinear, Residuals, repeats, student_quantile};

/// Forms the ledger.
pub(crate) fn conclude(
    context: &Ground<'_>,
    outcome: Outcome,
    whole: Whole<'_>,
    withdrawn: Option<Withdrawn>,
    plain: &Plain<'_>,
) -> Result<Diagnosis, DiscoverError> {
    let held = whole.data.select(&whole.holdout_rows);
    let wanted = context.options.rival_fits;
    let Outcome { model, refused, mut untestable, last, stopped } = outcome;
    let LastScreen { p_value, detectable_gain } = last;
    let Model { findings: accepted, current: now, .. } = model;
    // What was found could be tested after all, in the directions that are left of it.
    untestable
        .retain(|u| !accepted.iter().any(|a| a.candidate.family == u.family && a.candidate.place == u.place));
    let found: Vec<Candidate> = accepted.iter().map(|a| a.candidate.clone()).collect();
    let declared = match found.is_empty() {
        true => now.fit.clone(),
        false => context.fitted(&[], &context.prepared(&[], &now.outliers.suspects))?,
    };
    let mut before = errors(&declared, context.data, &held)?;
    let mut after = errors(&now.fit, &with_loads(context.data, &found), &with_loads(&held, &found))?;

    let all = with_loads(whole.data, &found);
    let judged = Scene::new(&now.fit, &all)?;
    let trial = Trial::new(context, &now, &found, &judged, &whole);
    // The model step by step, on the same training rows.
    let between: Vec<_> =
        (1..found.len()).into_par_iter().map(|count| trial.first(count)).collect::<Result<_, _>>()?;
    let steps: Vec<_> = [before.rms()].into_iter().chain(between).chain([after.rms()]).collect();

    let Final { fit, found, data, outside } = match (plain.thorough, found.is_empty()) {
        (true, true) => plain.fit(context, &now, &all)?,
        (true, false) => enlarged(context, &now, &found, &all)?,
        (false, _) => training(&now, &found, &all)?,
    };
    let mut fit = fit;
    at_run_time(&mut fit, &found, whole.data);

    let mut findings = Vec::new();
    for (k, accepted) in accepted.iter().enumerate() {
        let effects = context.effects_of(&found, k);
        findings.push(Finding {
            parameters: parameters(&fit, &found[k], effects.clone()),
            shape: shape(&fit, &effects),
            rows: match accepted.candidate.change {
                Change::CorrectLoad { level, .. } => payload::rows_at(whole.data, level),
                Change::Add(_) => Vec::new(),
            },
            candidate: found[k].clone(),
            evidence: accepted.evidence.clone(),
            train: (steps[k].0, steps[k + 1].0),
            holdout: (steps[k].1, steps[k + 1].1),
            alternatives: match plain.thorough {
                true => alternatives(&trial, k, &accepted.rivals)?,
                false => Vec::new(),
            },
            trace: match plain.thorough {
                true => trace(&fit, &data, &found[k], effects.start)?,
                false => None,
            },
        });
    }
    let rivals =
        if wanted { rival_fits(&trial, &accepted, &outside.suspects, whole.data)? } else { Vec::new() };
    let within = |part: &[usize]| -> Vec<usize> {
        (0..part.len()).filter(|&k| outside.certain.contains(&part[k])).collect()
    };
    before.outliers = [within(&whole.train_rows), within(&whole.holdout_rows)];
    after.outliers.clone_from(&before.outliers);
    if !outside.certain.is_empty() {
        let judged = Residuals::of(&fit.fitted, whole.data)?;
        let (out, good): (Vec<usize>, Vec<usize>) =
            (0..judged.position.len()).partition(|row| outside.certain.contains(row));
        let all: Vec<usize> = (0..judged.position.len()).collect();
        let rms = (judged.positions_of(&all).rms, judged.positions_of(&good).rms);
        let held = after.holdout.positions().rms;
        findings.push(outlier_finding(&outside, out.len(), rms, (held, held)));
    }
    let stopped = if withdrawn.is_some() { Stop::Withdrawn } else { stopped };
    let repeats_after = repeats(&now.fit, &now.data);
    let noise_floor = NoiseFloor::of(repeats_after.as_ref(), whole.data);
    let verdict = noise_floor.verdict(stopped, repeats_after.as_ref(), &after);
    let train = |errors: &Errors| errors.spreads_without_outliers().0.rms;
    let beyond = noise_floor.beyond(train(&before), train(&after));
    Ok(Diagnosis {
        placement: whole.placement.clone(),
        findings,
        refused,
        rivals,
        repeats_before: repeats(&declared, context.data),
        repeats_after,
        before,
        after,
        withdrawn,
        noise_floor,
        verdict,
        unexplained: Unexplained {
            significant: verdict == Verdict::Unexplained,
            rms: beyond.map(|(rms, _)| rms),
            share_of_variance: beyond.map(|(_, share)| share),
            p_value,
            detectable_gain,
        },
        stopped,
        fit,
        declared,
        data,
        untestable,
        holdout_rows: whole.holdout_rows,
    })
}

/// Loads, domain and channels as they are declared at run time: as they were declared here.
pub(crate) fn at_run_time(fit: &mut Fit, found: &[Candidate], data: &Dataset) {
    fit.fitted.loads = found
        .iter()
        .filter_map(|candidate| match candidate.change {
            Change::CorrectLoad { level, mass, .. } => {
                Some(LoadCorrection { declared: level, carried: mass })
            }
            Change::Add(_) => None,
        })
        .collect();
    let own = derived::own_channels(data);
    fit.fitted.domain = Domain::of(&own);
    // The rows keep the derived channels that the model reads: a sample has no history to make them of.
    fit.fitted.domain.sample = Sample::of(data).for_model(fit.fitted.model());
    fit.fitted.channels.clone_from(&own.schema.channels);
}

pub(crate) fn errors(fit: &Fit, train: &Dataset, held: &Dataset) -> Result<Errors, DiscoverError> {
    let (train, holdout) = (Residuals::of(&fit.fitted, train)?, Residuals::of(&fit.fitted, held)?);
    Ok(Errors { train, holdout, outliers: Default::default() })
}

/// Coefficients of a find with their intervals.
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

/// What is known of the shape of a find.
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

/// Rivals in place of a find, judged on the held-out rows.
fn alternatives(
    trial: &Trial<'_>,
    which: usize,
    rivals: &[(Candidate, f64)],
) -> Result<Vec<Alternative>, DiscoverError> {
    /// Rivals that are listed, and how many of them may go without a name: these come in many forms of one thing.
    const LISTED: usize = 4;
    const NAMELESS: usize = 2;
    let nameless = rivals.iter().filter(|(r, _)| r.family == Family::Unmodelled).nth(NAMELESS);
    let last = nameless.map_or(f64::INFINITY, |(_, behind)| *behind);
    let listed = rivals.iter().filter(|(r, behind)| r.family != Family::Unmodelled || *behind < last);
    let listed: Vec<_> = listed.take(LISTED).collect();
    listed
        .par_iter()
        .map(|(candidate, behind)| {
            Ok(Alternative {
                family: candidate.family,
                place: candidate.place.clone(),
                holdout: trial.instead(which, candidate)?.1,
                behind: *behind,
                equivalent: *behind < TIE,
            })
        })
        .collect()
}

/// The explanations that this data cannot tell from the finds, fitted to all rows but those that are kept out.
fn rival_fits(
    trial: &Trial<'_>,
    accepted: &[Accepted],
    out: &[usize],
    data: &Dataset,
) -> Result<Vec<RivalFit>, DiscoverError> {
    /// Of one find.
    const FITTED: usize = 2;
    let mut fits = Vec::new();
    for (finding, accepted) in accepted.iter().enumerate() {
        let tied = accepted.rivals.iter().filter(|(_, behind)| *behind < TIE).take(FITTED);
        for (candidate, _) in tied {
            let (mut fit, found) = trial.fit_instead(finding, candidate, out)?;
            at_run_time(&mut fit, &found, data);
            fits.push(RivalFit { finding, candidate: candidate.clone(), fit });
        }
    }
    Ok(fits)
}

/// Rows that no repeatable effect explains, as a find: `rms` with them and without, m.
fn outlier_finding(outside: &Outliers, unknowns: usize, rms: (f64, f64), holdout: (f64, f64)) -> Finding {
    let won = 1.0 - rms.1 / rms.0.max(f64::MIN_POSITIVE);
    let gain = Gain { before: rms.0, after: rms.1, t: 0.0, won, middle: won };
    Finding {
        candidate: Candidate {
            family: Family::Outlier,
            place: Place::default(),
            change: Change::Add(Vec::new()),
            width: None,
        },
        evidence: Evidence {
            p_value: outside.p_value,
            p_parametric: outside.p_value,
            unknowns,
            gain: 0.0,
            random: gain,
            blocks: None,
            stability: 1.0,
            agreement: 1.0,
        },
        holdout,
        train: rms,
        parameters: Vec::new(),
        shape: Vec::new(),
        alternatives: Vec::new(),
        rows: outside.certain.clone(),
        trace: None,
    }
}
