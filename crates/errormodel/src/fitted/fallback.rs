//! Where effects that were found in data do not reach: the declared model in their place.
//!
//! ```text
//! p(x) = p_0(x) + w(x) (p_1(x) − p_0(x)),    w = 1 / (1 + max(0, V(x) − V_95)/s²)
//! cov p = w² J C Jᵀ + (1 − w)² b²/3 · 1
//! ```
//!
//! | symbol | here | unit | |
//! | --- | --- | --- | --- |
//! | p_0, p_1 | declared model alone; model with findings | m, rad | orientations along the shortest rotation |
//! | V | tr J C Jᵀ at x | m² | what the coefficients leave open of a position |
//! | V_95 | [`Fallback::usual`](super::Fallback) | m² | 95 % of the rows of the fit are below |
//! | s² | [`Fallback::scale`](super::Fallback) | m² | set where the model predicted parts of the data that it had not seen |
//! | b² | [`Fallback::size`](super::Fallback) | m² | mean square by which the findings move the rows of the fit |
//!
//! A curve or a gear that explains every measured pose may say anything at all where none was measured. Two predictions, the one of
//! variance V and the other wrong by b, are best combined with w = b²/(b² + V); V is that of the model's own form, so that s² is smaller
//! than b² where forms differ from the truth. Among the rows of the fit w is one.

use truepose_kinematics::{Pose, rotation_log, rotation_vector};

/// w, of the variance of a predicted position, V_95 and s², m².
pub(super) fn share(variance: f64, usual: f64, scale: f64) -> f64 {
    1.0 / (1.0 + (variance - usual).max(0.0) / scale)
}

/// `declared` moved by this share of the way to `found`.
pub(super) fn between(declared: &Pose, found: &Pose, share: f64) -> Pose {
    let turn = rotation_log(&(found.rotation * declared.rotation.transpose())) * share;
    let translation = declared.translation + (found.translation - declared.translation) * share;
    Pose::new(rotation_vector(&turn) * declared.rotation, translation)
}

#[cfg(test)]
mod tests {
    use super::super::{Fallback, FittedModel};
    use super::*;
    use crate::ErrorModel;
    use crate::effects::{Expansion, Geometric, Place};
    use nalgebra::DMatrix;
    use std::sync::Arc;
    use truepose_kinematics::{Conditions, JointId, samples};

    fn declared() -> FittedModel {
        let model = ErrorModel::new(samples::ur10(), vec![Box::new(Geometric::default())]).unwrap();
        let n = model.columns().len();
        FittedModel::new(model, vec![0.0; n], DMatrix::zeros(n, n)).unwrap()
    }

    /// A joint 1 mrad off, known to `deviation`.
    fn found(deviation: f64) -> FittedModel {
        let off = Expansion { at: Place::Motion { joint: JointId(2) }, factors: Vec::new() };
        let model = declared().model().with(Box::new(off)).unwrap();
        let n = model.columns().len();
        let mut coefficients = vec![0.0; n];
        coefficients[n - 1] = 1e-3;
        let mut covariance = DMatrix::zeros(n, n);
        covariance[(n - 1, n - 1)] = deviation * deviation;
        FittedModel::new(model, coefficients, covariance).unwrap()
    }

    #[test]
    fn what_is_not_known_falls_back_and_what_is_known_stays() {
        let at = Conditions { joints: vec![0.3, -1.0, 0.8, 0.1, 0.7, 0.2], ..Conditions::default() };
        let predict = |fitted: &FittedModel| {
            let mut predictor = fitted.bind(&crate::Schema::default()).unwrap();
            (predictor.predict(&at, None), predictor.with_covariance(&at, None).1.trace())
        };
        let fallback = Fallback { declared: Arc::new(declared()), usual: 1e-9, scale: 1e-8, size: 4e-7 };
        let (full, open) = predict(&found(1e-3));
        let (bare, _) = predict(&declared());
        let apart = |a: &Pose, b: &Pose| (a.translation - b.translation).norm();
        assert!(apart(&full, &bare) > 1e-4);
        // Known well: to the last bit as without a fallback.
        let known = found(1e-6).with_fallback(Some(fallback.clone()));
        assert_eq!(predict(&known).0, predict(&found(1e-6)).0);
        // Hardly known: as much of it as the weight says, and the band is that of both together.
        let unknown = found(1e-3).with_fallback(Some(fallback.clone()));
        let w = fallback.weight(open);
        let (blended, band) = predict(&unknown);
        assert!(w < 0.1 && (apart(&blended, &bare) / apart(&full, &bare) - w).abs() < 1e-9);
        assert!((band - (w * w * open + (1.0 - w).powi(2) * fallback.size)).abs() < 1e-15);
        assert!(rotation_log(&(blended.rotation * bare.rotation.transpose())).norm() < 1.1e-3 * w);
    }
}
