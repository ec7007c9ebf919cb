//! Effects with rescaled expected sizes, which carry a prior width that was estimated from the data.
//!
//! The expected sizes of an effect's columns are multiplied by the ratio of the estimated prior standard
//! deviation to the nominal one. Each column of a declared effect gets the width of its variance group from
//! the fit of the declared model, so that findings do not change the prior of declared errors. All columns of
//! a finding get one width, 2 w of the contest: many weakly determined coefficients (a spline) are shrunk
//! towards zero, a single well determined one is not.

use truepose_errormodel::lanes::{LaneEmission, LanePosture};
use truepose_errormodel::{AnyEffect, Column, Emission, ModelError, Shape, Signal};
use truepose_identify::Fit;
use truepose_kinematics::{Chain, JointId, Posture};

/// The declared effects with the prior widths of the fit of the declared model, relative to its κ.
pub(crate) fn as_fitted(declared: &[Box<dyn AnyEffect>], fit: &Fit) -> Vec<Box<dyn AnyEffect>> {
    let model = fit.fitted.model();
    let widths = fit.prior.widths_of_columns(model);
    let mut wide: Vec<Box<dyn AnyEffect>> = Vec::new();
    for (k, effect) in declared.iter().enumerate() {
        let stretches = Stretches::Each(widths[model.columns_of(k)].to_vec());
        wide.push(Box::new(Wide { effect: effect.clone(), stretches }));
    }
    wide
}

/// Factors of the expected sizes of columns.
#[derive(Debug, Clone)]
pub(crate) enum Stretches {
    /// One factor for all columns.
    All(f64),
    /// One factor for each column.
    Each(Vec<f64>),
}

/// An effect with scaled expected sizes.
#[derive(Debug, Clone)]
pub(crate) struct Wide {
    pub effect: Box<dyn AnyEffect>,
    pub stretches: Stretches,
}

impl AnyEffect for Wide {
    fn kind(&self) -> &'static str {
        self.effect.kind()
    }
    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let mut columns = self.effect.columns(chain);
        match &self.stretches {
            Stretches::All(stretch) => columns.iter_mut().for_each(|column| column.scale *= stretch),
            Stretches::Each(each) => columns.iter_mut().zip(each).for_each(|(column, s)| column.scale *= s),
        }
        columns
    }
    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        self.effect.eval(at, out);
    }
    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        self.effect.eval_lanes(at, out)
    }
    fn springs(&self, chain: &Chain) -> Option<Vec<JointId>> {
        self.effect.springs(chain)
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
        Box::new(Wide { effect: self.effect.with_shape(values), stretches: self.stretches.clone() })
    }
    fn parameters(&self) -> serde_json::Value {
        self.effect.parameters()
    }
    fn boxed(&self) -> Box<dyn AnyEffect> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::effects::JointCompliance;
    use truepose_kinematics::samples;

    #[test]
    fn a_wide_effect_differs_in_its_expected_sizes_alone() {
        let chain = samples::ur10();
        let plain: Box<dyn AnyEffect> = Box::new(JointCompliance::default());
        let count = plain.columns(&chain).len();
        let each: Vec<f64> = (1..=count).map(|k| k as f64).collect();
        let wide = Wide { effect: plain.clone(), stretches: Stretches::Each(each.clone()) };
        // It is written as the same effect, and is evaluated in batches like it.
        assert_eq!((wide.kind(), wide.parameters()), (plain.kind(), plain.parameters()));
        assert_eq!(wide.springs(&chain), plain.springs(&chain));
        for ((wide, plain), stretch) in wide.columns(&chain).iter().zip(plain.columns(&chain)).zip(each) {
            assert!((wide.scale - stretch * plain.scale).abs() < 1e-12 * plain.scale);
            assert_eq!((&wide.name, wide.bounds), (&plain.name, plain.bounds));
        }
    }
}
