//! The model as it stands while the loop runs: what was declared, what was found, which rows are kept out.

use crate::data::payload::{with_loads, without};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::{Candidate, Change};

use crate::options::DiscoverOptions;
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Scene;
use crate::problem::outliers::{Outliers, outliers};
use nalgebra::DMatrix;
use std::borrow::Cow;
use std::ops::Range;
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, Term, Visits};
use truepose_identify::{Fit, FitOptions, PriorStrength, fit, fit_again};
use truepose_kinematics::Chain;
use truepose_solvers::Solver;

/// What does not change while the loop runs.
#[derive(Clone)]
pub(crate) struct Ground<'a> {
    pub chain: &'a Chain,
    /// The declared effects, as wide as the fit of the declared model found them.
    pub declared: &'a [Box<dyn AnyEffect>],
    pub data: &'a Dataset,
    pub solver: &'a dyn Solver,
    pub fit: FitOptions,
    /// How to search.
    pub options: &'a DiscoverOptions,
}

/// A model with its fit.
pub(crate) struct Working {
    pub found: Vec<Candidate>,
    pub outliers: Outliers,
    /// The data with corrected loads and without the rows that are kept out.
    pub data: Dataset,
    pub fit: Fit,
}

/// Times that outliers are looked at again, and loads: their masses move with the stiffnesses that carry them.
const LOOKS: usize = 4;
const LOOKS_AT_LOADS: usize = 8;

impl Ground<'_> {
    /// Fits the declared model with these finds; rows that nothing explains are kept out, corrected loads are found.
    pub fn working(&self, found: Vec<Candidate>, known: &[usize]) -> Result<Working, DiscoverError> {
        self.working_from(found, known, None)
    }

    /// As [`Self::working`], from the fit of the same model to other data.
    pub fn working_from(
        &self,
        found: Vec<Candidate>,
        known: &[usize],
        start: Option<&Fit>,
    ) -> Result<Working, DiscoverError> {
        let mut found = found;
        let mut out = known.to_vec();
        let mut looks = 0;
        let mut last = start.map(Cow::Borrowed);
        loop {
            let data = self.prepared(&found, &out);
            let fit = match &last {
                None => self.fitted(&found, &data)?,
                Some(last) => fit_again(last, &data, self.solver, &self.fit)?,
            };
            let scene = Scene::new(&fit, &data)?;
            let moved = corrected(&scene, &mut found)?;
            // Every row is judged, those that are kept out as well.
            let whole = self.prepared(&found, &[]);
            let judged = Scene::new(&fit, &whole)?;
            let residual = &judged.y - &judged.base * judged.coefficients();
            let outliers = outliers(&judged, residual.as_slice(), fit.noise);
            looks += 1;
            // Of thousands of rows one or the other always stands on the threshold.
            let settled = differing(&outliers.suspects, &out) <= whole.len() / 2000;
            let most = if moved { LOOKS_AT_LOADS } else { LOOKS };
            if (settled && !moved) || looks > most {
                return Ok(Working { found, outliers, data, fit });
            }
            out.clone_from(&outliers.suspects);
            last = Some(Cow::Owned(fit));
        }
    }

    /// The effects of the model that belong to the k-th of these finds.
    pub fn effects_of(&self, found: &[Candidate], which: usize) -> Range<usize> {
        let before: usize = found[..which].iter().map(|candidate| candidate.effects().len()).sum();
        let first = self.declared.len() + before;
        first..first + found[which].effects().len()
    }

    /// The fit of the declared model with these finds.
    pub fn fitted(&self, found: &[Candidate], data: &Dataset) -> Result<Fit, DiscoverError> {
        self.fitted_by(found, data, &self.fit)
    }

    /// As [`Self::fitted`], in another way.
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

    /// The data with loads as they were found and without these rows.
    pub fn prepared(&self, found: &[Candidate], out: &[usize]) -> Dataset {
        without(&with_loads(self.data, found), out)
    }
}

/// How many rows are in one of two ascending lists and not in the other.
fn differing(a: &[usize], b: &[usize]) -> usize {
    let only = |a: &[usize], b: &[usize]| a.iter().filter(|&row| b.binary_search(row).is_err()).count();
    only(a, b) + only(b, a)
}

/// Moves corrected loads, all together, to where the present model sees them; true when one moved.
fn corrected(scene: &Scene<'_>, found: &mut [Candidate]) -> Result<bool, DiscoverError> {
    /// kg, relative to the level.
    const STILL: f64 = 1e-5;
    let mut columns = Vec::new();
    let mut loads = Vec::new();
    for candidate in found {
        if let Change::CorrectLoad { level, mass, deviation } = &mut candidate.change {
            let column = scene.heavier(*mass)?;
            if column.norm() > 0.0 {
                columns.push(column.column(0).into_owned());
                loads.push((level, mass, deviation));
            }
        }
    }
    if columns.is_empty() {
        return Ok(false);
    }
    let moves = Likelihood::new(scene, &DMatrix::from_columns(&columns), &Visits::of(scene.data))?;
    let mut moved = false;
    for (k, (level, mass, deviation)) in loads.into_iter().enumerate() {
        let next = (*mass + moves.coefficients[k]).max(0.0);
        *deviation = moves.deviation(k);
        moved |= (next - *mass).abs() > STILL * level.abs().max(1.0);
        *mass = next;
    }
    Ok(moved)
}
