//! Least squares within bounds by an active set that never climbs: slow, and certain.
//!
//! From a point within the bounds, towards the best point of the variables that are free, as far as the first bound; where
//! nothing stands in the way, the bound that pulls the wrong way hardest lets go. Each step lowers ½ ‖M u − z‖², so no set
//! comes twice (Stark and Parker 1995). For problems whose columns are nearly dependent: there the faster exchange of
//! [`super::bounded`] may go in circles.

use super::core::Core;
use super::shifted::shifted;
use nalgebra::DVector;

/// Which bound holds a variable.
#[derive(Clone, Copy, PartialEq)]
enum At {
    Free,
    Lower,
    Upper,
}

/// From `start` within the bounds to the optimum, or as near as the arithmetic comes.
pub(super) fn descend(
    core: &Core,
    lower: &DVector<f64>,
    upper: &DVector<f64>,
    start: &DVector<f64>,
) -> Option<DVector<f64>> {
    const SETTLED: f64 = 1e-14;
    let p = start.len();
    let mut u = start.clone();
    let mut at: Vec<At> = (0..p)
        .map(|k| match u[k] {
            v if v <= lower[k] => At::Lower,
            v if v >= upper[k] => At::Upper,
            _ => At::Free,
        })
        .collect();
    // Bounds that were let go of and held again at once: round-off moves them, nothing else.
    let mut stuck = vec![false; p];
    for _ in 0..20 * p + 50 {
        let free: Vec<usize> = (0..p).filter(|k| at[*k] == At::Free).collect();
        let mut held = u.clone();
        free.iter().for_each(|&k| held[k] = 0.0);
        let part = core.m.select_columns(&free);
        let best = shifted(&part, &(&core.z - &core.m * &held), &DVector::zeros(free.len()))?;
        // The first bound on the way.
        let share = |(place, k): (usize, usize)| {
            let step = best[place] - u[k];
            let room = if step < 0.0 { lower[k] - u[k] } else { upper[k] - u[k] };
            (best[place] < lower[k] || best[place] > upper[k])
                .then(|| ((room / step).clamp(0.0, 1.0), k, step < 0.0))
        };
        let first = free.iter().copied().enumerate().filter_map(share).min_by(|a, b| a.0.total_cmp(&b.0));
        let along = first.map_or(1.0, |f| f.0);
        free.iter().zip(best.iter()).for_each(|(&k, b)| u[k] += along * (b - u[k]));
        if along > 0.0 {
            stuck.fill(false);
        }
        if let Some((share, k, down)) = first {
            stuck[k] |= share == 0.0;
            at[k] = if down { At::Lower } else { At::Upper };
            u[k] = if down { lower[k] } else { upper[k] };
            continue;
        }
        free.iter().zip(best.iter()).for_each(|(&k, b)| u[k] = *b);
        let g = core.gradient(&u);
        let wrong = |k: usize| match at[k] {
            _ if stuck[k] || lower[k] >= upper[k] => 0.0,
            At::Free => 0.0,
            At::Lower => -g[k],
            At::Upper => g[k],
        };
        match (0..p).filter(|k| wrong(*k) > SETTLED).max_by(|a, b| wrong(*a).total_cmp(&wrong(*b))) {
            Some(k) => at[k] = At::Free,
            None => break,
        }
    }
    Some(u)
}

#[cfg(test)]
mod tests {
    use crate::{Bounded, Bounds, LeastSquares, Solver, Status};
    use nalgebra::{DMatrix, DVector};

    /// Columns nearly dependent, tolerances that bind in many of them: the conditions hold on the rows.
    #[test]
    fn nearly_dependent_columns_within_tolerances() {
        let wave = |i: usize, j: usize| ((i * 19 + j * 31 + i * j * 7) as f64 * 0.77).sin();
        for (seed, condition) in [(1_usize, 1e6), (2, 1e8), (3, 1e9), (4, 1e10), (5, 1e11)] {
            let (m, p) = (200, 20);
            let u = DMatrix::from_fn(m, p, |i, j| wave(i + seed, j + 3)).qr().q();
            let v = DMatrix::from_fn(p, p, |i, j| wave(i + 5, j + seed)).qr().q();
            let d = DVector::from_fn(p, |k, _| 1e3 * f64::powf(condition, -(k as f64) / (p - 1) as f64));
            let a = u * DMatrix::from_diagonal(&d) * v.transpose();
            let y = &a * DVector::from_fn(p, |j, _| wave(j, seed)) + DVector::from_fn(m, |i, _| wave(i, 77));
            let bounds = (0..p).fold(Bounds::free(p), |b, j| b.with(j, -2.0, 2.0));
            let s = Bounded::default().solve(&LeastSquares::new(&a, &y).with_bounds(&bounds)).unwrap();
            assert_eq!(s.status, Status::Converged, "κ {condition:e}");
            assert!(bounds.contains(s.x.as_slice()));
            let g = a.tr_mul(&(&a * &s.x - &y));
            for j in 0..p {
                let relative = g[j] / a.column(j).norm() / y.norm();
                let fine = (s.x[j] <= -2.0 || relative < 1e-9) && (s.x[j] >= 2.0 || relative > -1e-9);
                assert!(fine, "κ {condition:e} column {j}: {relative}");
            }
        }
    }
}
