//! The budget of a position that a calibrated robot attains once, from repeats of test poses and from the fit.
//!
//! ```text
//! instrument       u_c²                                   as stated
//! repeatability    Σ (n_i − 1) S_i / Σ (n_i − 1)          pooled over poses
//! model            mean_i J_i C J_iᵀ                      covariance of the coefficients, propagated to the positions
//! unexplained      mean_i m_i² − mean_i S_i/n_i − model − u_c²      m_i: mean deviation from the model at pose i; at least 0
//! ```

use crate::attained::TestPose;
use crate::budget::{Budget, Contribution, Evaluation};
use crate::scatter::Scatter;
use nalgebra::Matrix3;
use truepose_errormodel::{Dataset, FittedModel, ModelError};
use truepose_kinematics::Conditions;

/// Of the poses with the model's displacement taken off; `data` are the rows from which they come.
pub(crate) fn budget(
    fitted: &FittedModel,
    data: &Dataset,
    poses: &[TestPose],
    common: f64,
) -> Result<Budget, ModelError> {
    let inputs = data.derived_for(fitted.model())?;
    let mut predictor = fitted.bind(&inputs.schema)?;
    let mut conditions = Conditions::default();
    let base = fitted.chain().base().pose.rotation;
    let (mut pooled, mut freedom) = ([0.0; 3], 0.0);
    let (mut squares, mut of_means, mut of_model) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    let n = poses.len() as f64;
    for pose in poses {
        let scatter = Scatter::of(&pose.deviations(pose.main_direction()));
        inputs.conditions_into(pose.row, &mut conditions);
        let (_, spread) = predictor.with_covariance(&conditions, pose.target);
        let spread: Matrix3<f64> = base.transpose() * spread * base;
        freedom += scatter.freedom();
        for k in 0..3 {
            pooled[k] += scatter.freedom() * scatter.covariance[(k, k)];
            squares[k] += scatter.mean[k].powi(2) / n;
            of_means[k] += scatter.covariance[(k, k)] / scatter.count as f64 / n;
            of_model[k] += spread[(k, k)] / n;
        }
    }
    let each = |of: &dyn Fn(usize) -> f64| [of(0), of(1), of(2)];
    let known = f64::INFINITY;
    Ok(Budget {
        contributions: vec![
            Contribution::of_variances("instrument", Evaluation::B, [common * common; 3], known),
            Contribution::of_variances(
                "repeatability",
                Evaluation::A,
                each(&|k| pooled[k] / freedom),
                freedom,
            ),
            Contribution::of_variances("model parameters", Evaluation::A, of_model, known),
            Contribution::of_variances(
                "unexplained by the model",
                Evaluation::A,
                each(&|k| squares[k] - of_means[k] - of_model[k] - common * common),
                n,
            ),
        ],
    })
}
