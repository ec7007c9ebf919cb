//! The interim result after each finding, for a run that is interrupted.
//!
//! The final result without its expensive parts: the fit is that of the training rows, competing hypotheses
//! are not evaluated on the test set, nonlinear parameters have no intervals. Errors before and after a
//! finding are those of the model when it was added.

use crate::accept::accepted::Accepted;
use crate::accept::model::Model;
use crate::accept::outcome::{LastScreen, Outcome};
use crate::conclude::diagnosis::{Diagnosis, Finding};
use crate::conclude::errors::Errors;
use crate::conclude::floor::NoiseFloor;
use crate::conclude::partition::{HeldOut, Partition};
use crate::conclude::report::{at_run_time, errors, parameters};
use crate::conclude::stated::StatedScale;
use crate::conclude::verdict::{Doubts, Variances, verdict};
use crate::contest::names::name_probabilities;
use crate::data::payload;
use crate::error::DiscoverError;
use crate::hypotheses::change::Change;
use crate::model::current::{Context, ModelFit};
use crate::model::prepared::with_found;
use crate::termination::Termination;
use truepose_errormodel::{Dataset, Visits};
use truepose_identify::{Fit, ResidualVariance, repeats};

/// The fit and errors of the declared model, and the errors after each finding.
pub(crate) struct InterimReport {
    declared: Fit,
    before: Errors,
    held: Dataset,
    steps: Vec<(f64, f64)>,
    stated_scale: StatedScale,
}

impl InterimReport {
    /// Before the first finding.
    pub fn new(
        first: &ModelFit,
        partition: &Partition<'_>,
        stated_scale: StatedScale,
    ) -> Result<Self, DiscoverError> {
        let held = partition.data.select(&partition.holdout_rows);
        let before = errors(&first.fit, &first.data, &held)?;
        Ok(InterimReport {
            declared: first.fit.clone(),
            steps: vec![before.rms()],
            before,
            held,
            stated_scale,
        })
    }

    /// The interim result after a finding.
    pub fn after(
        &mut self,
        context: &Context<'_>,
        outcome: &Outcome,
        partition: &Partition<'_>,
    ) -> Result<Diagnosis, DiscoverError> {
        let Model { findings, current, .. } = &outcome.model;
        let LastScreen { p_value, detectable_gain } = outcome.last;
        let mut after = errors(
            &current.fit,
            &with_found(context.data, &current.found),
            &with_found(&self.held, &current.found),
        )?;
        let mut held_out = partition.held_out;
        if held_out == HeldOut::NestedFolds {
            // The folds come at the end of a run.
            held_out = HeldOut::Refits;
            let [declared, enlarged] = outcome.model.both_refitted(context)?;
            self.before.holdout = declared;
            self.steps[0] = self.before.rms();
            after.holdout = enlarged;
        }
        self.steps.truncate(findings.len());
        // A revision may have changed the number of findings by more than one.
        while self.steps.len() < findings.len() {
            self.steps.push(after.rms());
        }
        self.steps.push(after.rms());
        let mut fit = current.fit.clone();
        at_run_time(&mut fit, &current.found, partition.data);
        let names = |a: &Accepted| {
            name_probabilities((&a.candidate, a.evidence.p_surrogates), &a.competitors, context.policy())
        };
        let finding = |(k, accepted): (usize, &Accepted)| Finding {
            candidate: accepted.candidate.clone(),
            p_value: accepted.evidence.p_value,
            name_probability: names(accepted).own,
            unnamed_probability: names(accepted).unnamed,
            evidence: Some(accepted.evidence.clone()),
            train: (self.steps[k].0, self.steps[k + 1].0),
            holdout: (self.steps[k].1, self.steps[k + 1].1),
            parameters: parameters(&fit, &accepted.candidate, context.effects_of(&current.found, k)),
            shape: Vec::new(),
            alternatives: Vec::new(),
            poses: Vec::new(),
            rows: match accepted.candidate.change {
                Change::CorrectLoad { level, during, .. } => {
                    payload::rows_at(partition.data, (level, during))
                }
                Change::Add(_) | Change::Exclude { .. } => Vec::new(),
            },
            trace: None,
        };
        let findings = findings.iter().enumerate().map(finding).collect();
        let repeats_after = repeats(&current.fit, &current.data);
        let trusted = self.stated_scale.is_one();
        let variances = Variances {
            before: ResidualVariance::of(&self.declared, context.data),
            after: ResidualVariance::of(&current.fit, &current.data),
        };
        let left = variances.after.as_ref();
        let noise_floor =
            NoiseFloor::of(&current.fit.fitted, (&current.data, None), left, trusted, context.policy())?;
        let last = (p_value, detectable_gain);
        let interrupted = Termination::Interrupted;
        let (verdict, unexplained) =
            verdict(&noise_floor, interrupted, variances, last, Doubts::default(), context.policy());
        Ok(Diagnosis {
            fold_runs: Vec::new(),
            rows: partition.data.len(),
            visits: Visits::of(partition.data).len(),
            placement: partition.placement.clone(),
            findings,
            competitors: Vec::new(),
            refused: outcome.refused.clone(),
            repeats_before: repeats(&self.declared, context.data),
            repeats_after,
            withdrawn: None,
            verdict,
            before: self.before.clone(),
            after,
            dependence: None,
            joints: None,
            noise_floor,
            unexplained,
            intervals: None,
            extrapolations: Vec::new(),
            stated_scale: self.stated_scale,
            stopped: Termination::Interrupted,
            fit,
            declared: self.declared.clone(),
            data: current.data.clone(),
            untestable: outcome.untestable.clone(),
            held_out,
            suspects: Vec::new(),
            holdout_rows: partition.holdout_rows.clone(),
        })
    }
}
