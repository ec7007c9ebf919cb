//! Pose accuracy AP and pose repeatability RP.
//!
//! ```text
//! AP_p = ‖x̄ − x_c‖      AP_x = x̄ − x_c, …      AP_a = ā − a_c, …
//! RP_l = l̄ + 3 S_l       l_j = ‖x_j − x̄‖         RP_a = ± 3 S_a, …
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | x_j − x_c | `positions`, attained minus commanded | m | base |
//! | a_j − a_c, b, c | `rotations`: rotation vector of R_j R_cᵀ | rad | base |
//! | u_c | `common`: standard uncertainty that all readings of a pose share, each axis | m | base |
//!
//! Angles are components of the rotation vector of the deviation: deviations are small, and no choice of Euler angles enters.
//! u²(AP_x) = s_x²/n + u_c². u(AP_p) is that in the direction of x̄ − x_c, to first order; where AP_p is not large against it, AP_p is too
//! large rather than too small. Source: ISO 9283:1998, 7.2; GUM 5.1.

use crate::figure::{Figure, Method, welch_satterthwaite};
use crate::scatter::Scatter;
use nalgebra::Vector3;

/// Figures of one pose, attained in one direction of approach.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseFigures {
    /// Number of cycles.
    pub cycles: usize,
    /// AP_p, m.
    pub ap: Figure,
    /// AP_x, AP_y, AP_z, signed, m.
    pub ap_axes: [Figure; 3],
    /// AP_a, AP_b, AP_c, signed, rad; none without orientations.
    pub ap_angles: Option<[Figure; 3]>,
    /// RP_l, m.
    pub rp: Figure,
    /// RP_a, RP_b, RP_c, rad; none without orientations.
    pub rp_angles: Option<[Figure; 3]>,
    /// l̄, m.
    pub mean_length: f64,
    /// S_l, m.
    pub sd_length: f64,
    /// Standard deviations of x, y, z, m.
    pub sd: [f64; 3],
}

/// AP and RP of the deviations of two cycles at least. `rotations` is empty, or has one for each cycle.
pub fn pose_figures(positions: &[Vector3<f64>], rotations: &[Vector3<f64>], common: f64) -> PoseFigures {
    let scatter = Scatter::of(positions);
    let along = |value: f64, direction: &Vector3<f64>, method| {
        let random = scatter.variance_of_mean(direction);
        let freedom = welch_satterthwaite(&[(random, scatter.freedom()), (common * common, f64::INFINITY)]);
        Figure::with_u(value, (random + common * common).sqrt(), freedom, method)
    };
    let size = scatter.mean.norm();
    let direction = if size > 0.0 { scatter.mean / size } else { Vector3::x() };
    let unit = [Vector3::x(), Vector3::y(), Vector3::z()];
    let angles =
        (rotations.len() == positions.len() && !rotations.is_empty()).then(|| Scatter::of(rotations));
    PoseFigures {
        cycles: positions.len(),
        ap: along(size, &direction, Method::FirstOrder),
        ap_axes: [0, 1, 2].map(|k| along(scatter.mean[k], &unit[k], Method::Student)),
        ap_angles: angles.as_ref().map(|angles| {
            let one = |k: usize| {
                let u = angles.variance_of_mean(&unit[k]).sqrt();
                Figure::with_u(angles.mean[k], u, angles.freedom(), Method::Student)
            };
            [0, 1, 2].map(one)
        }),
        rp: scatter.repeatability(),
        rp_angles: angles.as_ref().map(|angles| {
            [0, 1, 2].map(|k| Figure::of_deviation(angles.covariance[(k, k)].sqrt(), 3.0, angles.freedom()))
        }),
        mean_length: scatter.mean_length,
        sd_length: scatter.sd_length,
        sd: [0, 1, 2].map(|k| scatter.covariance[(k, k)].sqrt()),
    }
}
