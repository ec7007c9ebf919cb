//! Predicted error at a pose and its 95 % band.
//!
//! ```text
//! C = J_e Φ cov(c) (J_e Φ)ᵀ                        what the coefficients leave open
//! r_95: P(|v| ≤ r_95) = 0.95,  v ~ N(0, C_p + σ² I)
//! |v|² ≈ g χ²_ν,  ν = (Σλ)²/Σλ²,  g = Σλ²/Σλ         λ: eigenvalues of the covariance   (Satterthwaite)
//! χ²_ν,0.95 ≈ ν (1 − 2/(9ν) + 1.645 √(2/(9ν)))³                                            (Wilson and Hilferty)
//! ```
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | C | `covariance` | 6×6 | m², rad² | measurement |
//! | σ | `Noise::position_sd` | 1 | m | repeatability and instrument, as the fit saw them |
//! | r_95 | [`radius_95`] | 1 | m | |
//!
//! Sources: Satterthwaite 1946; Wilson and Hilferty 1931. Together they hold 94 to 96 % for any three eigenvalues.

use nalgebra::{Matrix3, Matrix6, Vector3};
use truepose_errormodel::{FittedModel, Predictor};
use truepose_kinematics::{Conditions, TargetId, rotation_log};

/// The prediction of the model for one pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedError {
    /// Real minus nominal position of the target, m, in the measurement frame.
    pub displacement: Vector3<f64>,
    /// Rotation vector from the nominal to the real orientation, rad, in the measurement frame.
    pub turn: Vector3<f64>,
    /// Covariance of `[x y z rx ry rz]` that the coefficients leave open, m² and rad².
    pub covariance: Matrix6<f64>,
    /// With 95 % the model's prediction is off by no more than this distance, m.
    pub model_95: f64,
    /// With 95 % a new measurement lies no farther than this from the prediction, m: and so does the robot from its
    /// target, once it is compensated. The noise of the fit contains the instrument's.
    pub measured_95: f64,
}

/// The error of the nominal robot under these conditions, and the interval around its prediction.
pub fn predicted_error(
    fitted: &FittedModel,
    predictor: &mut Predictor<'_>,
    conditions: &Conditions,
    target: Option<TargetId>,
) -> PredictedError {
    let nominal = predictor.nominal(conditions, target);
    let real = predictor.predict(conditions, target);
    let covariance = predictor.covariance(conditions, target);
    let position: Matrix3<f64> = covariance.fixed_view::<3, 3>(0, 0).into();
    let noise = Matrix3::identity() * fitted.noise.position_sd.powi(2);
    PredictedError {
        displacement: real.translation - nominal.translation,
        turn: rotation_log(&(real.rotation * nominal.rotation.transpose())),
        covariance,
        model_95: radius_95(&position),
        measured_95: radius_95(&(position + noise)),
    }
}

/// Whether a correction is expected to bring the robot nearer to its target than the nominal command.
///
/// ```text
/// E |nominal error|² = |d|² ≈ |d̂|² − tr C          E |corrected error|² = tr C          nearer when |d̂|² > 2 tr C
/// ```
///
/// `displacement` d̂ is the predicted real minus nominal position, m, and `covariance` C what the coefficients leave open of it, m².
pub fn correction_helps(displacement: &Vector3<f64>, covariance: &Matrix3<f64>) -> bool {
    displacement.norm_squared() >= 2.0 * covariance.trace()
}

/// The radius within which a normal vector of this covariance lies with 95 %.
pub fn radius_95(covariance: &Matrix3<f64>) -> f64 {
    radius_95_about(&Vector3::zeros(), covariance)
}

/// The radius within which a normal vector of this mean and covariance lies with 95 %: as [`radius_95`], with the mean and the variance of
/// |v|² that a mean d adds, `|d|²` and `4 dᵀ C d` (Patnaik 1949).
pub fn radius_95_about(mean: &Vector3<f64>, covariance: &Matrix3<f64>) -> f64 {
    // Σλ and Σλ² without the eigenvalues: the traces of C and of C².
    let sum = covariance.trace() + mean.norm_squared();
    let squares =
        covariance.component_mul(&covariance.transpose()).sum() + 2.0 * mean.dot(&(covariance * mean));
    if sum <= 0.0 || squares <= 0.0 {
        return sum.max(0.0).sqrt();
    }
    let freedom = sum * sum / squares;
    let spread = 2.0 / (9.0 * freedom);
    let quantile = freedom * (1.0 - spread + 1.644_853_6 * spread.sqrt()).powi(3);
    (quantile * squares / sum).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normal(state: &mut u64) -> f64 {
        // The sum of twelve uniform numbers is normal enough up to two and a half deviations.
        let mut sum = -6.0;
        for _ in 0..12 {
            *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            sum += (*state >> 11) as f64 / (1u64 << 53) as f64;
        }
        sum
    }

    #[test]
    fn the_radius_holds_95_percent_of_any_shape() {
        let mut state = 9;
        for shape in [[1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.3, 0.05], [1.0, 0.5, 0.5]] {
            let turn = truepose_kinematics::rotation_vector(&Vector3::new(0.4, -0.7, 0.2));
            let root = turn * Matrix3::from_diagonal(&Vector3::from(shape));
            let radius = radius_95(&(root * root.transpose()));
            let count = 40_000;
            let inside = (0..count)
                .filter(|_| {
                    let z = Vector3::new(normal(&mut state), normal(&mut state), normal(&mut state));
                    (root * z).norm() <= radius
                })
                .count();
            let share = inside as f64 / f64::from(count);
            assert!((share - 0.95).abs() < 0.01, "{shape:?}: {share}");
        }
        assert!(radius_95(&Matrix3::zeros()).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn the_radius_about_a_mean_holds_95_percent() {
        let mut state = 9;
        for (mean, shape) in [
            ([0.0, 0.0, 3.0], [1.0, 1.0, 1.0]),
            ([1.0, 0.0, 0.0], [1.0, 0.5, 0.5]),
            ([0.0, 2.0, 0.0], [1.0, 0.3, 0.05]),
            ([10.0, 0.0, 0.0], [1.0, 1.0, 0.2]),
        ] {
            let (mean, root) = (Vector3::from(mean), Matrix3::from_diagonal(&Vector3::from(shape)));
            let radius = radius_95_about(&mean, &(root * root.transpose()));
            let count = 40_000;
            let inside = (0..count)
                .filter(|_| {
                    let z = Vector3::new(normal(&mut state), normal(&mut state), normal(&mut state));
                    (mean + root * z).norm() <= radius
                })
                .count();
            let share = inside as f64 / f64::from(count);
            assert!((share - 0.95).abs() < 0.012, "{mean:?} {shape:?}: {share}");
        }
        assert!((radius_95_about(&Vector3::new(3.0, 4.0, 0.0), &Matrix3::zeros()) - 5.0).abs() < 1e-12);
    }
}
