//! A find with a prior of its own: as wide as its coefficients turned out to be.
//!
//! The prior of the declared model says how far declared errors lie from their expected sizes; what is found may be larger or
//! smaller. Its columns' expected sizes are stretched so that the prior's standard deviation is `width` of the original ones:
//! many weakly determined coefficients (a spline) are held together, a single clear one is left alone.

use truepose_errormodel::{AnyEffect, Column, Emission, ModelError, Shape, Signal};
use truepose_kinematics::{Chain, Posture};

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
