#![doc = include_str!("../README.md")]

use truepose_compensate::Target;
use truepose_errormodel::effects::{Geometric, JointCompliance};
use truepose_errormodel::{AnyEffect, Column, ErrorModel, FittedModel};
use truepose_kinematics::nalgebra::{DMatrix, Vector3};
use truepose_kinematics::{Chain, Load, Payload, Pose};

/// Numbers from −1 to 1.
#[derive(Debug, Clone)]
pub struct Draw(pub u64);

impl Draw {
    /// The next number.
    pub fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Joints within a share of their limits; half a unit either way where there are none.
    pub fn joints(&mut self, chain: &Chain, share: f64) -> Vec<f64> {
        let range = |&joint| chain.joint(joint).limits.unwrap_or((-0.5, 0.5));
        let ranges: Vec<(f64, f64)> = chain.movable().iter().map(range).collect();
        ranges
            .into_iter()
            .map(|(lower, upper)| {
                let (lower, upper) = (lower.max(-std::f64::consts::PI), upper.min(std::f64::consts::PI));
                0.5 * (lower + upper) + share * 0.5 * (upper - lower) * self.number()
            })
            .collect()
    }
}

/// A fit of constant errors and joint compliances, as large as real ones.
///
/// # Panics
///
/// Where the effects do not fit the chain, which is a fault of a benchmark.
#[allow(clippy::unwrap_used, reason = "for benchmarks")]
pub fn elastic(chain: &Chain, seed: u64) -> FittedModel {
    let effects: Vec<Box<dyn AnyEffect>> =
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())];
    let model = ErrorModel::new(chain.clone(), effects).unwrap();
    let mut draw = Draw(seed);
    let mut size = |column: &Column| {
        let r = draw.number();
        if column.name.starts_with("compliance") {
            // 0.2 … 0.6 rad/(MN·m); the heavy arm's shoulder then sinks by some milliradians.
            column.scale * (if column.unit.starts_with("rad") { 0.04 } else { 0.4 }) * (1.0 + 0.5 * r)
        } else {
            column.scale * 0.5 * r
        }
    };
    let coefficients: Vec<f64> = model.columns().iter().map(&mut size).collect();
    let n = coefficients.len();
    let covariance =
        DMatrix::from_fn(n, n, |a, b| if a == b { (1e-2 * coefficients[a]).powi(2) } else { 0.0 });
    FittedModel::new(model, coefficients, covariance).unwrap()
}

/// A heavy load, for arms that can carry it.
pub fn load(chain: &Chain) -> Load {
    let mass = match chain.name() {
        "heavy" => 90.0,
        "pps" => 70.0,
        _ => 5.0,
    };
    Load::Payload(Payload { mass, com: Vector3::new(0.02, -0.01, 0.1) })
}

/// A pose as a target.
pub fn target_at(pose: &Pose) -> Target {
    Target::at(pose.translation).turned(pose.rotation)
}
