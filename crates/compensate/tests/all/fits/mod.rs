//! Fitted models to compensate: the sample robots with errors as large as real ones.

// Every test binary takes what it needs.
#![allow(dead_code)]

use truepose_compensate::Target;
use truepose_errormodel::effects::{Basis, Expansion, Factor, Geometric, Input, JointCompliance, Place};
use truepose_errormodel::{AnyEffect, Column, ErrorModel, FittedModel};
use truepose_kinematics::nalgebra::{DMatrix, Vector3};
use truepose_kinematics::{Chain, Conditions, JointId, Load, Payload, Pose};

/// Numbers from −1 to 1.
#[derive(Debug, Clone)]
pub struct Draw(pub u64);

impl Draw {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Joints within a share of their limits; a turn either way, half a metre either way, where there are none.
    pub fn joints(&mut self, chain: &Chain, share: f64) -> Vec<f64> {
        let range = |&joint| chain.joint(joint).limits.unwrap_or((-0.5, 0.5));
        let ranges: Vec<(f64, f64)> = chain.movable().iter().map(range).collect();
        ranges
            .into_iter()
            .map(|(lower, upper)| {
                let (lower, upper) = (lower.max(-std::f64::consts::PI), upper.min(std::f64::consts::PI));
                0.5 * (lower + upper) + share * 0.5 * (upper - lower) * self.next()
            })
            .collect()
    }
}

/// Constant errors of every frame and target, joints that yield, and a gear's error in every joint that turns.
pub fn fitted(chain: &Chain, seed: u64) -> FittedModel {
    let mut effects: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    effects.push(Box::new(JointCompliance::default()));
    for &joint in chain.movable() {
        if chain.joint(joint).unit() == "rad" {
            let basis = Basis::Fourier { period: std::f64::consts::TAU, harmonics: vec![1, 2] };
            effects.push(Box::new(Expansion {
                at: Place::Motion { joint },
                factors: vec![Factor { of: Input::Joint(joint), basis }],
            }));
        }
    }
    of(chain, effects, seed)
}

/// Constant errors and joints that yield: what the benchmark has.
pub fn elastic(chain: &Chain, seed: u64) -> FittedModel {
    of(chain, vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())], seed)
}

/// The first joint that turns has play: half of it to either side of its approach.
pub fn with_backlash(chain: &Chain, joint: JointId, half: f64) -> FittedModel {
    let factors = vec![Factor { of: Input::Approach(joint), basis: Basis::Powers(vec![1]) }];
    let effect = Expansion { at: Place::Motion { joint }, factors };
    let model = ErrorModel::new(chain.clone(), vec![Box::new(effect)]).expect("a model");
    FittedModel::new(model, vec![-half], DMatrix::zeros(1, 1)).expect("a fit")
}

pub fn of(chain: &Chain, effects: Vec<Box<dyn AnyEffect>>, seed: u64) -> FittedModel {
    let model = ErrorModel::new(chain.clone(), effects).expect("a model");
    let mut draw = Draw(seed);
    let size = |column: &Column, draw: &mut Draw| {
        let r = draw.next();
        if column.name.starts_with("compliance") {
            // 0.2 … 0.6 rad/(MN·m); the heavy arm's shoulder then sinks by some milliradians.
            column.scale * (if column.unit.starts_with("rad") { 0.04 } else { 0.4 }) * (1.0 + 0.5 * r)
        } else {
            column.scale * 0.5 * r
        }
    };
    let coefficients: Vec<f64> = model.columns().iter().map(|column| size(column, &mut draw)).collect();
    let n = coefficients.len();
    let covariance =
        DMatrix::from_fn(n, n, |a, b| if a == b { (1e-2 * coefficients[a]).powi(2) } else { 0.0 });
    FittedModel::new(model, coefficients, covariance).expect("a fit")
}

/// The paper's heavier load, for arms that can carry it.
pub fn load(chain: &Chain) -> Load {
    let mass = match chain.name() {
        "heavy" => 90.0,
        "pps" => 70.0,
        _ => 5.0,
    };
    Load::Payload(Payload { mass, com: Vector3::new(0.02, -0.01, 0.1) })
}

/// The pose where the real robot is under these conditions, as a target.
pub fn target_at(pose: &Pose) -> Target {
    Target::at(pose.translation).turned(pose.rotation)
}

/// The nominal joints, each up to so much (rad or m) away.
pub fn beside(conditions: &Conditions, away: f64, draw: &mut Draw) -> Vec<f64> {
    conditions.joints.iter().map(|q| q + away * draw.next()).collect()
}
