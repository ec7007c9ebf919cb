//! The exact Huber fit, as one convex program.
//!
//! minimise Σ_g ρ(‖r_g‖),  ρ(t) = ½ t² up to δ_g, δ_g t − ½ δ_g² beyond;  r = W^{1/2} (A x − y),  δ_g = k σ √n_g
//!
//! optimal: Σ_g w_g A_gᵀ r_g = 0 with w_g = min(1, δ_g / ‖r_g‖)
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | r_g | whitened residual of a visit of n_g rows | n_g | 1 |
//! | σ | its scale: given, or that of a reweighted fit | 1 | 1 |
//!
//! ρ is ½ ‖r − o‖² + δ ‖o‖ at its best o, which is what the cones see. It needs the rows themselves, so it costs more
//! than [`Robust::huber`](crate::Robust); it has no start and no reweighting, and the two check each other.

use super::core::{Core, Inner};
use super::newton::newton;
use super::program::Program;
use super::shifted::shifted;
use crate::accumulator::Factor;
use crate::dense::norm;
use crate::{LeastSquares, Need, PivotedQr, Robust, Solution, SolveError, Solver};
use nalgebra::{DMatrix, DVector};

/// Huber's loss on whole visits, to optimality.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExactHuber {
    /// Where the pull of a visit stops growing, in units of the noise.
    pub k: f64,
    /// Standard deviation of a whitened row; estimated when absent.
    pub noise: Option<f64>,
}

impl Default for ExactHuber {
    fn default() -> Self {
        Self { k: 1.345, noise: None }
    }
}

impl Solver for ExactHuber {
    fn name(&self) -> &str {
        "huber_exact"
    }

    fn supports(&self, need: Need) -> bool {
        matches!(need, Need::RankDeficient | Need::Weights | Need::Outliers | Need::Unpenalised)
    }

    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        crate::Loss::Huber { k: self.k }.validate()?;
        problem.admit(self)?;
        let noise = match self.noise {
            Some(value) if !(value > 0.0 && value.is_finite()) => {
                return Err(SolveError::BadOption {
                    option: "noise",
                    value,
                    expected: "a finite number > 0",
                });
            }
            Some(noise) => noise,
            None => {
                let mut reweighted = Robust::huber(PivotedQr::default());
                reweighted.loss = crate::Loss::Huber { k: self.k };
                reweighted.tolerance = 1e-6;
                reweighted.only_where_contaminated = false;
                reweighted.solve(problem)?.info.noise.unwrap_or(0.0)
            }
        };
        let core = Core::new(&Factor::of_valid(problem))?;
        let visits = Visits::new(problem, &core, self.k * noise);
        let inner = visits.solve();
        let mut solution = core.solution(problem, &inner);
        if let Some(u) = &inner.u {
            let mut weights = vec![1.0; problem.rows()];
            for (k, group) in visits.groups.iter().enumerate() {
                let w = visits.weight(k, &(&visits.m * u - &visits.z));
                group.iter().for_each(|i| weights[*i] = w);
            }
            solution.info.row_weights = Some(weights);
        }
        solution.info.noise = Some(noise);
        Ok(solution)
    }
}

/// The rows in the units of the core.
struct Visits {
    m: DMatrix<f64>,
    z: DVector<f64>,
    groups: Vec<Vec<usize>>,
    limit: Vec<f64>,
}

impl Visits {
    fn new(problem: &LeastSquares<'_>, core: &Core, limit: f64) -> Self {
        let m = DMatrix::from_fn(problem.rows(), core.live.len(), |i, k| {
            problem.root_weight(i) * problem.a[(i, core.live[k])] * (core.unit[k] / core.size)
        });
        let z = DVector::from_fn(problem.rows(), |i, _| problem.root_weight(i) * problem.y[i] / core.size);
        let groups = problem.groups_of_rows();
        let used = |g: &Vec<usize>| g.iter().filter(|i| problem.root_weight(**i) > 0.0).count().max(1);
        let floor = 1e-12;
        let limit = groups.iter().map(|g| (limit / core.size).max(floor) * (used(g) as f64).sqrt()).collect();
        Self { m, z, groups, limit }
    }

    fn length(&self, k: usize, r: &DVector<f64>) -> f64 {
        norm(&self.groups[k].iter().map(|i| r[*i]).collect::<Vec<_>>())
    }

    fn weight(&self, k: usize, r: &DVector<f64>) -> f64 {
        let size = self.length(k, r);
        if size <= self.limit[k] { 1.0 } else { self.limit[k] / size }
    }

    /// Σ w Aᵀ r, columns of norm 1 and y of size 1.
    fn gradient(&self, u: &DVector<f64>) -> DVector<f64> {
        let r = &self.m * u - &self.z;
        let mut pulled = r.clone();
        for (k, group) in self.groups.iter().enumerate() {
            let w = self.weight(k, &r);
            group.iter().for_each(|i| pulled[*i] = w * r[*i]);
        }
        self.m.tr_mul(&pulled)
    }

    fn violation(&self, u: &DVector<f64>) -> f64 {
        self.gradient(u).iter().fold(0.0, |worst: f64, g| worst.max(g.abs()))
    }

    fn solve(&self) -> Inner {
        let p = self.m.ncols();
        let mut program = Program::residual_form(&self.m, &self.z);
        for (k, group) in self.groups.iter().enumerate() {
            let t = program.variable(self.limit[k]);
            program.row(&[(t, -1.0)], 0.0);
            for &i in group {
                let o = program.variable(0.0);
                program.in_residual(i, o, -1.0);
                program.row(&[(o, -1.0)], 0.0);
            }
            program.second_order(group.len() + 1);
        }
        let ended = program.run();
        if ended.v.is_empty() && p > 0 {
            return Inner::failed(ended.status, ended.iterations);
        }
        let interior = DVector::from_column_slice(&ended.v[..p]);
        let before = self.violation(&interior);
        // Where no visit is outside, the plain fit is the answer; the interior point need not land on it.
        let plain = shifted(&self.m, &self.z, &DVector::zeros(p)).map(|u| (self.violation(&u), u));
        let start = match plain {
            Some((violation, u)) if violation < before => u,
            _ => interior.clone(),
        };
        let polished = newton(start, |u| self.gradient(u).norm(), |u| self.direction(u));
        let after = self.violation(&polished);
        Inner::best((interior, before), Some((polished, after)), ended.status, ended.iterations)
    }

    /// −H⁻¹ ∇f: rows inside as they are, rows outside with what curvature their norm has.
    fn direction(&self, u: &DVector<f64>) -> Option<DVector<f64>> {
        let r = &self.m * u - &self.z;
        let mut m = self.m.clone();
        let mut z = -&r;
        let mut h = DVector::zeros(self.m.ncols());
        for (k, group) in self.groups.iter().enumerate() {
            let size = self.length(k, &r);
            if size <= self.limit[k] {
                continue;
            }
            let stiff = (self.limit[k] / size).sqrt();
            for j in 0..self.m.ncols() {
                let along: f64 = group.iter().map(|i| self.m[(*i, j)] * r[*i] / size).sum();
                h[j] += self.limit[k] * along;
                group.iter().for_each(|i| m[(*i, j)] = stiff * (self.m[(*i, j)] - along * r[*i] / size));
            }
            group.iter().for_each(|i| z[*i] = 0.0);
        }
        shifted(&m, &z, &h)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_the_kit() {
        crate::testkit::check_solver(&ExactHuber::default());
    }

    #[test]
    fn agrees_with_reweighting_at_the_same_noise() {
        let wave = |i: usize, j: usize| ((i * 19 + j * 31 + i * j) as f64 * 0.77).sin();
        let a = DMatrix::from_fn(150, 5, wave);
        let y = DVector::from_fn(150, |i, _| {
            wave(i, 50) * 0.1 + a[(i, 1)] + if i / 3 % 12 == 0 { 3.0 } else { 0.0 }
        });
        let ids: Vec<usize> = (0..150).map(|i| i / 3).collect();
        let problem = LeastSquares::new(&a, &y).with_row_groups(&ids);
        let reweighted = Robust::huber(PivotedQr::default()).solve(&problem).unwrap();
        let exact =
            ExactHuber { noise: reweighted.info.noise, ..Default::default() }.solve(&problem).unwrap();
        assert!((&exact.x - &reweighted.x).amax() < 1e-7, "{}", (&exact.x - &reweighted.x).amax());
        assert!(exact.info.optimality.unwrap() < 1e-12);
    }
}
