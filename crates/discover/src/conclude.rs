//! The end of the loop: the ledger, on rows that took part in nothing, and the fit on all rows.

use crate::DiscoverError;
use crate::candidate::{Candidate, Change};
use crate::descend::{between_rows, descended, gaps, shapes};
use crate::diagnose::{Accepted, LastWord, Search};
use crate::diagnosis::{
    Alternative, Diagnosis, Errors, Finding, Parameter, RivalFit, Stop, Unexplained, Untestable,
};
use crate::evidence::{Evidence, Gain};
use crate::outliers::{Outliers, outliers};
use crate::scene::Scene;
use crate::screen::Screen;
use crate::trace::trace;
use crate::trial::Trial;
use crate::working::{with_loads, without};
use crate::{Family, Place, contest::TIE, derived, payload};
use rayon::prelude::*;
use std::ops::Range;
use truepose_errormodel::{Dataset, Domain, LoadCorrection, Sample, Shape};
use truepose_identify::{
    Fit, FitOptions, FittedShape, NoiseSource, Placement, Residuals, fit_again, judge_shapes, repeats,
    student_quantile,
};

/// The data as a whole, and what was known before the loop.
pub(crate) struct Whole<'a> {
    pub data: &'a Dataset,
    pub train_rows: Vec<usize>,
    pub holdout_rows: Vec<usize>,
    pub placement: Placement,
}

/// Forms the ledger.
pub(crate) fn conclude(
    search: Search<'_>,
    whole: Whole<'_>,
    stopped: Stop,
    (p_value, detectable_gain): LastWord,
) -> Result<Diagnosis, DiscoverError> {
    let held = whole.data.select(&whole.holdout_rows);
    let wanted = search.options.rival_fits;
    let Search { ground, accepted, refused, mut untestable, now, .. } = search;
    // What was found could be tested after all, in the directions that are left of it.
    untestable
        .retain(|u| !accepted.iter().any(|a| a.candidate.family == u.family && a.candidate.place == u.place));
    let found: Vec<Candidate> = accepted.iter().map(|a| a.candidate.clone()).collect();
    let declared = ground.fitted(&[], &ground.prepared(&[], &now.outliers.suspects))?;
    let before = errors(&declared, ground.data, &held)?;
    let after = errors(&now.fit, &with_loads(ground.data, &found), &with_loads(&held, &found))?;

    let all = with_loads(whole.data, &found);
    let judged = Scene::new(&now.fit, &all)?;
    let trial = Trial::new(&ground, &now, &found, &judged, &whole);
    // The model step by step, on the same training rows.
    let between: Vec<_> =
        (1..found.len()).into_par_iter().map(|count| trial.first(count)).collect::<Result<_, _>>()?;
    let steps: Vec<_> = [before.rms()].into_iter().chain(between).chain([after.rms()]).collect();

    // The structure is frozen; coefficients and shapes come from all rows but the outliers.
    let frozen = FitOptions { noise: NoiseSource::Fixed(now.fit.noise), ..ground.fit.clone() };
    let outside = |fit: &Fit| -> Result<Outliers, DiscoverError> {
        let judged = Scene::new(fit, &all)?;
        let residual = &judged.y - &judged.base * judged.coefficients();
        Ok(outliers(&judged, residual.as_slice(), now.fit.noise))
    };
    let mut first = outside(&now.fit)?;
    // Between the rows on either side of a jump the training rows cannot say who is out.
    let jumps: Vec<[f64; 2]> = between_rows(&found, &now.data).iter().flat_map(gaps).collect();
    let unsure = |row: usize| jumps.iter().any(|[before, after]| (*before..*after).contains(&all.time[row]));
    first.suspects.retain(|&row| !unsure(row));
    let data = without(&all, &first.suspects);
    let fit = fit_again(&now.fit, &data, ground.solver, &frozen)?;
    let moved = descended(&ground, &found, &fit, &data)?;
    let found = between_rows(moved.as_deref().unwrap_or(&found), &data);
    let shapes = shapes(&ground, &found, &data);
    let fit = if shapes.is_empty() { fit } else { ground.fitted_by(&found, &data, &frozen)? };
    let outside = outside(&fit)?;
    let data = without(&all, &outside.suspects);
    let fit = if outside.suspects == first.suspects {
        fit
    } else {
        fit_again(&fit, &data, ground.solver, &frozen)?
    };
    let mut fit = with_shapes(fit, &data, &shapes);

    at_run_time(&mut fit, &found, whole.data);

    let mut findings = Vec::new();
    for (k, accepted) in accepted.iter().enumerate() {
        let effects = ground.effects_of(&found, k);
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
            alternatives: alternatives(&trial, k, &accepted.rivals)?,
            trace: trace(&fit, &data, &found[k], effects.start)?,
        });
    }
    let rivals =
        if wanted { rival_fits(&trial, &accepted, &outside.suspects, whole.data)? } else { Vec::new() };
    let noise_floor = now.fit.noise.floor(typical_sd(whole.data));
    if !outside.certain.is_empty() {
        let judged = Residuals::of(&fit.fitted, whole.data)?;
        let (out, good): (Vec<usize>, Vec<usize>) =
            (0..judged.position.len()).partition(|row| outside.certain.contains(row));
        let all: Vec<usize> = (0..judged.position.len()).collect();
        let rms = (judged.positions_of(&all).rms, judged.positions_of(&good).rms);
        let held = after.holdout.positions().rms;
        findings.push(outlier_finding(&outside, out.len(), rms, (held, held)));
    }
    let variance = |errors: &Errors| errors.train.positions().rms.powi(2);
    let floor = noise_floor * noise_floor;
    let significant = stopped != Stop::NothingLeft;
    let share = if significant && variance(&before) > 0.0 {
        ((variance(&after) - floor) / variance(&before)).clamp(0.0, 1.0)
    } else {
        0.0
    };
    Ok(Diagnosis {
        placement: whole.placement.clone(),
        findings,
        refused,
        rivals,
        repeats_before: repeats(&declared, ground.data),
        repeats_after: repeats(&now.fit, &now.data),
        before,
        after,
        noise_floor,
        unexplained: Unexplained { significant, share_of_variance: share, p_value, detectable_gain },
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
    Ok(Errors { train: Residuals::of(&fit.fitted, train)?, holdout: Residuals::of(&fit.fitted, held)? })
}

pub(crate) fn typical_sd(data: &Dataset) -> f64 {
    let mut stated: Vec<f64> = data.position_sd.iter().flatten().copied().filter(|v| !v.is_nan()).collect();
    stated.sort_by(f64::total_cmp);
    stated.get(stated.len() / 2).copied().unwrap_or(f64::NAN)
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

/// The fit with the intervals of what was found of the finds' shapes, and with what those add to the covariance.
fn with_shapes(fit: Fit, data: &Dataset, shapes: &[(usize, Shape)]) -> Fit {
    // Where columns beside the effect depend on each other nothing can be said: then the intervals are those of a known shape.
    if shapes.is_empty() { fit } else { judge_shapes(&fit, data, shapes).unwrap_or(fit) }
}

/// What is known of the shape of a find.
fn shape(fit: &Fit, effects: &Range<usize>) -> Vec<Parameter> {
    let own: Vec<&FittedShape> = fit.shapes.iter().filter(|shape| effects.contains(&shape.effect)).collect();
    let parameter = |(k, shape): (usize, &&FittedShape)| Parameter {
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

/// Causes that this data cannot test, with the size that could have been seen.
pub(crate) fn untestable(scene: &Scene<'_>, screen: &Screen) -> Vec<Untestable> {
    /// Less of a cause than this is left by the declared model.
    const LEFT: f64 = 0.05;
    /// Less than this is left only of what the declared model has itself.
    const DECLARED: f64 = 1e-4;
    /// Noncentrality at which the screen finds one unknown four times in five.
    const POWER: f64 = 30.0;
    let mut list: Vec<Untestable> = Vec::new();
    for screened in screen.candidates.iter().filter(|s| s.candidate.family != Family::Unmodelled) {
        let (family, place) = (screened.candidate.family, screened.candidate.place.clone());
        let share = screened.score.as_ref().map_or(0.0, |score| score.share);
        // An effect of this 3-D RMS leaves a whitened sum of squares of POWER.
        let rms = (scene.noise.floor(f64::NAN).powi(2) * POWER / scene.len() as f64 / share.max(1e-9)).sqrt();
        let detectable = screened.acts.then_some(rms);
        match list.iter_mut().find(|u| u.family == family && u.place == place) {
            Some(known) if known.share < share => (known.share, known.detectable) = (share, detectable),
            Some(_) => {}
            None => list.push(Untestable { family, place, share, detectable }),
        }
    }
    // What is declared already is no question; what does nothing at all here is one that other data could answer.
    list.retain(|u| u.detectable.is_none() || (u.share < LEFT && u.share > DECLARED));
    list
}
