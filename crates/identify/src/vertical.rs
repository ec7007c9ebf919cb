//! Which way is down, where nobody declared it: along −z of the measurement frame, or of the robot's base.
//!
//! Weights bend an arm where they act. Both directions are tried with joints that yield, and folds that no fit has seen decide.

use crate::comparison::squares;
use crate::{FitOptions, Folds, IdentifyError, Method, Split, cross_validate, fit, place, student_quantile};
use truepose_errormodel::effects::JointCompliance;
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, Visits, configurations};
use truepose_kinematics::{Chain, ChainError, Gravity, GravityFrame, Load};
use truepose_solvers::Solver;

/// Angle between the two directions, rad, from which it is looked at: weights act otherwise by a tenth.
const TILTED: f64 = 0.1;
/// Pose measurements that are used, evenly taken.
const POSES: usize = 300;
/// p of the test of folds below which one direction is the better one, and the most that its held-out RMS is of the other's. Convention.
const CLEAR: (f64, f64) = (0.01, 0.95);
/// Most folds of the comparison, and the fewest that distinguish the directions.
const FOLDS: (usize, usize) = (10, 3);

/// A direction of gravity that was assumed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertical {
    /// Angle between gravity in the measurement frame and in the base, rad.
    pub angle: f64,
    /// Which is used.
    pub frame: GravityFrame,
    /// Held-out RMS of a position with yielding joints, m: gravity in the measurement frame, in the base.
    pub rms: [f64; 2],
    /// Whether these distinguish the two.
    pub clear: bool,
}

impl Vertical {
    /// The robot with gravity in the frame that is used.
    ///
    /// # Errors
    /// When its vector is not finite.
    pub fn applied(&self, chain: &Chain) -> Result<Chain, IdentifyError> {
        towards(chain, self.frame)
    }
}

fn towards(chain: &Chain, frame: GravityFrame) -> Result<Chain, IdentifyError> {
    let wrong =
        |error: ChainError| IdentifyError::Placement { what: "gravity".into(), why: error.to_string() };
    chain.clone().with_gravity(Gravity { frame, ..*chain.gravity() }).map_err(wrong)
}

/// Whether the squared errors of folds differ by more than chance: Student's test of their logarithmic ratios, whose variance is that of folds
/// that share their training rows (Nadeau and Bengio 2003).
fn differ(a: &[(f64, usize)], b: &[(f64, usize)]) -> bool {
    let ratios: Vec<f64> =
        a.iter().zip(b).filter(|(a, b)| a.0 > 0.0 && b.0 > 0.0).map(|(a, b)| (b.0 / a.0).ln()).collect();
    let k = ratios.len() as f64;
    if k < 3.0 {
        return false;
    }
    let mean = ratios.iter().sum::<f64>() / k;
    let variance = ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / (k - 1.0);
    let scale = (variance * (1.0 / k + 1.0 / (k - 1.0))).sqrt();
    mean.abs() > student_quantile(1.0 - 0.5 * CLEAR.0, ratios.len() - 1) * scale
}

/// Compares both directions for a robot whose gravity is not declared; `None` where they agree, nothing is known to have a weight, or there are
/// fewer than three configurations.
///
/// # Errors
/// When base and tool cannot be found, or a fit fails.
pub fn vertical(
    chain: &Chain,
    effects: &[Box<dyn AnyEffect>],
    data: &Dataset,
    (solver, options): (&dyn Solver, &FitOptions),
) -> Result<Option<Vertical>, IdentifyError> {
    let heavy = chain.joints().iter().any(|joint| joint.link.is_some_and(|link| link.mass > 0.0))
        || data.load.iter().any(|load| matches!(load, Load::Payload(payload) if payload.mass > 0.0));
    if !heavy {
        return Ok(None);
    }
    let visits = Visits::of(data);
    let step = visits.len().div_ceil(POSES).max(1);
    let mut rows: Vec<usize> = visits.rows.into_iter().step_by(step).flatten().collect();
    rows.sort_unstable();
    let data = &data.select(&rows);
    let count = configurations(data).into_iter().max().map_or(0, |last| last + 1);
    if count < FOLDS.1 {
        return Ok(None);
    }
    let placed = place(chain, data)?.chain;
    let down = placed.gravity().vector;
    let angle = down.angle(&(placed.base().pose.rotation * down));
    if angle.is_nan() || angle < TILTED {
        return Ok(None);
    }
    let mut all = effects.to_vec();
    let declared: Vec<&JointCompliance> = effects.iter().filter_map(|effect| effect.concrete()).collect();
    let yields = |joint| declared.iter().any(|of| of.joints.as_ref().is_none_or(|list| list.contains(joint)));
    for &joint in placed.movable().iter().filter(|joint| !yields(joint)) {
        all.push(Box::new(JointCompliance::of(joint)));
    }
    let folds = Folds::new(data, &Split::Random { folds: FOLDS.0.min(count), seed: 0 })?;
    let mut tried = Vec::new();
    for frame in [GravityFrame::Measurement, GravityFrame::Base] {
        let model = ErrorModel::new(towards(&placed, frame)?, all.clone())?;
        let fit = fit(&model, data, solver, options)?;
        let held_out = cross_validate(&fit, data, &folds, solver, Method::Auto)?;
        tried.push((squares(&held_out, data), held_out.residuals.positions().rms));
    }
    let rms = [tried[0].1, tried[1].1];
    let better = usize::from(rms[1] < rms[0]);
    let clear = rms[better] < CLEAR.1 * rms[1 - better] && differ(&tried[better].0, &tried[1 - better].0);
    let frame = if clear && better == 1 { GravityFrame::Base } else { GravityFrame::Measurement };
    Ok(Some(Vertical { angle, frame, rms, clear }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::effects::Geometric;
    use truepose_errormodel::{DatasetBuilder, Measurement};
    use truepose_kinematics::{Placed, Pose, samples};
    use truepose_solvers::PivotedQr;

    #[test]
    fn a_tilted_arm_needs_no_ten_configurations() {
        let tilted = Pose::from_xyz_rpy([1.0, 0.0, 0.5], [0.4, 0.0, 0.0]);
        let chain = samples::heavy().with_base(Placed { pose: tilted, known: true }).unwrap();
        let effects: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
        for configurations in [1, 2, 3, 8] {
            let mut data = DatasetBuilder::new(&chain);
            for k in 0..configurations {
                let joints: Vec<f64> =
                    (0..chain.movable().len()).map(|j| ((k * 7 + j * 3) as f64).sin()).collect();
                let position = chain.forward(&joints).translation;
                data.push(Measurement::at(joints).position(position).visit(k as u64)).unwrap();
            }
            let how = (&PivotedQr::default() as &dyn Solver, &FitOptions::default());
            let found = vertical(&chain, &effects, &data.finish(), how).unwrap();
            assert_eq!(found.is_some(), configurations > 2, "{configurations}");
        }
    }
}
