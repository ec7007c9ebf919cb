//! Group lasso: an effect enters as a whole or stays out.
//!
//! minimise ½ ‖W^{1/2} (A x − y)‖² + λ Σ_G √|G| ‖v_G‖,  v = x / s
//!
//! optimal: g_G = −λ √|G| v_G / ‖v_G‖ where v_G ≠ 0, ‖g_G‖ ≤ λ √|G| elsewhere
//!
//! | symbol | name | shape |
//! | --- | --- | --- |
//! | G | columns of one effect (`column_groups`) | – |
//! | g | gradient of the squares along v | p |
//!
//! Source: Yuan and Lin (2006). Newton's method on the groups that stay makes the answer exact: the curvature
//! (λ√|G| / ‖v_G‖)(I − v̂ v̂ᵀ) of a norm is a square, so each step is a least-squares problem and is solved by QR.

use super::core::{Core, Inner};
use super::newton::newton;
use super::penalised::{Penalty, Strength, path, solve};
use super::program::Program;
use super::shifted::shifted;
use crate::problem::collect_groups;
use crate::{LeastSquares, Need, Solution, SolveError, Solver};
use nalgebra::{DMatrix, DVector};

/// Norms of groups as penalty: whole effects stay or go. Without `column_groups` each column is a group.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GroupLasso {
    /// How λ is chosen.
    pub strength: Strength,
    /// Fit the effects that stay once more, without the penalty.
    pub refit: bool,
}

impl Solver for GroupLasso {
    fn name(&self) -> &str {
        "group_lasso"
    }

    fn supports(&self, need: Need) -> bool {
        matches!(need, Need::RankDeficient | Need::Weights | Need::ColumnGroups)
    }

    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        problem.admit(self)?;
        solve(problem, &Norms::of(problem), self.strength, self.refit)
    }
}

/// The group-lasso answers at `count` strengths from λ_max down to `least` λ_max.
pub fn group_lasso_path(
    problem: &LeastSquares<'_>,
    count: usize,
    least: f64,
) -> Result<Vec<Solution>, SolveError> {
    problem.validate()?;
    path(problem, &Norms::of(problem), count, least)
}

/// Groups of columns of the problem.
struct Norms {
    ids: Vec<usize>,
}

impl Norms {
    fn of(problem: &LeastSquares<'_>) -> Self {
        Self {
            ids: problem.column_groups.map_or_else(|| (0..problem.columns()).collect(), <[usize]>::to_vec),
        }
    }

    /// Groups in the numbering of the core, each with √|G|.
    fn groups(&self, core: &Core) -> Vec<(Vec<usize>, f64)> {
        let ids: Vec<usize> = core.live.iter().map(|j| self.ids[*j]).collect();
        collect_groups(&ids).into_iter().map(|g| (g.clone(), (g.len() as f64).sqrt())).collect()
    }
}

impl Penalty for Norms {
    fn top(&self, core: &Core, omega: &[f64]) -> f64 {
        let g = core.gradient(&DVector::zeros(omega.len()));
        self.groups(core)
            .iter()
            .fold(0.0, |top: f64, (group, root)| top.max(length(group, |k| g[k] / omega[k]) / root))
    }

    fn solve(&self, core: &Core, omega: &[f64], lambda: f64) -> Inner {
        let groups = self.groups(core);
        let p = omega.len();
        let mut program = Program::residual_form(&core.m, &core.z);
        for (group, root) in &groups {
            let t = program.variable(lambda * root);
            program.row(&[(t, -1.0)], 0.0);
            group.iter().for_each(|k| program.row(&[(*k, -omega[*k])], 0.0));
            program.second_order(group.len() + 1);
        }
        let ended = program.run();
        if ended.v.is_empty() && p > 0 {
            return Inner::failed(ended.status, ended.iterations);
        }
        let mut interior = DVector::from_column_slice(&ended.v[..p]);
        let g = core.gradient(&interior);
        for (group, root) in &groups {
            let slack = lambda * root - length(group, |k| g[k] / omega[k]);
            if length(group, |k| interior[k] * omega[k]) <= slack {
                group.iter().for_each(|k| interior[*k] = 0.0);
            }
        }
        let measure = |u: &DVector<f64>| violation(core, omega, &groups, lambda, u);
        let polished = Active { core, omega, groups: &groups, lambda }.polish(interior.clone());
        let after = measure(&polished);
        let before = measure(&interior);
        Inner::best((interior, before), Some((polished, after)), ended.status, ended.iterations)
    }
}

fn length(group: &[usize], at: impl Fn(usize) -> f64) -> f64 {
    crate::dense::norm(&group.iter().map(|k| at(*k)).collect::<Vec<_>>())
}

fn violation(core: &Core, omega: &[f64], groups: &[(Vec<usize>, f64)], lambda: f64, u: &DVector<f64>) -> f64 {
    let g = core.gradient(u);
    groups.iter().fold(0.0, |worst: f64, (group, root)| {
        let size = length(group, |k| u[k] * omega[k]);
        let limit = lambda * root;
        worst.max(if size == 0.0 {
            length(group, |k| g[k] / omega[k]) - limit
        } else {
            length(group, |k| g[k] / omega[k] + limit * u[k] * omega[k] / size)
        })
    })
}

/// The groups that are not zero, and what moves in and out of them.
struct Active<'a> {
    core: &'a Core,
    omega: &'a [f64],
    groups: &'a [(Vec<usize>, f64)],
    lambda: f64,
}

impl Active<'_> {
    fn size(&self, group: &[usize], u: &DVector<f64>) -> f64 {
        length(group, |k| u[k] * self.omega[k])
    }

    /// Newton's method on what is in; then the group that wants in most comes in, and one that may go goes.
    fn polish(&self, start: DVector<f64>) -> DVector<f64> {
        let mut u = start;
        for _ in 0..3 * self.groups.len() + 10 {
            u = newton(u, |u| self.pull(u), |u| self.direction(u));
            if !self.release(&mut u) && !self.cross(&mut u) && !self.admit(&mut u) {
                break;
            }
        }
        u
    }

    /// Size of the gradient over the groups that are in.
    fn pull(&self, u: &DVector<f64>) -> f64 {
        let g = self.core.gradient(u);
        let of = |(group, root): &(Vec<usize>, f64)| {
            let size = self.size(group, u);
            let along = |k: usize| g[k] / self.omega[k] + self.lambda * root * u[k] * self.omega[k] / size;
            if size > 0.0 { length(group, along) } else { 0.0 }
        };
        crate::dense::norm(&self.groups.iter().map(of).collect::<Vec<_>>())
    }

    /// Sets to zero a group that is small and optimal at zero.
    fn release(&self, u: &mut DVector<f64>) -> bool {
        const SMALL: f64 = 1e-5;
        for (group, root) in self.groups {
            let size = self.size(group, u);
            if size == 0.0 || size > SMALL {
                continue;
            }
            let mut without = u.clone();
            group.iter().for_each(|k| without[*k] = 0.0);
            let g = self.core.gradient(&without);
            if length(group, |k| g[k] / self.omega[k]) <= self.lambda * root {
                *u = without;
                return true;
            }
        }
        false
    }

    /// ½ ‖M u − z‖² + λ Σ √|G| ‖v_G‖.
    fn objective(&self, u: &DVector<f64>) -> f64 {
        let penalty: f64 = self.groups.iter().map(|(group, root)| root * self.size(group, u)).sum();
        0.5 * (&self.core.m * u - &self.core.z).norm_squared() + self.lambda * penalty
    }

    /// Where Newton would carry a group through zero, which it does when columns of two groups are nearly the same: goes
    /// that far, and sets the group to zero.
    fn cross(&self, u: &mut DVector<f64>) -> bool {
        const SETTLED: f64 = 1e-13;
        if self.pull(u) <= SETTLED {
            return false;
        }
        let Some(d) = self.direction(u) else { return false };
        let reach = |(group, _): &(Vec<usize>, f64)| {
            let (mut against, mut square) = (0.0, 0.0);
            for &k in group {
                against -= u[k] * d[k] * self.omega[k].powi(2);
                square += (d[k] * self.omega[k]).powi(2);
            }
            (self.size(group, u) > 0.0 && against > 0.0).then(|| against / square).filter(|t| *t <= 1.0)
        };
        let first =
            self.groups.iter().filter_map(|g| reach(g).map(|t| (t, g))).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((t, (group, _))) = first else { return false };
        let mut moved = &*u + d * t;
        group.iter().for_each(|k| moved[*k] = 0.0);
        let better = self.objective(&moved) <= self.objective(u) * (1.0 + 1e-14);
        if better {
            *u = moved;
        }
        better
    }

    /// Lets the group in that is furthest from being optimal at zero, at the best length along its gradient.
    fn admit(&self, u: &mut DVector<f64>) -> bool {
        const SETTLED: f64 = 1e-13;
        let g = self.core.gradient(u);
        let over = |(group, root): &(Vec<usize>, f64)| {
            if self.size(group, u) > 0.0 {
                return 0.0;
            }
            length(group, |k| g[k] / self.omega[k]) - self.lambda * root
        };
        let worst = self.groups.iter().max_by(|a, b| over(a).total_cmp(&over(b)));
        let Some((group, root)) = worst.filter(|w| over(w) > SETTLED) else { return false };
        let mut d = DVector::zeros(u.len());
        group.iter().for_each(|k| d[*k] = -g[*k] / self.omega[*k].powi(2));
        let slope = length(group, |k| g[k] / self.omega[k]);
        let curvature = (&self.core.m * &d).norm_squared();
        let step = slope * (slope - self.lambda * root) / curvature;
        if step.is_finite() {
            *u += d * step;
        }
        step.is_finite()
    }

    /// −H⁻¹ ∇f over the groups that are in, by QR of [M; √stiff (I − v̂ v̂ᵀ) ω].
    fn direction(&self, u: &DVector<f64>) -> Option<DVector<f64>> {
        let kept: Vec<usize> = (0..u.len()).filter(|k| u[*k] != 0.0).collect();
        let place = |k: usize| kept.iter().position(|j| *j == k);
        let rows = self.core.m.nrows();
        let mut m = DMatrix::zeros(rows + kept.len(), kept.len());
        m.view_mut((0, 0), (rows, kept.len())).copy_from(&self.core.m.select_columns(&kept));
        let mut h = DVector::zeros(kept.len());
        for (group, root) in self.groups {
            let size = self.size(group, u);
            if size == 0.0 {
                continue;
            }
            let v = |k: usize| u[k] * self.omega[k] / size;
            let stiff = (self.lambda * root / size).sqrt();
            for &k in group {
                let Some(row) = place(k) else { continue };
                h[row] = self.lambda * root * self.omega[k] * v(k);
                for &l in group {
                    let Some(column) = place(l) else { continue };
                    let same = if k == l { 1.0 } else { 0.0 };
                    m[(rows + row, column)] = stiff * (same - v(k) * v(l)) * self.omega[l];
                }
            }
        }
        let z = (&self.core.z - &self.core.m * u).resize_vertically(rows + kept.len(), 0.0);
        let step = shifted(&m, &z, &h)?;
        let mut d = DVector::zeros(u.len());
        kept.iter().zip(step.iter()).for_each(|(k, s)| d[*k] = *s);
        Some(d)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Status;

    #[test]
    fn passes_the_kit() {
        for ratio in [0.5, 1e-2, 1e-4] {
            crate::testkit::check_solver(&GroupLasso { strength: Strength::Ratio(ratio), refit: false });
        }
        crate::testkit::check_solver(&GroupLasso { strength: Strength::Ratio(0.1), refit: true });
    }

    /// Groups of 3; every third group matters.
    #[test]
    fn optimality_conditions_hold_on_the_rows_and_groups_stay_whole() {
        let (m, p) = (200, 24);
        let wave = |i: usize, j: usize| ((i * 19 + j * 31 + i * j) as f64 * 0.77).sin();
        let a = DMatrix::from_fn(m, p, |i, j| wave(i, j) * 10f64.powi((j % 5) as i32 - 2));
        let ids: Vec<usize> = (0..p).map(|j| 100 + j / 3).collect();
        let y = DVector::from_fn(m, |i, _| {
            0.1 * wave(i * i, 9) + (0..p).filter(|j| j / 3 % 3 == 0).map(|j| wave(i, j)).sum::<f64>()
        });
        let problem = LeastSquares::new(&a, &y).with_column_groups(&ids);
        for s in group_lasso_path(&problem, 10, 1e-3).unwrap() {
            assert_eq!(s.status, Status::Converged);
            let lambda = s.info.strength.unwrap() * 3f64.sqrt();
            let g = a.tr_mul(&(&a * &s.x - &y));
            for group in 0..8 {
                let part = |f: &dyn Fn(usize) -> f64| DVector::from_fn(3, |k, _| f(3 * group + k));
                let v = part(&|j| s.x[j] * a.column(j).norm());
                let g = part(&|j| g[j] / a.column(j).norm());
                let wrong =
                    if v.norm() == 0.0 { g.norm() - lambda } else { (g + &v * (lambda / v.norm())).norm() };
                assert!(wrong < 1e-7 * y.norm(), "λ {lambda} group {group}: {wrong}");
                assert!(v.iter().all(|v| *v != 0.0) || v.norm() == 0.0);
            }
            assert!(s.info.optimality.unwrap() < 1e-10, "{:?}", s.info.optimality);
        }
        let chosen = GroupLasso { refit: true, strength: Strength::Ratio(0.1) }.solve(&problem).unwrap();
        let groups: Vec<usize> = chosen.info.kept.unwrap().chunks(3).map(|c| c[0] / 3).collect();
        assert_eq!(groups, vec![0, 3, 6]);
    }
}
