//! The configurations at which an export is compared with the model and the measurements.
//!
//! Those that the robot visited, where the fit holds them: then load, time, channels and approach are those of each row, and what was
//! measured is there. Else configurations spread over the joints' ranges (those of the fit's domain where it has one).

use super::options::{ExportOptions, ranges, table_conditions, within};
use crate::CompensateError;
use crate::accuracy::everything;
use nalgebra::Vector3;
use truepose_errormodel::{Domain, FittedModel, TargetKnown};
use truepose_kinematics::{Conditions, Load, Payload, Pose, TargetId};

/// One configuration, and where the fitted model has the robot there.
pub(super) struct Row {
    pub conditions: Conditions,
    pub target: Option<TargetId>,
    /// The tool, in the measurement frame.
    pub tool: Pose,
    /// The target's position there, m.
    pub point: Vector3<f64>,
    /// What was measured of it, m; none where it was not, or not completely.
    pub measured: Option<Vector3<f64>>,
}

/// All of them.
pub(super) struct Reference {
    pub rows: Vec<Row>,
    /// Of how many rows of the fit; none where the configurations are made up.
    pub drawn_from: Option<usize>,
    /// Whether orientations were measured: then they count, too.
    pub turned: bool,
}

impl Reference {
    pub fn of(fitted: &FittedModel, options: &ExportOptions) -> Result<Self, CompensateError> {
        let turned = fitted.orientation_known() == TargetKnown::Measured;
        let (rows, drawn_from) = match visited(fitted, options)? {
            Some(rows) => (rows, Some(fitted.domain.sample.drawn_from())),
            None => (made_up(fitted, options)?, None),
        };
        Ok(Reference { rows, drawn_from, turned })
    }
}

/// The rows of the fit; none where it holds none, or other conditions are requested.
fn visited(fitted: &FittedModel, options: &ExportOptions) -> Result<Option<Vec<Row>>, CompensateError> {
    let sample = &fitted.domain.sample;
    if options.conditions.is_some() || sample.bound(fitted.model()).is_none() {
        return Ok(None);
    }
    let data = sample.rows();
    let mut predictor = fitted.bind(&data.schema)?;
    let rows = (0..data.len()).map(|row| {
        let conditions = data.conditions(row);
        let target = options.target.or(data.target[row]);
        let pose = predictor.predict(&conditions, target);
        let tool = Pose::new(pose.rotation, predictor.predict(&conditions, None).translation);
        let measured = data.measured_position(row);
        let complete = target == data.target[row] && measured.iter().all(|v| v.is_finite());
        Row { conditions, target, tool, point: pose.translation, measured: complete.then_some(measured) }
    });
    Ok(Some(rows.collect()))
}

fn made_up(fitted: &FittedModel, options: &ExportOptions) -> Result<Vec<Row>, CompensateError> {
    if options.samples == 0 || options.samples > 1_000_000 {
        let value = options.samples as f64;
        return Err(CompensateError::Option { option: "samples", value, need: "1 to 1 000 000" });
    }
    let (schema, mut conditions) = everything(fitted, &table_conditions(fitted, options))?;
    let mut predictor = fitted.bind(&schema)?;
    let ranges = ranges(fitted);
    let n = ranges.len();
    let mut rows = Vec::with_capacity(options.samples);
    for i in 0..options.samples {
        // A Kronecker sequence: multiples of the square roots of primes, modulo one.
        let share = |k: usize| (0.5 + (i + 1) as f64 * ROOTS[k % ROOTS.len()].sqrt()).fract();
        for (k, &(lower, upper)) in ranges.iter().enumerate() {
            conditions.joints[k] = lower + (upper - lower) * share(k);
        }
        if options.conditions.is_none() {
            spread(&fitted.domain, i, &mut conditions, |k| share(n + k));
        }
        let pose = predictor.predict(&conditions, options.target);
        let tool = Pose::new(pose.rotation, predictor.predict(&conditions, None).translation);
        rows.push(Row {
            conditions: conditions.clone(),
            target: options.target,
            tool,
            point: pose.translation,
            measured: None,
        });
    }
    Ok(rows)
}

/// Everything but the joints somewhere in the domain: sides and loads by number, the rest by fraction.
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

const ROOTS: [f64; 16] =
    [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0, 41.0, 43.0, 47.0, 53.0];
