//! An effect with a prior of its own: as wide as its coefficients turned out to be.
//!
//! The prior of the declared model says how far declared errors lie from their expected sizes; what is found may be larger or
//! smaller. Its columns' expected sizes are stretched so that the prior's standard deviation is `width` of the original ones:
//! many weakly determined coefficients (a spline) are held together, a single clear one is left alone.

use crate::law::Law;
use crate::likelihood::WIDE;
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::{AnyEffect, Column, Emission, ModelError, Shape, Signal};
use truepose_identify::Fit;
use truepose_kinematics::{Chain, Posture};

/// The declared effects, those that lie far beyond their expected sizes with wider ones. One κ for all is that of the majority: a drive
/// softer than all others would be held stiff, and found again as something new. None when all are within them.
pub(crate) fn relaxed(declared: &[Box<dyn AnyEffect>], fit: &Fit) -> Option<Vec<Box<dyn AnyEffect>>> {
    /// Times κ that an effect has to lie beyond.
    const FAR: f64 = 3.0;
    let (model, kept) = (fit.fitted.model(), &fit.reduction.kept);
    let sizes: Vec<f64> = kept.iter().map(|&column| model.columns()[column].scale).collect();
    let scaled = DMatrix::from_fn(kept.len(), kept.len(), |i, j| fit.factor.r[(i, j)] * sizes[j]);
    let open = DMatrix::identity(kept.len(), kept.len()) / (WIDE * WIDE);
    let covariance = (scaled.tr_mul(&scaled) + open).cholesky()?.inverse();
    let values: DVector<f64> = &covariance * scaled.tr_mul(&fit.factor.z.column(0));
    let stretch = |effect: usize| -> Option<f64> {
        let own: Vec<usize> = (0..kept.len()).filter(|&k| model.effect_of(kept[k]) == effect).collect();
        if own.is_empty() {
            return None;
        }
        let values = DVector::from_iterator(own.len(), own.iter().map(|&k| values[k]));
        let law = Law::of(&values, &covariance.select_rows(&own).select_columns(&own));
        (law.width > FAR * fit.prior.kappa).then_some(2.0 * law.width / fit.prior.kappa)
    };
    let stretches: Vec<Option<f64>> = (0..declared.len()).map(stretch).collect();
    if stretches.iter().all(Option::is_none) {
        return None;
    }
    let mut relaxed = declared.to_vec();
    for (effect, stretch) in relaxed.iter_mut().zip(stretches) {
        if let Some(stretch) = stretch {
            *effect = Box::new(Wide { effect: effect.clone(), stretch });
        }
    }
    Some(relaxed)
}

/// An effect whose expected sizes are stretched.
#[derive(Debug, Clone)]
pub(crate) struct Wide {
    pub effect: Box<dyn AnyEffect>,
    pub stretch: f64,
}

impl AnyEffect for Wide {
    fn kind(&self) -> &'static str {
        self.effect.kind()
    }
    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let mut columns = self.effect.columns(chain);
        columns.iter_mut().for_each(|column| column.scale *= self.stretch);
        columns
    }
    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        self.effect.eval(at, out);
    }
    fn needs(&self) -> Vec<Signal> {
        self.effect.needs()
    }
    fn settles(&self) -> bool {
        self.effect.settles()
    }
    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        self.effect.validate(chain)
    }
    fn shape(&self) -> Vec<Shape> {
        self.effect.shape()
    }
    fn with_shape(&self, values: &[f64]) -> Box<dyn AnyEffect> {
        Box::new(Wide { effect: self.effect.with_shape(values), stretch: self.stretch })
    }
    fn parameters(&self) -> serde_json::Value {
        self.effect.parameters()
    }
    fn boxed(&self) -> Box<dyn AnyEffect> {
        Box::new(self.clone())
    }
}
