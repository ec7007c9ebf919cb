//! An effect whose unknowns a user holds between bounds.

use crate::lanes::{LaneEmission, LanePosture};
use crate::{AnyEffect, Column, Emission, ModelError, Shape, Signal};
use truepose_kinematics::{Chain, JointId, Posture};

/// Another effect, all of its unknowns between two bounds. It is the same effect in every other respect, in files as well:
/// bounds belong to a fit, not to what was fitted.
#[derive(Debug, Clone)]
pub struct Limited {
    effect: Box<dyn AnyEffect>,
    bounds: [f64; 2],
}

impl Limited {
    /// Holds an effect's unknowns between `bounds`, in their own unit; either may be infinite.
    ///
    /// # Errors
    /// When they are not in ascending order.
    pub fn new(effect: Box<dyn AnyEffect>, bounds: [f64; 2]) -> Result<Self, ModelError> {
        let [lower, upper] = bounds;
        if lower < upper {
            return Ok(Limited { effect, bounds });
        }
        let reason = format!("`bounds` have to ascend, not [{lower}, {upper}]");
        Err(ModelError::Parameters { kind: effect.kind().into(), reason })
    }
}

impl AnyEffect for Limited {
    fn kind(&self) -> &'static str {
        self.effect.kind()
    }
    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let [lower, upper] = self.bounds;
        self.effect.columns(chain).into_iter().map(|column| column.within(lower, upper)).collect()
    }
    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        self.effect.eval(at, out);
    }
    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        self.effect.eval_lanes(at, out)
    }
    fn needs(&self) -> Vec<Signal> {
        self.effect.needs()
    }
    fn settles(&self) -> bool {
        self.effect.settles()
    }
    fn springs(&self, chain: &Chain) -> Option<Vec<JointId>> {
        self.effect.springs(chain)
    }
    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        self.effect.validate(chain)
    }
    fn shape(&self) -> Vec<Shape> {
        self.effect.shape()
    }
    fn with_shape(&self, values: &[f64]) -> Box<dyn AnyEffect> {
        Box::new(Limited { effect: self.effect.with_shape(values), bounds: self.bounds })
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
    use crate::effects::{JointCompliance, Transmission};
    use truepose_kinematics::samples;

    #[test]
    fn it_is_the_same_effect_between_bounds() {
        let chain = samples::ur10();
        let plain: Box<dyn AnyEffect> = Box::new(JointCompliance::default());
        let limited = Limited::new(plain.clone(), [0.0, 1e-5]).unwrap();
        assert_eq!(limited.parameters(), plain.parameters());
        assert_eq!(limited.kind(), "joint_compliance");
        assert_eq!(limited.springs(&chain), Some(chain.movable().to_vec()));
        for (column, bare) in limited.columns(&chain).iter().zip(plain.columns(&chain)) {
            assert_eq!(column.bounds.map(f64::to_bits), [0.0, 1e-5].map(f64::to_bits));
            assert!(bare.bounds[0] >= 0.0 && bare.bounds[1] == f64::INFINITY, "a compliance is not negative");
        }
        let free = Transmission { period_range: Some([0.1, 2.0]), ..Transmission::of(JointId(2), 1.0) };
        let moved = Limited::new(Box::new(free), [-1e-3, 1e-3]).unwrap().with_shape(&[0.5]);
        assert!((moved.shape()[0].value - 0.5).abs() < 1e-15);
        assert_eq!(moved.columns(&chain)[0].bounds.map(f64::to_bits), [-1e-3, 1e-3].map(f64::to_bits));
    }

    #[test]
    fn bounds_ascend() {
        let error = Limited::new(Box::new(JointCompliance::default()), [1.0, 0.0]).unwrap_err();
        assert!(error.to_string().contains("[1, 0]"), "{error}");
    }
}
