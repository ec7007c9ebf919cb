//! Whitened numbers of a block: what the model's coefficients do to them, what candidates beside it would do, and what is left.

use crate::census::blocks::Blocks;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::options::DiscoverOptions;
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, Visits};
use truepose_identify::Fit;
use truepose_identify::engine::dense;

/// A block of m numbers.
pub(crate) struct White {
    /// A, m × r.
    pub base: DMatrix<f64>,
    /// X, m × k, per expected size.
    pub columns: DMatrix<f64>,
    /// r.
    pub residual: DVector<f64>,
}

impl White {
    /// Linearised at one fit, with the residual of another one's coefficients in the linearised problem; columns of these effects, side by side.
    ///
    /// Where the joints scatter, numbers of a pose are whitened together, and are taken one by one; else in blocks of rows.
    pub fn of(
        (block, blocks): (&Dataset, &Blocks),
        (at, of): (&Fit, &Fit),
        effects: &[Box<dyn AnyEffect>],
        options: &DiscoverOptions,
    ) -> Result<Self, DiscoverError> {
        let kept = |fit: &Fit| {
            let own = &at.reduction.kept;
            DVector::from_iterator(own.len(), own.iter().map(|&k| fit.fitted.coefficients()[k]))
        };
        if blocks.joints_scatter() {
            let linearisation = blocks.linearised(at, block, options)?;
            let whitener = linearisation.whitener(linearisation.noise);
            let residual = &linearisation.y - &linearisation.base * kept(of);
            let mut residual = DMatrix::from_column_slice(residual.len(), 1, residual.as_slice());
            whitener.apply(&mut residual);
            return Ok(White {
                base: whitener.of(&linearisation.base),
                columns: whitener.of(&linearisation.columns(effects)?),
                residual: residual.column(0).into_owned(),
            });
        }
        let model = at.fitted.model();
        let known = model.columns().len();
        let all: Vec<Box<dyn AnyEffect>> = model.effects().iter().chain(effects).cloned().collect();
        let beside = ErrorModel::new(model.shared_chain(), all)?;
        let mut coefficients = at.fitted.coefficients().to_vec();
        coefficients.resize(beside.columns().len(), 0.0);
        let wanted: Vec<usize> =
            at.reduction.kept.iter().copied().chain(known..beside.columns().len()).collect();
        let noise = blocks.noise_of(at).rows;
        let whole = dense(&beside, block, &Visits::of(block), noise, &coefficients, Some(&wanted))?;
        let (r, k) = (at.reduction.kept.len(), beside.columns().len() - known);
        let base = whole.columns(0, r).into_owned();
        let mut columns = whole.columns(r, k).into_owned();
        for (mut column, described) in columns.column_iter_mut().zip(&beside.columns()[known..]) {
            column *= described.scale;
        }
        let residual = whole.column(r + k) - &base * (kept(of) - kept(at));
        Ok(White { base, columns, residual })
    }

    /// How many unknowns a candidate has; none where the block lacks a covariate of it.
    pub fn width_of(candidate: &Candidate, at: &Fit, block: &Dataset) -> Option<usize> {
        let model = ErrorModel::new(at.fitted.model().shared_chain(), candidate.effects().to_vec()).ok()?;
        model.bind(&block.schema).ok()?;
        Some(model.columns().len())
    }
}
