//! The fit of the declared model with a list of findings; outliers are excluded, corrected payloads are
//! estimated.

use crate::budget::Budget;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::model::first_side;
use crate::model::prepared::{with_found, without};
use crate::options::DiscoverOptions;
use crate::policy::Policy;
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Linearisation;
use crate::problem::outliers::{Outliers, outliers};
use nalgebra::DMatrix;
use std::borrow::Cow;
use std::ops::Range;
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, Term, Visits};
use truepose_identify::{Fit, FitOptions, PriorStrength, fit, fit_again};
use truepose_kinematics::Chain;
use truepose_solvers::Solver;

/// Inputs of the search, which no step changes.
#[derive(Clone)]
pub(crate) struct Context<'a> {
    pub chain: &'a Chain,
    /// The declared effects with the prior widths of the fit of the declared model.
    pub declared: &'a [Box<dyn AnyEffect>],
    pub data: &'a Dataset,
    pub solver: &'a dyn Solver,
    pub fit: FitOptions,
    /// Options of the search.
    pub options: &'a DiscoverOptions,
    /// Whether rows that lie outside and have a declared payload in common stay in the fits: they may be an effect.
    pub levels_first: bool,
    /// Whether the result is reported: else only its findings and errors are needed.
    pub full_report: bool,
}

/// A model with its fit.
pub(crate) struct ModelFit {
    pub found: Vec<Candidate>,
    pub outliers: Outliers,
    /// The data with corrected payloads and first sides, without outliers.
    pub data: Dataset,
    pub fit: Fit,
}

impl ModelFit {
    /// The same with the coefficients of other rows.
    pub fn with_fit(&self, fit: Fit) -> Self {
        ModelFit { found: self.found.clone(), outliers: self.outliers.clone(), data: self.data.clone(), fit }
    }
}

impl Context<'_> {
    /// What is believed before the data is seen.
    pub fn policy(&self) -> &Policy {
        &self.options.policy
    }

    /// How much work is spent.
    pub fn budget(&self) -> &Budget {
        &self.options.budget
    }

    /// Fits the declared model with these findings; outliers are excluded, corrected loads are estimated.
    pub fn fit_model(&self, found: Vec<Candidate>, known: &[usize]) -> Result<ModelFit, DiscoverError> {
        self.fit_model_from(found, known, None)
    }

    /// As [`Self::fit_model`], started from the fit of the same model to other data.
    pub fn fit_model_from(
        &self,
        found: Vec<Candidate>,
        known: &[usize],
        start: Option<&Fit>,
    ) -> Result<ModelFit, DiscoverError> {
        let mut found = found;
        let mut out = known.to_vec();
        let mut iterations = 0;
        let mut last = start.map(Cow::Borrowed);
        loop {
            let data = self.prepared(&found, &out);
            let fit = match &last {
                None => self.fitted(&found, &data)?,
                Some(last) => fit_again(last, &data, self.solver, &self.fit)?,
            };
            let linearisation = Linearisation::new(&fit, &data, self.options)?;
            let loads = corrected(&linearisation, &mut found)?;
            let moved = first_side::settled(&fit, self.data, &mut found)? || loads;
            // All rows are tested, the excluded ones too.
            let whole = self.prepared(&found, &[]);
            let judged = Linearisation::new(&fit, &whole, self.options)?;
            let residual = &judged.y - &judged.base * judged.coefficients();
            let mut outliers = outliers(&judged, residual.as_slice(), fit.noise);
            if self.levels_first {
                outliers.admit(self.data, self.policy());
            }
            iterations += 1;
            // Of thousands of rows some lie at the threshold: one in 2000 may change.
            let settled = differing(&outliers.suspects, &out) <= whole.len() / 2000;
            let most = if moved { self.budget().load_iterations } else { self.budget().outlier_iterations };
            if (settled && !moved) || iterations > most {
                return Ok(ModelFit { found, outliers, data, fit });
            }
            out.clone_from(&outliers.suspects);
            last = Some(Cow::Owned(fit));
        }
    }

    /// Indices, in the model, of the effects of finding `which`.
    pub fn effects_of(&self, found: &[Candidate], which: usize) -> Range<usize> {
        let before: usize = found[..which].iter().map(|candidate| candidate.effects().len()).sum();
        let first = self.declared.len() + before;
        first..first + found[which].effects().len()
    }

    /// The fit of the declared model with these findings.
    pub fn fitted(&self, found: &[Candidate], data: &Dataset) -> Result<Fit, DiscoverError> {
        self.fitted_by(found, data, &self.fit)
    }

    /// As [`Self::fitted`], with other options.
    pub fn fitted_by(
        &self,
        found: &[Candidate],
        data: &Dataset,
        options: &FitOptions,
    ) -> Result<Fit, DiscoverError> {
        let mut effects = self.declared.to_vec();
        let kappa = match self.fit.prior {
            PriorStrength::Fixed(kappa) => kappa,
            _ => 1.0,
        };
        for candidate in found {
            for effect in candidate.effects() {
                effects.push(match candidate.width {
                    Some(width) => Box::new(Term::new(effect.clone()).scaled(width / kappa)),
                    None => effect.clone(),
                });
            }
        }
        let model = ErrorModel::new(self.chain.clone(), effects)?;
        Ok(fit(&model, data, self.solver, options)?)
    }

    /// The data with the corrected payloads and first sides of these findings, and without these rows.
    pub fn prepared(&self, found: &[Candidate], out: &[usize]) -> Dataset {
        without(&with_found(self.data, found), out)
    }
}

/// Number of rows that are in one of two ascending lists and not in the other.
fn differing(a: &[usize], b: &[usize]) -> usize {
    let only = |a: &[usize], b: &[usize]| a.iter().filter(|&row| b.binary_search(row).is_err()).count();
    only(a, b) + only(b, a)
}

/// One Gauss–Newton step of all corrected masses; true when one moved by more than [`STILL`].
fn corrected(linearisation: &Linearisation<'_>, found: &mut [Candidate]) -> Result<bool, DiscoverError> {
    /// Relative to the declared mass.
    const STILL: f64 = 1e-5;
    let mut columns = Vec::new();
    let mut loads = Vec::new();
    for candidate in found {
        if let Change::CorrectLoad { level, mass, deviation, .. } = &mut candidate.change {
            let column = linearisation.heavier(*mass, None)?;
            if column.norm() > 0.0 {
                columns.push(column.column(0).into_owned());
                loads.push((level, mass, deviation));
            }
        }
    }
    if columns.is_empty() {
        return Ok(false);
    }
    let moves =
        Likelihood::new(linearisation, &DMatrix::from_columns(&columns), &Visits::of(linearisation.data))?;
    let mut moved = false;
    for (k, (level, mass, deviation)) in loads.into_iter().enumerate() {
        let next = (*mass + moves.coefficients[k]).max(0.0);
        *deviation = moves.deviation(k);
        moved |= (next - *mass).abs() > STILL * level.abs().max(1.0);
        *mass = next;
    }
    Ok(moved)
}
