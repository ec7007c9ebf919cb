//! What an export cannot carry, and the error that is left without it.
//!
//! The error left is the distance between the fitted model and the export at the configurations of the fit, or where it holds none at
//! configurations spread over the joints' ranges, under the caller's conditions or over all that the fit has seen.

use super::comparison::{Comparison, compared};
use super::reference::{Reference, Row};
use crate::CompensateError;
use nalgebra::Vector3;
use truepose_errormodel::{Domain, FittedModel, Interval};
use truepose_kinematics::{Chain, Conditions, Pose, TargetId};

/// Under which conditions, and where, an export is compared with the model.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportOptions {
    /// Load, time, approach and channels (in the order of the fit's); joints are not read. None takes those of the fit's rows;
    /// where it holds none they are spread over its domain, payloads at the tool's origin, every joint arriving from either
    /// side. Tables then hold for the middle of the domain, without a load.
    pub conditions: Option<Conditions>,
    /// Which point; none is that of each row of the fit, else the tool's origin.
    pub target: Option<TargetId>,
    /// How many configurations, where the fit holds none.
    pub samples: usize,
}

impl Default for ExportOptions {
    fn default() -> Self {
        ExportOptions { conditions: None, target: None, samples: 2000 }
    }
}

/// Distance between the fitted model and an export, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RemainingError {
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
    pub remaining_error: RemainingError,
    /// Its accuracy beside the nominal robot and the model.
    pub comparison: Comparison,
}

impl<T> Exported<T> {
    /// What the export lacks and what that costs, a sentence a line.
    pub fn statement(&self) -> Vec<String> {
        let lacks = if self.left_out.is_empty() {
            "carries every effect of the fit".into()
        } else {
            format!(
                "cannot carry: {}; the geometry is the least-squares projection of the full model",
                self.left_out.join(", ")
            )
        };
        let RemainingError { rms, max } = self.remaining_error;
        let left = format!(
            "remaining error over the range of the fit: RMS {}, max {}",
            in_millimetres(rms),
            in_millimetres(max)
        );
        let mut lines = vec![lacks, left];
        lines.extend(self.comparison.statement());
        lines
    }
}

fn in_millimetres(metres: f64) -> String {
    if metres < 1e-9 { "below 1 nm".into() } else { format!("{:.6} mm", 1e3 * metres) }
}

/// Holds an export against the model and the nominal robot; `exported` is its tool at a row, and the row's target on it.
///
/// # Errors
/// [`CompensateError::WorseThanNominal`].
pub(super) fn judged(
    fitted: &FittedModel,
    reference: &Reference,
    mut exported: impl FnMut(&Row) -> (Pose, Vector3<f64>),
) -> Result<(RemainingError, Comparison), CompensateError> {
    let comparison = compared(fitted.chain(), reference, &mut exported);
    if comparison.worse() {
        let Comparison { nominal, export, .. } = comparison;
        return Err(CompensateError::WorseThanNominal { nominal, export });
    }
    let (mut sum, mut max) = (0.0, 0.0);
    for row in &reference.rows {
        let (tool, point) = exported(row);
        let off = (row.point - tool.apply(&point)).norm();
        sum += off * off;
        max = f64::max(max, off);
    }
    let rms = (sum / reference.rows.len().max(1) as f64).sqrt();
    Ok((RemainingError { rms, max }, comparison))
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

/// Time and channels at a fraction of their ranges.
pub(super) fn within(domain: &Domain, conditions: &mut Conditions, share: impl Fn(usize) -> f64) {
    let at = |range: &Interval, k: usize| range.lower + (range.upper - range.lower) * share(k);
    conditions.time = domain.time.as_ref().map_or(0.0, |range| at(range, 0));
    for (k, (value, range)) in conditions.channels.iter_mut().zip(&domain.channels).enumerate() {
        *value = at(range, k + 1);
    }
}

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
