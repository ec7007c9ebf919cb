//! What the loop has after each find, should it be interrupted before its end.
//!
//! The ledger of the end without what only the end can afford: the fit is that of the training rows, rivals are not judged on held-out
//! rows, shapes have no intervals. Errors before and after a find are those of the model as it was when it was added.

use crate::accept::model::Model;
use crate::accept::outcome::{LastScreen, Outcome};
use crate::conclude::diagnosis::{Diagnosis, Finding, Unexplained};
use crate::conclude::errors::Errors;
use crate::conclude::floor::{NoiseFloor, Verdict};
use crate::conclude::report::{at_run_time, errors, parameters};
use crate::conclude::whole::Whole;
use crate::data::payload;
use crate::data::payload::with_loads;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Change;
use crate::model::current::{Ground, Working};
use crate::termination::Stop;
use truepose_errormodel::Dataset;
use truepose_identify::{Fit, repeats};

/// What is known from the beginning, and the errors (training, held out) with as many finds.
pub(crate) struct SoFar {
    declared: Fit,
    before: Errors,
    held: Dataset,
    steps: Vec<(f64, f64)>,
}

impl SoFar {
    /// Before anything was found.
    pub fn new(first: &Working, whole: &Whole<'_>) -> Result<Self, DiscoverError> {
        let held = whole.data.select(&whole.holdout_rows);
        let before = errors(&first.fit, &first.data, &held)?;
        Ok(SoFar { declared: first.fit.clone(), steps: vec![before.rms()], before, held })
    }

    /// After a finding.
    pub fn after(
        &mut self,
        context: &Ground<'_>,
        outcome: &Outcome,
        whole: &Whole<'_>,
    ) -> Result<Diagnosis, DiscoverError> {
        let Model { findings, current: now, .. } = &outcome.model;
        let LastScreen { p_value, detectable_gain } = outcome.last;
        let after =
            errors(&now.fit, &with_loads(context.data, &now.found), &with_loads(&self.held, &now.found))?;
        self.steps.truncate(findings.len());
        // A look at earlier finds may have split one.
        while self.steps.len() < findings.len() {
            self.steps.push(after.rms());
        }
        self.steps.push(after.rms());
        let mut fit = now.fit.clone();
        at_run_time(&mut fit, &now.found, whole.data);
        let finding = |(k, accepted): (usize, &crate::accept::accepted::Accepted)| Finding {
            candidate: accepted.candidate.clone(),
            evidence: accepted.evidence.clone(),
            train: (self.steps[k].0, self.steps[k + 1].0),
            holdout: (self.steps[k].1, self.steps[k + 1].1),
            parameters: parameters(&fit, &accepted.candidate, context.effects_of(&now.found, k)),
            shape: Vec::new(),
            alternatives: Vec::new(),
            rows: match accepted.candidate.change {
                Change::CorrectLoad { level, .. } => payload::rows_at(whole.data, level),
                Change::Add(_) => Vec::new(),
            },
            trace: None,
        };
        let findings = findings.iter().enumerate().map(finding).collect();
        let repeats_after = repeats(&now.fit, &now.data);
        let noise_floor = NoiseFloor::of(repeats_after.as_ref(), whole.data);
        let beyond = noise_floor.beyond(self.before.rms().0, after.rms().0);
        Ok(Diagnosis {
            placement: whole.placement.clone(),
            findings,
            rivals: Vec::new(),
            refused: outcome.refused.clone(),
            repeats_before: repeats(&self.declared, context.data),
            repeats_after,
            withdrawn: None,
            verdict: Verdict::Undecided,
            before: self.before.clone(),
            after,
            noise_floor,
            unexplained: Unexplained {
                significant: true,
                rms: beyond.map(|(rms, _)| rms),
                share_of_variance: beyond.map(|(_, share)| share),
                p_value,
                detectable_gain,
            },
            stopped: Stop::Interrupted,
            fit,
            declared: self.declared.clone(),
            data: now.data.clone(),
            untestable: outcome.untestable.clone(),
            holdout_rows: whole.holdout_rows.clone(),
        })
    }
}
