//! The model of the search as a value: the declared model with its findings, fitted. A change makes another value; what fails is dropped.

use crate::accept::accepted::Accepted;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::{Candidate, Change};
use crate::model::current::{Ground, Working};
use crate::model::nonlinear::{between_rows, descended, gaps};
use crate::model::refits::Refits;
use std::ops::Range;
use std::sync::{Arc, OnceLock};
use truepose_errormodel::AnyEffect;
use truepose_identify::Residuals;

/// The declared model with what was found.
#[derive(Clone)]
pub(crate) struct Model {
    pub findings: Vec<Accepted>,
    /// The fit with all findings.
    pub current: Arc<Working>,
    /// The fit of the declared model alone.
    pub declared: Arc<Working>,
    /// How the model predicts poses that its refits have not seen, once that was evaluated.
    refits: Arc<OnceLock<Refits>>,
}

impl Model {
    /// Without findings.
    pub fn declared(fit: Working) -> Self {
        let fit = Arc::new(fit);
        Model { findings: Vec::new(), current: Arc::clone(&fit), declared: fit, refits: Arc::default() }
    }

    /// The declared model alone.
    pub fn without_findings(&self) -> Self {
        Model {
            findings: Vec::new(),
            current: Arc::clone(&self.declared),
            declared: Arc::clone(&self.declared),
            refits: Arc::default(),
        }
    }

    /// Refitted with these findings. Declared masses and nonlinear parameters move while the model is fitted.
    pub fn refitted(&self, context: &Ground<'_>, findings: Vec<Accepted>) -> Result<Self, DiscoverError> {
        let found: Vec<Candidate> = findings.iter().map(|a| a.candidate.clone()).collect();
        if found.is_empty() {
            return Ok(self.without_findings());
        }
        let fit = context.working(found, &self.current.outliers.suspects)?;
        Ok(self.standing_on(findings, fit))
    }

    fn standing_on(&self, mut findings: Vec<Accepted>, fit: Working) -> Self {
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

    /// The findings with one more; further effects of a cause that is known (periods of one transmission) go to the finding that they belong
    /// to. Returns the number of that finding; none when the model has the candidate already.
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

    /// The effects of the fitted model that belong to a finding.
    pub fn effects_of(&self, context: &Ground<'_>, which: usize) -> Range<usize> {
        context.effects_of(&self.current.found, which)
    }

    /// The candidates of all findings but some.
    pub fn others(&self, but: &[usize]) -> Vec<Candidate> {
        let kept = (0..self.findings.len()).filter(|k| !but.contains(k));
        kept.map(|k| self.findings[k].candidate.clone()).collect()
    }

    /// With all nonlinear parameters at their joint optimum; none when nothing moved.
    pub fn descended(&self, context: &Ground<'_>) -> Result<Option<Self>, DiscoverError> {
        let Working { found, fit, data, .. } = &*self.current;
        match descended(context, found, fit, data)? {
            Some(next) => Ok(Some(self.refitted(context, self.replaced(next))?)),
            None => Ok(None),
        }
    }

    /// With each jump between the two rows between which the data places it.
    pub fn between_rows(self, context: &Ground<'_>) -> Result<Self, DiscoverError> {
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

    /// What was found in a part of the data, fitted to the data of another context; the declared model as well.
    pub fn on_data_of(&self, context: &Ground<'_>) -> Result<Self, DiscoverError> {
        let declared = context.working_from(Vec::new(), &[], Some(&self.declared.fit))?;
        let declared = Model::declared(declared);
        let found = self.current.found.clone();
        if found.is_empty() {
            return Ok(declared);
        }
        let fit = context.working_from(found, &[], Some(&self.current.fit))?;
        Ok(declared.standing_on(self.findings.clone(), fit))
    }

    /// How it predicts training poses that its refits have not seen.
    pub fn refits(&self, context: &Ground<'_>) -> Result<Refits, DiscoverError> {
        if let Some(known) = self.refits.get() {
            return Ok(known.clone());
        }
        let refits = context.refits(&self.current, context.options.seed)?;
        // Another thread may have been as fast, with the same value.
        let _ = self.refits.set(refits.clone());
        Ok(refits)
    }

    /// The declared model and this one on the training rows, each row by a refit without its fold.
    pub fn both_refitted(&self, context: &Ground<'_>) -> Result<[Residuals; 2], DiscoverError> {
        let first = context.refits(&self.declared, context.options.seed)?.residuals;
        Ok([first, self.refits(context)?.residuals])
    }

    /// What was found, in any order, and of how many effects each finding is.
    pub fn structure(&self) -> Structure {
        let of = |a: &Accepted| (a.candidate.clone(), a.candidate.effects().len());
        Structure(self.findings.iter().map(of).collect())
    }
}

/// Causes at their places with the number of effects of each; equal in any order.
#[derive(Clone)]
pub(crate) struct Structure(Vec<(Candidate, usize)>);

impl PartialEq for Structure {
    fn eq(&self, other: &Self) -> bool {
        let same = |a: &(Candidate, usize), b: &(Candidate, usize)| a.1 == b.1 && a.0.same_cause(&b.0);
        let count = |all: &[(Candidate, usize)], one| all.iter().filter(|each| same(each, one)).count();
        self.0.len() == other.0.len() && self.0.iter().all(|one| count(&self.0, one) == count(&other.0, one))
    }
}
