//! Absolute values (and squares) as penalty: the cones, then the signs.
//!
//! with the signs σ known: minimise ½ ‖M u − z‖² + λ Σ ω_j σ_j u_j over σ_j u_j > 0
//!
//! | symbol | name | shape |
//! | --- | --- | --- |
//! | ω | weight of the penalty on each unknown of the core | p' |
//! | σ | signs, 0 for what is out | p' |

use super::core::{Core, Inner};
use super::penalised::Penalty;
use super::program::Program;
use super::shifted::shifted;
use crate::SolveError;
use nalgebra::{DMatrix, DVector};

/// α ‖v‖₁ + ½ (1 − α) ‖v‖².
pub(super) struct Absolute {
    pub mix: f64,
}

impl Absolute {
    pub fn new(mix: f64) -> Result<Self, SolveError> {
        if mix > 0.0 && mix <= 1.0 {
            Ok(Self { mix })
        } else {
            Err(SolveError::BadOption { option: "mix", value: mix, expected: "above 0, at most 1" })
        }
    }
}

impl Penalty for Absolute {
    fn top(&self, core: &Core, omega: &[f64]) -> f64 {
        let g = core.gradient(&DVector::zeros(omega.len()));
        g.iter().zip(omega).fold(0.0, |top: f64, (g, w)| top.max(g.abs() / w)) / self.mix
    }

    fn solve(&self, core: &Core, omega: &[f64], lambda: f64) -> Inner {
        // λ of the problem is per size; the squares do not shrink with it.
        let (one, two) = (lambda * self.mix, lambda * core.size * (1.0 - self.mix));
        let p = omega.len();
        let (m, z) = below(core, omega, two);
        let mut program = Program::residual_form(&m, &z);
        for (k, w) in omega.iter().enumerate() {
            let t = program.variable(one * w);
            program.row(&[(k, 1.0), (t, -1.0)], 0.0);
            program.row(&[(k, -1.0), (t, -1.0)], 0.0);
        }
        if p > 0 {
            program.inequalities(2 * p);
        }
        let ended = program.run();
        if ended.v.is_empty() && p > 0 {
            return Inner::failed(ended.status, ended.iterations);
        }
        let limit: Vec<f64> = omega.iter().map(|w| one * w).collect();
        let raw = DVector::from_column_slice(&ended.v[..p]);
        let g = m.tr_mul(&(&m * &raw - &z));
        // A variable is zero when its own size is smaller than the slack of its gradient.
        let interior =
            DVector::from_fn(p, |k, _| if raw[k].abs() > limit[k] - g[k].abs() { raw[k] } else { 0.0 });
        let polished = active_set(&m, &z, &limit, &interior).map(|u| {
            let v = violation(&m, &z, &limit, &u);
            (u, v)
        });
        let v = violation(&m, &z, &limit, &interior);
        Inner::best((interior, v), polished, ended.status, ended.iterations)
    }
}

/// [M; √two diag(ω)] and [z; 0].
fn below(core: &Core, omega: &[f64], two: f64) -> (DMatrix<f64>, DVector<f64>) {
    if two <= 0.0 {
        return (core.m.clone(), core.z.clone());
    }
    let (rows, p) = core.m.shape();
    let m = DMatrix::from_fn(rows + p, p, |i, j| match i.checked_sub(rows) {
        None => core.m[(i, j)],
        Some(k) if k == j => two.sqrt() * omega[j],
        Some(_) => 0.0,
    });
    (m, core.z.clone().resize_vertically(rows + p, 0.0))
}

fn violation(m: &DMatrix<f64>, z: &DVector<f64>, limit: &[f64], u: &DVector<f64>) -> f64 {
    let g = m.tr_mul(&(m * u - z));
    (0..u.len()).fold(0.0, |worst: f64, k| {
        worst.max(if u[k] == 0.0 { g[k].abs() - limit[k] } else { (g[k] + limit[k] * u[k].signum()).abs() })
    })
}

/// With the signs known, the rest is least squares with a linear term; signs are corrected until they agree.
fn active_set(
    m: &DMatrix<f64>,
    z: &DVector<f64>,
    limit: &[f64],
    start: &DVector<f64>,
) -> Option<DVector<f64>> {
    const SETTLED: f64 = 1e-14;
    let p = start.len();
    let mut sign: Vec<f64> = start.iter().map(|u| if *u == 0.0 { 0.0 } else { u.signum() }).collect();
    for _ in 0..3 * p + 10 {
        let kept: Vec<usize> = (0..p).filter(|k| sign[*k] != 0.0).collect();
        let h = DVector::from_fn(kept.len(), |k, _| limit[kept[k]] * sign[kept[k]]);
        let solved = shifted(&m.select_columns(&kept), z, &h)?;
        let against = |k: usize| -solved[k] * sign[kept[k]];
        let worst =
            (0..kept.len()).filter(|k| against(*k) >= 0.0).max_by(|a, b| against(*a).total_cmp(&against(*b)));
        if let Some(k) = worst {
            sign[kept[k]] = 0.0;
            continue;
        }
        let mut u = DVector::zeros(p);
        kept.iter().zip(solved.iter()).for_each(|(k, v)| u[*k] = *v);
        let g = m.tr_mul(&(m * &u - z));
        let over = |k: usize| g[k].abs() - limit[k];
        let worst = (0..p)
            .filter(|k| sign[*k] == 0.0 && over(*k) > SETTLED)
            .max_by(|a, b| over(*a).total_cmp(&over(*b)));
        match worst {
            Some(k) => sign[k] = -g[k].signum(),
            None => return Some(u),
        }
    }
    None
}
