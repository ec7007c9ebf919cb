//! Distance accuracy AD and distance repeatability RD between two poses.
//!
//! ```text
//! D_j = ‖x_1j − x_2j‖     AD_p = D̄ − D_c     RD_p = ± 3 S_D      D_xj = |x_1j − x_2j|,   AD_x = D̄_x − D_cx,   RD_x = ± 3 S_Dx, …
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | x_1j, x_2j | attained positions of the two poses in cycle j | m |
//! | D_c | distance of the commanded positions | m |
//! | u_c | `common`: standard uncertainty that the readings of one pose share; two poses do not share it | m |
//!
//! u²(AD) = S_D²/n + 2 u_c². No alignment of frames enters AD. Source: ISO 9283:1998, 7.3.

use crate::figure::{Figure, Method, welch_satterthwaite};
use nalgebra::Vector3;

/// AD and RD of one pair of poses.
#[derive(Debug, Clone, PartialEq)]
pub struct DistanceFigures {
    /// Cycles in which both poses were measured.
    pub cycles: usize,
    /// D_c, m.
    pub commanded: f64,
    /// AD_p, signed, m.
    pub ad: Figure,
    /// AD_x, AD_y, AD_z, signed, m.
    pub ad_axes: [Figure; 3],
    /// RD_p, m.
    pub rd: Figure,
    /// RD_x, RD_y, RD_z, m.
    pub rd_axes: [Figure; 3],
}

/// Of both attained positions of each cycle, two cycles at least, and of the commanded ones.
pub fn distance_figures(
    cycles: &[[Vector3<f64>; 2]],
    commanded: [Vector3<f64>; 2],
    common: f64,
) -> DistanceFigures {
    let apart = commanded[0] - commanded[1];
    let distances: Vec<f64> = cycles.iter().map(|[a, b]| (a - b).norm()).collect();
    let (ad, rd) = figures(&distances, apart.norm(), common);
    let axis = |k: usize| {
        let components: Vec<f64> = cycles.iter().map(|[a, b]| (a[k] - b[k]).abs()).collect();
        figures(&components, apart[k].abs(), common)
    };
    let axes = [0, 1, 2].map(axis);
    DistanceFigures {
        cycles: cycles.len(),
        commanded: apart.norm(),
        ad,
        ad_axes: axes.map(|pair| pair.0),
        rd,
        rd_axes: axes.map(|pair| pair.1),
    }
}

fn figures(values: &[f64], commanded: f64, common: f64) -> (Figure, Figure) {
    let n = values.len() as f64;
    let freedom = (n - 1.0).max(1.0);
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / freedom;
    let (random, shared) = (variance / n, 2.0 * common * common);
    let freedom_u = welch_satterthwaite(&[(random, freedom), (shared, f64::INFINITY)]);
    (
        Figure::with_u(mean - commanded, (random + shared).sqrt(), freedom_u, Method::Student),
        Figure::of_deviation(variance.sqrt(), 3.0, freedom),
    )
}
