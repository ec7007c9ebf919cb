//! Fits for the tests of the border, with errors as large as real ones.

// Every test binary takes what it needs.
#![allow(dead_code)]

use std::sync::Arc;
use truepose_errormodel::effects::{Basis, Expansion, Factor, Geometric, Input, JointCompliance, Place};
use truepose_errormodel::{AnyEffect, Channel, ErrorModel, Fallback, FittedModel, Installed};
use truepose_kinematics::nalgebra::DMatrix;
use truepose_kinematics::{Chain, Coupling, Pose, samples};

fn of(chain: &Chain, effects: Vec<Box<dyn AnyEffect>>) -> FittedModel {
    let model = ErrorModel::new(chain.clone(), effects).unwrap();
    let mut draw = 5u64;
    let mut next = || {
        draw = draw.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (draw >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let coefficients: Vec<f64> = model.columns().iter().map(|column| 0.3 * column.scale * next()).collect();
    let n = coefficients.len();
    let covariance =
        DMatrix::from_fn(n, n, |a, b| if a == b { (1e-2 * coefficients[a]).powi(2) } else { 0.0 });
    FittedModel::new(model, coefficients, covariance).unwrap()
}

/// Constant errors and joints that yield.
pub fn elastic(chain: &Chain) -> FittedModel {
    of(chain, vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())])
}

/// The same on a robot whose third joint follows the second.
pub fn coupled() -> FittedModel {
    let chain = samples::ur10();
    let movable = chain.movable().to_vec();
    let coupling = Coupling { joint: movable[2], driver: movable[1], factor: -1.0 };
    elastic(&chain.with_couplings(vec![coupling]).unwrap())
}

/// With a finding, of which commands and predictions take a part.
pub fn with_findings(chain: &Chain) -> FittedModel {
    let declared = elastic(chain);
    let basis = Basis::Fourier { period: std::f64::consts::TAU, harmonics: vec![1] };
    let joint = chain.movable()[1];
    let finding =
        Expansion { at: Place::Motion { joint }, factors: vec![Factor { of: Input::Joint(joint), basis }] };
    let effects: Vec<Box<dyn AnyEffect>> =
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default()), Box::new(finding)];
    let fallback = Fallback { declared: Arc::new(declared), usual: 1e-12, scale: 1e-8, size: 1e-8 };
    of(chain, effects).with_fallback(Some(fallback))
}

/// A joint that moves with a temperature.
pub fn thermal() -> FittedModel {
    let chain = samples::ur10();
    let joint = chain.movable()[1];
    let factors = vec![Factor { of: Input::Channel("temperature".into()), basis: Basis::Powers(vec![1]) }];
    let effect = Expansion { at: Place::Motion { joint }, factors };
    let channel = Channel { name: "temperature".into(), unit: "degC".into(), temperature: true };
    of(&chain, vec![Box::new(effect)]).with_channels(vec![channel])
}

/// One robot in two installations, 2 m apart.
pub fn in_two_halls() -> FittedModel {
    let installed = |name: &str, x: f64| Installed { name: name.into(), frame: Pose::trans(0, x) };
    elastic(&samples::ur10()).with_sessions(vec![installed("hall 1", 0.0), installed("hall 2", 2.0)])
}

/// The fit as a file has it.
pub fn json(fitted: &FittedModel) -> String {
    truepose_io::fit_json("fit.json", fitted).unwrap()
}
