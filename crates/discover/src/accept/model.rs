//! The model of the search: the declared model with its findings, fitted. It is an immutable value: a change
//! makes another value, a rejected change is dropped.

use crate::accept::accepted::Accepted;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::model::current::{Context, ModelFit};
use crate::model::nonlinear::{between_rows, descended, gaps};
use crate::model::refits::Refits;
use std::ops::Range;
use std::sync::{Arc, OnceLock};
use truepose_errormodel::AnyEffect;
use truepose_identify::{Fit, Residuals};

/// The declared model with its findings.
#[derive(Clone)]
pub(crate) struct Model {
    pub findings: Vec<Accepted>,
    /// The fit with all findings.
    pub current: Arc<ModelFit>,
    /// The fit of the declared model alone.
    pub declared: Arc<ModelFit>,
    /// Cross-validation residuals of the model by whole refits, evaluated on first use.
    refits: Arc<OnceLock<Refits>>,
}

impl Model {
    /// The declared model as it was fitted, without findings.
    pub fn declared(fit: ModelFit) -> Self {
        let fit = Arc::new(fit);
        Model { findings: Vec::new(), current: Arc::clone(&fit), declared: fit, refits: Arc::default() }
    }

    /// The declared model without the findings.
    pub fn without_findings(&self) -> Self {
        Model {
            findings: Vec::new(),
            current: Arc::clone(&self.declared),
            declared: Arc::clone(&self.declared),
            refits: Arc::default(),
        }
    }

    /// The same structure with the coefficients of other rows.
    pub fn with_fit(self, fit: Fit) -> Self {
        let current = Arc::new(self.current.with_fit(fit));
        Model { current, refits: Arc::default(), ..self }
    }

    /// The same with other coefficients of the declared model alone.
    pub fn with_declared(self, fit: Fit) -> Self {
        Model { declared: Arc::new(self.declared.with_fit(fit)), ..self }
    }

    /// Fits the declared model with these findings. Corrected masses are estimated in the fit, so that
    /// candidates come back changed.
    pub fn refitted(&self, context: &Context<'_>, findings: Vec<Accepted>) -> Result<Self, DiscoverError> {
        let found: Vec<Candidate> = findings.iter().map(|a| a.candidate.clone()).collect();
        if found.is_empty() {
            return Ok(self.without_findings());
        }
        let fit = context.fit_model(found, &self.current.outliers.suspects)?;
        Ok(self.standing_on(findings, fit))
    }

    fn standing_on(&self, mut findings: Vec<Accepted>, fit: ModelFit) -> Self {
        for (finding, found) in findings.iter_mut().zip(&fit.found) {
            finding.candidate = found.clone();
        }
        Model {
            findings,
            current: Arc::new(fit),
            declared: Arc::clone(&self.declared),
            refits: Arc::default(),
        }
    }

    /// The findings with one more, and its number. Further effects of a family and place that is known
    /// (periods of one transmission) are added to that finding. `None` when the model has all effects of the
    /// candidate.
    pub fn joined(&self, accepted: Accepted) -> Option<(Vec<Accepted>, usize)> {
        let mut findings = self.findings.clone();
        let known = findings.iter().position(|a| a.candidate.same_cause(&accepted.candidate));
        if let Some(known) = known
            && let (Change::Add(effects), Change::Add(more)) =
                (&mut findings[known].candidate.change, &accepted.candidate.change)
        {
            let has = |effect: &dyn AnyEffect| {
                effects.iter().any(|e| e.kind() == effect.kind() && e.parameters() == effect.parameters())
            };
            let new: Vec<_> = more.iter().filter(|effect| !has(&***effect)).cloned().collect();
            if new.is_empty() {
                return None;
            }
            effects.extend(new);
            return Some((findings, known));
        }
        findings.push(accepted);
        let last = findings.len() - 1;
        Some((findings, last))
    }

    /// Indices, in the fitted model, of the effects of a finding.
    pub fn effects_of(&self, context: &Context<'_>, which: usize) -> Range<usize> {
        context.effects_of(&self.current.found, which)
    }

    /// The candidates of all findings except those of these numbers.
    pub fn others(&self, but: &[usize]) -> Vec<Candidate> {
        let kept = (0..self.findings.len()).filter(|k| !but.contains(k));
        kept.map(|k| self.findings[k].candidate.clone()).collect()
    }

    /// The model with all nonlinear parameters at their joint optimum; `None` when none moved.
    pub fn descended(&self, context: &Context<'_>) -> Result<Option<Self>, DiscoverError> {
        let ModelFit { found, fit, data, .. } = &*self.current;
        match descended(context, found, fit, data)? {
            Some(next) => Ok(Some(self.refitted(context, self.replaced(next))?)),
            None => Ok(None),
        }
    }

    /// The model with each change point in the middle of the gap between rows in which the data places it.
    pub fn between_rows(self, context: &Context<'_>) -> Result<Self, DiscoverError> {
        let next = between_rows(&self.current.found, context.data);
        if next.iter().all(|found| gaps(found).is_empty()) {
            return Ok(self);
        }
        self.refitted(context, self.replaced(next))
    }

    fn replaced(&self, candidates: Vec<Candidate>) -> Vec<Accepted> {
        let mut findings = self.findings.clone();
        findings.iter_mut().zip(candidates).for_each(|(finding, next)| finding.candidate = next);
        findings
    }

    /// The same structure fitted to the data of another context (all training rows after a search on a
    /// sample), declared model included.
    pub fn on_data_of(&self, context: &Context<'_>) -> Result<Self, DiscoverError> {
        let declared = context.fit_model_from(Vec::new(), &[], Some(&self.declared.fit))?;
        let declared = Model::declared(declared);
        let found = self.current.found.clone();
        if found.is_empty() {
            return Ok(declared);
        }
        let fit = context.fit_model_from(found, &[], Some(&self.current.fit))?;
        Ok(declared.standing_on(self.findings.clone(), fit))
    }

    /// Cross-validation residuals by refits ([`crate::model::refits`]).
    pub fn refits(&self, context: &Context<'_>) -> Result<Refits, DiscoverError> {
        if let Some(known) = self.refits.get() {
            return Ok(known.clone());
        }
        let refits = context.refits(&self.current, context.options.seed)?;
        // When another thread has set it, its value is the same.
        let _ = self.refits.set(refits.clone());
        Ok(refits)
    }

    /// Residuals of the declared model and of this one on the training rows, each row by a refit without its
    /// fold.
    pub fn both_refitted(&self, context: &Context<'_>) -> Result<[Residuals; 2], DiscoverError> {
        let first = context.refits(&self.declared, context.options.seed)?.residuals;
        Ok([first, self.refits(context)?.residuals])
    }

    /// The findings as a set: family, place and number of effects.
    pub fn structure(&self) -> Structure {
        let of = |a: &Accepted| (a.candidate.clone(), a.candidate.effects().len());
        Structure(self.findings.iter().map(of).collect())
    }
}

/// Families and places of findings with the number of effects of each; equal in any order.
#[derive(Clone)]
pub(crate) struct Structure(Vec<(Candidate, usize)>);

impl PartialEq for Structure {
    fn eq(&self, other: &Self) -> bool {
        let same = |a: &(Candidate, usize), b: &(Candidate, usize)| a.1 == b.1 && a.0.same_cause(&b.0);
        let count = |all: &[(Candidate, usize)], one| all.iter().filter(|each| same(each, one)).count();
        self.0.len() == other.0.len() && self.0.iter().all(|one| count(&self.0, one) == count(&other.0, one))
    }
}
