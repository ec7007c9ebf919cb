//! What an export cannot carry, and the error that is left without it.
//!
//! The error left is the distance between the fitted model and the export at configurations spread over the joints'
//! ranges (those of the fit's domain where it has one), under the caller's conditions.

use crate::CompensateError;
use crate::accuracy::everything;
use nalgebra::Vector3;
use truepose_errormodel::FittedModel;
use truepose_kinematics::{Chain, Conditions, TargetId};

/// Under which conditions, and where, an export is held against the model.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportOptions {
    /// Load, time, approach and channels (in the order of the fit's); joints are not read.
    pub conditions: Conditions,
    /// Which point; none is the tool's origin.
    pub target: Option<TargetId>,
    /// How many configurations.
    pub samples: usize,
}

impl Default for ExportOptions {
    fn default() -> Self {
        ExportOptions { conditions: Conditions::default(), target: None, samples: 500 }
    }
}

/// Distance between the fitted model and an export, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorLeft {
    /// Root of the mean square.
    pub rms: f64,
    /// Largest.
    pub max: f64,
}

/// An export with what it lacks.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported<T> {
    /// The export.
    pub value: T,
    /// Families of the model's effects that it does not carry, each once.
    pub left_out: Vec<&'static str>,
    /// The error left without them.
    pub error_left: ErrorLeft,
}

/// Compares a prediction of the target's position with the model's.
pub(super) fn error_left(
    fitted: &FittedModel,
    options: &ExportOptions,
    mut exported: impl FnMut(&[f64]) -> Vector3<f64>,
) -> Result<ErrorLeft, CompensateError> {
    if options.samples == 0 || options.samples > 1_000_000 {
        let value = options.samples as f64;
        return Err(CompensateError::Option { option: "samples", value, need: "1 to 1 000 000" });
    }
    let (schema, mut conditions) = everything(fitted, &options.conditions)?;
    let mut predictor = fitted.bind(&schema)?;
    let ranges = ranges(fitted);
    let (mut sum, mut max) = (0.0, 0.0);
    for i in 0..options.samples {
        for (k, &(lower, upper)) in ranges.iter().enumerate() {
            // A Kronecker sequence: multiples of the square roots of primes, modulo one.
            let share = (0.5 + (i + 1) as f64 * ROOTS[k % ROOTS.len()].sqrt()).fract();
            conditions.joints[k] = lower + (upper - lower) * share;
        }
        let real = predictor.predict(&conditions, options.target).translation;
        let off = (real - exported(&conditions.joints)).norm();
        sum += off * off;
        max = f64::max(max, off);
    }
    Ok(ErrorLeft { rms: (sum / options.samples as f64).sqrt(), max })
}

const ROOTS: [f64; 16] =
    [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0, 41.0, 43.0, 47.0, 53.0];

/// The range of every joint: the fit's domain, else the limits, else a turn and a metre.
pub(super) fn ranges(fitted: &FittedModel) -> Vec<(f64, f64)> {
    let chain: &Chain = fitted.chain();
    let of = |(k, &joint): (usize, &_)| {
        let described = chain.joint(joint);
        let half = if described.unit() == "m" { 0.5 } else { std::f64::consts::PI };
        let limits =
            described.limits.filter(|(l, u)| l.is_finite() && u.is_finite()).unwrap_or((-half, half));
        fitted.domain.joints.get(k).map_or(limits, |range| (range.lower, range.upper))
    };
    chain.movable().iter().enumerate().map(of).collect()
}

/// Families of the effects that are not constant generalized errors.
pub(super) fn not_constant(fitted: &FittedModel) -> Vec<&'static str> {
    let model = fitted.model();
    let mut left: Vec<&'static str> = Vec::new();
    for (k, effect) in model.effects().iter().enumerate() {
        let constant = model.columns()[model.columns_of(k)].iter().all(|c| c.site.is_some());
        let silent = fitted.coefficients()[model.columns_of(k)].iter().all(|&c| c == 0.0);
        if !constant && !silent && !left.contains(&effect.kind()) {
            left.push(effect.kind());
        }
    }
    left
}
