//! What more varied data would excite: which joint to move, and how far.
//!
//! For each movable joint the data is taken as it is, except that this one joint is spread over its limits. If the rank
//! over what the structure allows grows, or directions that the data leaves weak (posterior standard deviation above
//! the prior one) become strong, moving this joint is what is missing.

use crate::linearise::Lineariser;
use crate::reduction::joint_ranges;
use crate::{Fit, IdentifyError};
use serde::{Deserialize, Serialize};
use truepose_errormodel::{Dataset, Interval, Visits};
use truepose_kinematics::JointId;
use truepose_solvers::accumulator::{ColumnScale, Triangular};

/// Moving one joint over a wider range would determine more.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Advice {
    /// The joint.
    pub joint: JointId,
    /// The range that the data covers, rad or m.
    pub seen: Interval,
    /// The range over which it could move.
    pub possible: Interval,
    /// How many more directions would be determined better than by their expected sizes.
    pub gains: usize,
}

/// Directions that the data of a fit determines poorly, and which joints would help.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Excitation {
    /// How many directions are known no better than by their prior standard deviation.
    pub weak_directions: usize,
    /// Joints to move, the most helpful first.
    pub advice: Vec<Advice>,
}

/// Visits on which the question is asked.
const VISITS: usize = 200;

/// Directions that are poorly determined by the data of a fit, and which joints would help; most helpful first.
///
/// # Errors
/// When a factorisation fails.
pub fn excitation(fit: &Fit, data: &Dataset) -> Result<Excitation, IdentifyError> {
    let model = fit.fitted.model();
    let data = &*data.derived_for(model)?;
    // Whole visits, so that every target is there; a thinned sample is made as heavy as all of them.
    let visits = Visits::of(data);
    let step = visits.len().div_ceil(VISITS).max(1);
    let rows: Vec<usize> = visits.rows.iter().step_by(step).flatten().copied().collect();
    let weight = (data.len() as f64 / rows.len().max(1) as f64).sqrt();
    let sample = data.select(&rows);
    // Columns that no data on this robot can tell apart are no excitation's fault.
    let structural: Vec<usize> = (0..model.columns().len())
        .filter(|c| {
            fit.reduction
                .dropped
                .iter()
                .all(|d| d.column != *c || d.cause != crate::reduction::Cause::Structural)
        })
        .collect();
    let now = weak(fit, &sample, &structural, weight)?;
    if now == 0 {
        return Ok(Excitation { weak_directions: 0, advice: Vec::new() });
    }
    let ranges = joint_ranges(model.chain(), Some(data));
    let mut advice = Vec::new();
    for (k, possible) in ranges.iter().enumerate().filter(|(k, _)| model.chain().is_commanded(*k)) {
        let Some(seen) = Interval::of(data.joints[k].iter().copied()) else { continue };
        let mut moved = sample.clone();
        for (value, &visit) in moved.joints[k].iter_mut().zip(&sample.visit) {
            // An irrational stride covers the range evenly and in no step with the other joints.
            let share = (0.5 + visit as f64 * 0.618_033_988_749_894_9).fract();
            *value = possible.lower + (possible.upper - possible.lower) * share;
        }
        moved.follow(model.chain());
        let then = weak(fit, &moved, &structural, weight)?;
        if then < now {
            let joint = model.chain().movable()[k];
            advice.push(Advice { joint, seen, possible: *possible, gains: now - then });
        }
    }
    advice.sort_by(|a, b| b.gains.cmp(&a.gains).then(a.joint.cmp(&b.joint)));
    Ok(Excitation { weak_directions: now, advice })
}

/// Directions whose posterior standard deviation is above the prior one.
fn weak(fit: &Fit, sample: &Dataset, columns: &[usize], weight: f64) -> Result<usize, IdentifyError> {
    let model = fit.fitted.model();
    let zero = vec![0.0; model.columns().len()];
    let mut lineariser = Lineariser::new(model, sample, fit.noise, &zero)?;
    let mut factor = Triangular::new(zero.len(), 1);
    for rows in &Visits::of(sample).rows {
        factor.update_rows(lineariser.visit(rows).rows)?;
    }
    let scales: Vec<f64> = columns.iter().map(|&c| model.columns()[c].scale * weight).collect();
    let inner = factor.finish().select(columns);
    Ok(inner.singular_values(ColumnScale::Given(&scales))?.iter().filter(|d| **d < 1.0).count())
}
