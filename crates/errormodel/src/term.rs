//! An effect as it stands in a model: with the prior scale and the bounds of its columns, where they differ from its own.

use crate::lanes::{LaneEmission, LanePosture};
use crate::{AnyEffect, Column, Emission, ModelError, NonlinearParameter, Signal};
use std::any::Any;
use truepose_kinematics::{Chain, JointId, Posture};

/// An effect whose columns have another prior standard deviation, other bounds, or both. In every other respect, in files as
/// well, it is the effect: scale and bounds belong to a fit, not to what was fitted.
#[derive(Debug, Clone)]
pub struct Term {
    effect: Box<dyn AnyEffect>,
    scale: Scale,
    bounds: Option<[f64; 2]>,
}

/// By what the prior standard deviations of the columns are multiplied.
#[derive(Debug, Clone)]
enum Scale {
    /// All alike.
    All(f64),
    /// Column by column.
    Each(Vec<f64>),
}

impl Term {
    /// The effect with its own scales and bounds.
    pub fn new(effect: Box<dyn AnyEffect>) -> Self {
        Term { effect, scale: Scale::All(1.0), bounds: None }
    }

    /// With the prior standard deviation of every column multiplied by `scale`.
    pub fn scaled(self, scale: f64) -> Self {
        Term { scale: Scale::All(scale), ..self }
    }

    /// With the prior standard deviation of each column multiplied by its own factor, in the order of [`AnyEffect::columns`];
    /// columns without a factor keep theirs.
    pub fn scaled_each(self, scales: Vec<f64>) -> Self {
        Term { scale: Scale::Each(scales), ..self }
    }

    /// With all columns between `bounds`, in their own unit; either may be infinite.
    ///
    /// # Errors
    /// When they are not in ascending order.
    pub fn bounded(self, bounds: [f64; 2]) -> Result<Self, ModelError> {
        let [lower, upper] = bounds;
        if lower < upper {
            return Ok(Term { bounds: Some(bounds), ..self });
        }
        let reason = format!("`bounds` have to ascend, not [{lower}, {upper}]");
        Err(ModelError::Parameters { kind: self.effect.kind().into(), reason })
    }

    /// The effect itself.
    pub fn effect(&self) -> &dyn AnyEffect {
        self.effect.as_ref()
    }
}

impl dyn AnyEffect {
    /// The effect as what it is, with a [`Term`] around it or without; none when it is another one.
    pub fn concrete<E: 'static>(&self) -> Option<&E> {
        let any = self as &dyn Any;
        any.downcast_ref::<E>().or_else(|| any.downcast_ref::<Term>()?.effect().concrete())
    }

    /// Another effect in its place, with the prior scale and the bounds that it has here.
    pub fn replaced(&self, by: Box<dyn AnyEffect>) -> Box<dyn AnyEffect> {
        match (self as &dyn Any).downcast_ref::<Term>() {
            Some(term) => Box::new(Term { effect: term.effect.replaced(by), ..term.clone() }),
            None => by,
        }
    }
}

impl AnyEffect for Term {
    fn kind(&self) -> &'static str {
        self.effect.kind()
    }
    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let mut columns = self.effect.columns(chain);
        match &self.scale {
            Scale::All(scale) => columns.iter_mut().for_each(|column| column.scale *= scale),
            Scale::Each(scales) => columns.iter_mut().zip(scales).for_each(|(column, s)| column.scale *= s),
        }
        if let Some(bounds) = self.bounds {
            columns.iter_mut().for_each(|column| column.bounds = bounds);
        }
        columns
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
    fn load_dependent(&self) -> bool {
        self.effect.load_dependent()
    }
    fn compliances(&self, chain: &Chain) -> Option<Vec<JointId>> {
        self.effect.compliances(chain)
    }
    fn without_time(&self) -> Option<Box<dyn AnyEffect>> {
        self.effect.without_time()
    }
    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        self.effect.validate(chain)
    }
    fn shape(&self) -> Vec<NonlinearParameter> {
        self.effect.shape()
    }
    fn with_nonlinear(&self, values: &[f64]) -> Box<dyn AnyEffect> {
        let effect = self.effect.with_nonlinear(values);
        Box::new(Term { effect, scale: self.scale.clone(), bounds: self.bounds })
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
    use crate::batch::Lanes;
    use crate::effects::{JointCompliance, Landmarks, Point, Transmission};
    use crate::{
        Dataset, DatasetBuilder, Effect, EffectRegistry, ErrorModel, FittedModel, Measurement, ModelError,
        Search,
    };
    use serde::{Deserialize, Serialize};
    use truepose_kinematics::nalgebra::DMatrix;
    use truepose_kinematics::samples;

    /// An effect no method of which answers as the default does. In a block of rows it emits twice what it emits in a single row, so that a
    /// test sees which of the two was called.
    #[derive(Debug, Clone, Serialize, Deserialize)]
    struct Unusual {
        length: f64,
    }

    impl Effect for Unusual {
        const FAMILY: &'static str = "test/unusual";
        fn columns(&self, chain: &Chain) -> Vec<Column> {
            let named = |k: usize| Column::new(format!("unusual {k}"), "m", 2.0 + k as f64).within(-3.0, 4.0);
            (0..chain.movable().len()).map(named).collect()
        }
        fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
            if let Some(motion) = at.chain().joint_motion(at.chain().movable()[0]) {
                out.along(0, &motion, self.length);
            }
        }
        fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
            if let Some(motion) = at.chain().joint_motion(at.chain().movable()[0]) {
                let length = out.value(|numbers| numbers.fill(2.0 * self.length));
                out.along(0, &motion, length);
            }
            true
        }
        fn needs(&self) -> Vec<Signal> {
            vec![Signal::Time]
        }
        fn load_dependent(&self) -> bool {
            false
        }
        fn compliances(&self, chain: &Chain) -> Option<Vec<JointId>> {
            Some(chain.movable().to_vec())
        }
        fn validate(&self, _chain: &Chain) -> Result<(), ModelError> {
            match self.length > 0.0 {
                true => Ok(()),
                false => Err(ModelError::Shape { what: "length", have: 0, need: 1 }),
            }
        }
        fn shape(&self) -> Vec<NonlinearParameter> {
            let (name, unit) = ("length".to_owned(), "m".to_owned());
            vec![NonlinearParameter {
                name,
                unit,
                value: self.length,
                lower: 0.1,
                upper: 9.0,
                search: Search::Smooth,
            }]
        }
        fn with_nonlinear(&self, values: &[f64]) -> Self {
            Unusual { length: values[0] }
        }
    }

    /// Rows with a time.
    fn rows(chain: &Chain, count: usize) -> Dataset {
        let mut builder = DatasetBuilder::new(chain);
        for row in 0..count {
            let joints: Vec<f64> = (0..chain.movable().len()).map(|j| 0.1 * (row + j) as f64).collect();
            builder.push(Measurement::at(joints).position([0.0; 3]).time(row as f64)).unwrap();
        }
        builder.finish()
    }

    /// What is left of the measured positions after a model with all coefficients 1e-4, to the bit.
    fn residual_bits(effect: Box<dyn AnyEffect>, chain: &Chain) -> Vec<u64> {
        let model = ErrorModel::new(chain.clone(), vec![effect]).unwrap();
        let data = rows(chain, 20);
        let mut lanes = Lanes::new(model.bind(&data.schema).unwrap());
        let all: Vec<usize> = (0..20).collect();
        lanes.gather(&data, &all);
        lanes.settle(&data, &vec![1e-4; model.columns().len()]);
        let mut left = vec![0.0; 6 * crate::lanes::LANES];
        lanes.left(&data, &vec![0.0; model.columns().len()], &mut left);
        left.iter().map(|v| v.to_bits()).collect()
    }

    #[test]
    fn every_method_is_forwarded() {
        let chain = samples::ur10();
        let plain: Box<dyn AnyEffect> = Box::new(Unusual { length: 0.5 });
        let term = Term::new(plain.clone());
        assert_eq!(term.kind(), "test/unusual");
        assert_eq!(term.columns(&chain), plain.columns(&chain));
        assert_eq!(term.needs(), [Signal::Time]);
        assert!(!term.load_dependent());
        assert_eq!(term.compliances(&chain), Some(chain.movable().to_vec()));
        assert!(term.validate(&chain).is_ok());
        assert!(Term::new(Box::new(Unusual { length: 0.0 })).validate(&chain).is_err());
        assert_eq!(term.shape(), plain.shape());
        assert!((term.with_nonlinear(&[0.75]).shape()[0].value - 0.75).abs() < 1e-15);
        assert_eq!(term.parameters(), serde_json::json!({ "length": 0.5 }));
        assert_eq!(term.boxed().parameters(), plain.parameters());
        assert_eq!(term.effect().kind(), plain.kind());
    }

    #[test]
    fn a_term_and_the_effect_read_back_from_its_file_are_evaluated_alike() {
        let chain = samples::ur10();
        let registry = EffectRegistry::builtin().with::<Unusual>();
        let effects: [Box<dyn AnyEffect>; 2] =
            [Box::new(Unusual { length: 0.5 }), Box::new(JointCompliance::default())];
        for effect in effects {
            let term: Box<dyn AnyEffect> =
                Box::new(Term::new(effect).scaled(3.0).bounded([-1.0, 1.0]).unwrap());
            let back = registry.build(term.kind(), term.parameters(), &chain).unwrap();
            assert_eq!(residual_bits(term.clone(), &chain), residual_bits(back.clone(), &chain));
            assert_eq!(term.compliances(&chain), back.compliances(&chain));
        }
    }

    #[test]
    fn a_term_changes_scales_and_bounds_and_keeps_them_with_other_nonlinear_parameters() {
        let chain = samples::ur10();
        let plain: Box<dyn AnyEffect> = Box::new(JointCompliance::default());
        let scales: Vec<f64> = (1..=plain.columns(&chain).len()).map(|k| k as f64).collect();
        let term = Term::new(plain.clone()).scaled_each(scales.clone()).bounded([0.0, 1e-5]).unwrap();
        for ((column, own), scale) in term.columns(&chain).iter().zip(plain.columns(&chain)).zip(scales) {
            assert!((column.scale - scale * own.scale).abs() < 1e-12 * own.scale);
            assert_eq!(column.bounds.map(f64::to_bits), [0.0, 1e-5].map(f64::to_bits));
            assert!(own.bounds[0] >= 0.0 && own.bounds[1] == f64::INFINITY, "a compliance is not negative");
        }
        let free = Transmission { period_range: Some([0.1, 2.0]), ..Transmission::of(JointId(2), 1.0) };
        let own = Effect::columns(&free, &chain)[0].scale;
        let moved =
            Term::new(Box::new(free)).scaled(2.0).bounded([-1e-3, 1e-3]).unwrap().with_nonlinear(&[0.5]);
        assert!((moved.shape()[0].value - 0.5).abs() < 1e-15);
        let column = &moved.columns(&chain)[0];
        assert_eq!(column.bounds.map(f64::to_bits), [-1e-3, 1e-3].map(f64::to_bits));
        assert!((column.scale - 2.0 * own).abs() < 1e-15);
    }

    #[test]
    fn terms_of_terms_multiply_their_scales() {
        let chain = samples::ur10();
        let plain: Box<dyn AnyEffect> = Box::new(JointCompliance::default());
        let inner = Term::new(plain.clone()).scaled(2.0).bounded([0.0, 1e-5]).unwrap();
        let outer = Term::new(Box::new(inner)).scaled(3.0);
        let (column, own) = (&outer.columns(&chain)[0], &plain.columns(&chain)[0]);
        assert!((column.scale - 6.0 * own.scale).abs() < 1e-12 * own.scale);
        assert_eq!(column.bounds.map(f64::to_bits), [0.0, 1e-5].map(f64::to_bits));
    }

    #[test]
    fn an_effect_is_found_within_terms_and_replaced_there() {
        let chain = samples::ur10();
        let plain: Box<dyn AnyEffect> = Box::new(JointCompliance::default());
        let inner = Term::new(plain.clone()).scaled(2.0);
        let outer: Box<dyn AnyEffect> = Box::new(Term::new(Box::new(inner)).bounded([0.0, 1e-5]).unwrap());
        assert!(plain.concrete::<JointCompliance>().is_some() && plain.concrete::<Transmission>().is_none());
        assert!(outer.concrete::<JointCompliance>().is_some() && outer.concrete::<Transmission>().is_none());
        let one = JointCompliance { joints: Some(vec![JointId(1)]), ..JointCompliance::default() };
        let replaced = outer.replaced(Box::new(one.clone()));
        assert_eq!(replaced.parameters(), AnyEffect::parameters(&one));
        let (column, own) = (&replaced.columns(&chain)[0], &Effect::columns(&one, &chain)[0]);
        assert!((column.scale - 2.0 * own.scale).abs() < 1e-12 * own.scale);
        assert_eq!(column.bounds.map(f64::to_bits), [0.0, 1e-5].map(f64::to_bits));
        assert_eq!(plain.replaced(Box::new(one.clone())).parameters(), AnyEffect::parameters(&one));
    }

    #[test]
    fn places_of_landmarks_are_read_from_a_model_whose_effects_are_scaled() {
        let chain = samples::ur10();
        let points = vec![Point { name: "A".into(), tied: None }];
        let landmarks: Box<dyn AnyEffect> = Box::new(Landmarks { points });
        let moved = |effect: Box<dyn AnyEffect>| {
            let model = ErrorModel::new(chain.clone(), vec![effect]).unwrap();
            let fitted = FittedModel::new(model, vec![1e-3, -2e-3, 3e-3], DMatrix::zeros(3, 3)).unwrap();
            fitted.landmarks_displaced().unwrap()
        };
        let by = moved(landmarks.clone());
        assert!(by.len() == 1 && by[0].norm() > 1e-4, "{by:?}");
        assert_eq!(by, moved(Box::new(Term::new(landmarks).scaled(3.0))));
    }

    #[test]
    fn bounds_ascend() {
        let error = Term::new(Box::new(JointCompliance::default())).bounded([1.0, 0.0]).unwrap_err();
        assert!(error.to_string().contains("[1, 0]"), "{error}");
    }
}
