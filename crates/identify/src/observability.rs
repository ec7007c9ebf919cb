//! Observability indices O1–O5: how well a set of configurations determines the grouped errors.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | d_1 ≥ … ≥ d_L | singular values of the whitened matrix in units of the expected sizes | 1 |
//! | n | number of visits | 1 |
//!
//! ```text
//! O1 = (d_1 … d_L)^{1/L} / √n    O2 = d_L / d_1    O3 = d_L    O4 = d_L² / d_1    O5 = 1 / Σ 1/d_k
//! ```
//!
//! Sources: Borm and Menq 1991 (O1), Driels and Pathre 1990 (O2), Nahvi et al. 1994 (O3, O4), Sun and Hollerbach
//! 2008 (O5).

use crate::{Fit, IdentifyError};
use serde::{Deserialize, Serialize};
use truepose_solvers::ColumnScale;

/// The five indices, larger is better, and the weakest direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Observability {
    /// Geometric mean of the singular values, per square root of visits.
    pub o1: f64,
    /// Inverse of the condition number.
    pub o2: f64,
    /// Smallest singular value.
    pub o3: f64,
    /// Noise amplification index.
    pub o4: f64,
    /// Harmonic sum.
    pub o5: f64,
    /// All singular values, largest first.
    pub singular_values: Vec<f64>,
    /// The three kept columns with the largest share in the weakest direction, with their shares.
    pub weakest: Vec<(usize, f64)>,
}

/// Of the configurations that a fit was made from.
///
/// # Errors
/// When the singular value decomposition fails.
pub fn observability(fit: &Fit, visits: usize) -> Result<Observability, IdentifyError> {
    let columns = fit.fitted.model().columns();
    let scales: Vec<f64> = fit.reduction.kept.iter().map(|&c| columns[c].scale).collect();
    let turned = fit.factor.directions(ColumnScale::Given(&scales))?;
    let d = &turned.values;
    let [o1, o2, o3, o4, o5] = indices(d, visits);
    if d.is_empty() {
        return Ok(Observability { o1, o2, o3, o4, o5, singular_values: Vec::new(), weakest: Vec::new() });
    }
    let direction = turned.vectors.column(d.len() - 1);
    let mut shares: Vec<(usize, f64)> =
        fit.reduction.kept.iter().zip(direction.iter()).map(|(&c, v)| (c, v * v)).collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    shares.truncate(3);
    Ok(Observability { o1, o2, o3, o4, o5, singular_values: turned.values.clone(), weakest: shares })
}

/// O1 to O5 of singular values, largest first; zero where there are none.
pub(crate) fn indices(d: &[f64], visits: usize) -> [f64; 5] {
    let (Some(&first), Some(&last)) = (d.first(), d.last()) else { return [0.0; 5] };
    let logs: f64 = d.iter().map(|v| v.max(f64::MIN_POSITIVE).ln()).sum::<f64>() / d.len() as f64;
    [
        logs.exp() / (visits.max(1) as f64).sqrt(),
        last / first,
        last,
        last * last / first,
        1.0 / d.iter().map(|v| 1.0 / v).sum::<f64>(),
    ]
}
