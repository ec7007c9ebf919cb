//! Standard deviations from the residuals of a fit: variance components by moments.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | f = (m − r)/m | `freedom`: the share of the data that the fit did not use up | 1 |
//! | τ | within a visit, on top of what the instrument states | m |
//! | ρ | shared by a visit | m |
//!
//! Within visits of k ≥ 2 rows the shared part cancels: `E Σ (r − r̄)² = f Σ (k−1)(s² + τ²)`. With τ known, ρ is the
//! value at which the whitened squares of all rows add up to their degrees of freedom; both equations have one
//! root, found by bisection (Searle, Casella and McCulloch 1992, ch. 5, for the moments).

use crate::{NoiseModel, Residuals};
use truepose_errormodel::{Dataset, Visits};

/// Noise that explains these residuals; `freedom` in (0, 1].
pub fn estimate_noise(data: &Dataset, visits: &Visits, residuals: &Residuals, freedom: f64) -> NoiseModel {
    let mut axes = Vec::new();
    for rows in &visits.rows {
        for axis in 0..3 {
            let members: Vec<(f64, f64)> = rows
                .iter()
                .filter(|&&row| residuals.position[row][axis].is_finite())
                .map(|&row| (residuals.position[row][axis], stated(data.position_sd[row][axis])))
                .collect();
            if !members.is_empty() {
                axes.push(members);
            }
        }
    }
    let (position_sd, visit_sd) = if axes.iter().any(|members| members.len() > 1) {
        let inner: Vec<(f64, f64)> = axes.iter().filter(|m| m.len() > 1).flat_map(|m| within(m)).collect();
        let tau = excess(&inner, freedom);
        (tau, shared(&axes, tau, freedom))
    } else {
        (excess(&axes.concat(), freedom), 0.0)
    };
    let turns: Vec<(f64, f64)> = residuals
        .orientation
        .iter()
        .enumerate()
        .filter_map(|(row, r)| r.map(|r| (row, r)))
        .flat_map(|(row, r)| (0..3).map(move |k| (row, k, r[k])))
        .map(|(row, k, r)| (r, stated(data.orientation_sd[row][k])))
        .collect();
    let default = NoiseModel::default();
    NoiseModel {
        position_sd: if axes.is_empty() { default.position_sd } else { position_sd },
        visit_sd,
        orientation_sd: if turns.is_empty() { default.orientation_sd } else { excess(&turns, freedom) },
    }
}

fn stated(sd: f64) -> f64 {
    if sd.is_nan() { 0.0 } else { sd }
}

/// Deviations from the visit's mean, stretched so that their mean square is the variance of one row.
fn within(members: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let k = members.len() as f64;
    let mean = members.iter().map(|m| m.0).sum::<f64>() / k;
    let stretch = (k / (k - 1.0)).sqrt();
    members.iter().map(|&(r, s)| ((r - mean) * stretch, s)).collect()
}

/// The τ at which Σ r²/(s² + τ²) is the number of values times `freedom`; zero when s alone explains them.
fn excess(values: &[(f64, f64)], freedom: f64) -> f64 {
    let wanted = freedom * values.len() as f64;
    let sum = |tau: f64| -> f64 {
        values.iter().map(|&(r, s)| r * r / (s * s + tau * tau).max(f64::MIN_POSITIVE)).sum()
    };
    let largest = values.iter().map(|v| v.0 * v.0).sum::<f64>() / wanted.max(f64::MIN_POSITIVE);
    bisect(largest.sqrt(), |tau| sum(tau) - wanted)
}

/// The ρ at which the whitened squares of all visits add up.
fn shared(axes: &[Vec<(f64, f64)>], tau: f64, freedom: f64) -> f64 {
    let rows: usize = axes.iter().map(Vec::len).sum();
    let wanted = freedom * rows as f64;
    let sum = |rho: f64| -> f64 {
        axes.iter()
            .map(|members| {
                let (mut squares, mut along, mut weight) = (0.0, 0.0, 0.0);
                for &(r, s) in members {
                    let w = 1.0 / (s * s + tau * tau).max(1e-24);
                    squares += r * r * w;
                    along += r * w;
                    weight += w;
                }
                squares - rho * rho * along * along / (1.0 + rho * rho * weight)
            })
            .sum()
    };
    let largest = axes.iter().flatten().map(|v| v.0 * v.0).sum::<f64>() / wanted.max(f64::MIN_POSITIVE);
    bisect(10.0 * largest.sqrt(), |rho| sum(rho) - wanted)
}

/// Root of a falling function on [0, upper]; zero when it is not positive at zero.
fn bisect(upper: f64, excess: impl Fn(f64) -> f64) -> f64 {
    if upper.is_nan() || upper <= 0.0 || excess(0.0) <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, upper);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn finds_what_was_put_in() {
        // A fixed, well mixed sequence of unit normals by the sum of twelve uniforms.
        let mut state = 12345u64;
        let mut normal = || {
            let mut sum = -6.0;
            for _ in 0..12 {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                sum += (state >> 11) as f64 / (1u64 << 53) as f64;
            }
            sum
        };
        let (visits, each) = (2000, 3);
        let mut data = Dataset::default();
        let mut residuals = Residuals::default();
        for visit in 0..visits {
            let common = Vector3::new(normal(), normal(), normal()) * 5e-5;
            for _ in 0..each {
                data.visit.push(visit);
                data.position_sd.push([3e-5; 3]);
                data.orientation_sd.push([f64::NAN; 3]);
                let own = Vector3::new(normal(), normal(), normal()) * 4e-5;
                residuals.position.push(common + own);
                residuals.orientation.push(None);
            }
        }
        let noise = estimate_noise(&data, &Visits::of(&data), &residuals, 1.0);
        let tau = (4e-5f64.powi(2) - 3e-5f64.powi(2)).sqrt();
        assert!((noise.position_sd / tau - 1.0).abs() < 0.04, "{noise:?}");
        assert!((noise.visit_sd / 5e-5 - 1.0).abs() < 0.03, "{noise:?}");
    }
}
