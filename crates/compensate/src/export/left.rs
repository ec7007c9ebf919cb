//! What an export cannot carry, and the error that is left without it.
//!
//! The error left is the distance between the fitted model and the export at configurations spread over the joints'
//! ranges (those of the fit's domain where it has one), under the caller's conditions or over all that the fit has seen.

use crate::CompensateError;
use crate::accuracy::everything;
use nalgebra::Vector3;
use truepose_errormodel::{Domain, FittedModel, Interval};
use truepose_kinematics::{Chain, Conditions, Load, Payload, TargetId};

/// Under which conditions, and where, an export is held against the model.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportOptions {
    /// Load, time, approach and channels (in the order of the fit's); joints are not read. None spreads them over the
    /// fit's domain, payloads at the tool's origin, every joint arriving from either side; tables then hold for its middle,
    /// without a load.
    pub conditions: Option<Conditions>,
    /// Which point; none is the tool's origin.
    pub target: Option<TargetId>,
    /// How many configurations.
    pub samples: usize,
}

impl Default for ExportOptions {
    fn default() -> Self {
        ExportOptions { conditions: None, target: None, samples: 2000 }
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

impl<T> Exported<T> {
    /// What the export lacks and what that costs, a sentence a line.
    pub fn statement(&self) -> Vec<String> {
        let lacks = if self.left_out.is_empty() {
            "carries every effect of the fit".into()
        } else {
            format!("cannot carry: {}", self.left_out.join(", "))
        };
        let ErrorLeft { rms, max } = self.error_left;
        let left = format!(
            "error left over the range of the fit: RMS {}, max {}",
            in_millimetres(rms),
            in_millimetres(max)
        );
        vec![lacks, left]
    }
}

fn in_millimetres(metres: f64) -> String {
    if metres < 1e-9 { "below 1 nm".into() } else { format!("{:.6} mm", 1e3 * metres) }
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
    let (schema, mut conditions) = everything(fitted, &table_conditions(fitted, options))?;
    let mut predictor = fitted.bind(&schema)?;
    let ranges = ranges(fitted);
    let n = ranges.len();
    let (mut sum, mut max) = (0.0, 0.0);
    for i in 0..options.samples {
        // A Kronecker sequence: multiples of the square roots of primes, modulo one.
        let share = |k: usize| (0.5 + (i + 1) as f64 * ROOTS[k % ROOTS.len()].sqrt()).fract();
        for (k, &(lower, upper)) in ranges.iter().enumerate() {
            conditions.joints[k] = lower + (upper - lower) * share(k);
        }
        if options.conditions.is_none() {
            spread(&fitted.domain, i, &mut conditions, |k| share(n + k));
        }
        let real = predictor.predict(&conditions, options.target).translation;
        let off = (real - exported(&conditions.joints)).norm();
        sum += off * off;
        max = f64::max(max, off);
    }
    Ok(ErrorLeft { rms: (sum / options.samples as f64).sqrt(), max })
}

/// The caller's conditions, else the middle of the fit's domain.
pub(super) fn table_conditions(fitted: &FittedModel, options: &ExportOptions) -> Conditions {
    options.conditions.clone().unwrap_or_else(|| middle_conditions(fitted))
}

/// Time and channels (in the order of the fit's) in the middle of what the fit has seen, nothing carried, no joint moving;
/// without joint values.
pub fn middle_conditions(fitted: &FittedModel) -> Conditions {
    let mut conditions = Conditions { channels: vec![0.0; fitted.channels.len()], ..Conditions::default() };
    within(&fitted.domain, &mut conditions, |_| 0.5);
    conditions
}

/// Everything but the joints somewhere in the domain: sides and loads by number, the rest by share.
fn spread(domain: &Domain, i: usize, conditions: &mut Conditions, share: impl Fn(usize) -> f64) {
    for (k, side) in conditions.approach.iter_mut().enumerate() {
        // Bits of a hashed number: any combination of sides.
        let bits = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        *side = if bits >> (63 - k % 64) & 1 == 1 { 1.0 } else { -1.0 };
    }
    if let Some(range) = &domain.payload {
        let mass = range.lower + (range.upper - range.lower) * share(0);
        conditions.load = Load::Payload(Payload { mass, com: Vector3::zeros() });
    }
    within(domain, conditions, |k| share(1 + k));
}

/// Time and channels at a share of their ranges.
fn within(domain: &Domain, conditions: &mut Conditions, share: impl Fn(usize) -> f64) {
    let at = |range: &Interval, k: usize| range.lower + (range.upper - range.lower) * share(k);
    conditions.time = domain.time.as_ref().map_or(0.0, |range| at(range, 0));
    for (k, (value, range)) in conditions.channels.iter_mut().zip(&domain.channels).enumerate() {
        *value = at(range, k + 1);
    }
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
