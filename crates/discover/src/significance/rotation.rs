//! Family-wise p-values by random rotations of the residual.
//!
//! ```text
//! p_g  = P(Beta(k_g/2, (ν − k_g)/2) ≥ SS_g/‖z‖²)                    for each candidate g
//! p_FW = P(min over g of p_g* ≤ p)                                   z* uniform in the complement of the nuisance columns
//! ```
//!
//! Under normal errors the direction of the residual is uniform, so that the distribution of the smallest p among dependent candidates depends
//! on their columns alone, not on the residual. It is sampled; below the resolution of the sample its tail is that of an effective number of
//! independent tests, `p_FW = 1 − (1 − p)^M`, with M from the lower tail of the sampled minima.
//! Source: Langsrud (2005), *Rotation tests*; Solari, Finos and Goeman (2014), *Rotation-based multiple testing*; Westfall and Young (1993).

use crate::problem::projection::{Projection, side_by_side};
use crate::statistics::beta::surprisal;
use nalgebra::{DMatrix, Dyn, Matrix, Storage};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Random directions in the complement of the present model.
pub(crate) struct Rotations {
    /// Their part in the observations, m × n.
    pub directions: DMatrix<f32>,
    /// 1/‖z*‖² of each.
    inverse: Vec<f32>,
}

impl Rotations {
    /// So many directions.
    pub fn new(projection: &Projection, count: usize, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x5167_f11b);
        let mut normal = |rows: usize| {
            let mut draw = || -> f32 { StandardNormal.sample(&mut random) };
            DMatrix::<f32>::from_fn(rows, count, |_, _| draw())
        };
        let (m, weak) = (projection.len(), projection.held.len());
        let q = projection.q.map(|v| v as f32);
        let first = q.ncols() - weak;
        let mut directions = normal(m);
        let mut below = normal(weak);
        let mut along = q.transpose() * &directions;
        for (k, &held) in projection.held.iter().enumerate() {
            for b in 0..count {
                along[(first + k, b)] += held as f32 * below[(k, b)];
            }
        }
        directions.gemm(-1.0, &q, &along, 1.0);
        for (k, &held) in projection.held.iter().enumerate() {
            for b in 0..count {
                below[(k, b)] -= held as f32 * along[(first + k, b)];
            }
        }
        let square = |b: usize| directions.column(b).norm_squared() + below.column(b).norm_squared();
        let inverse = (0..count).map(|b| 1.0 / square(b)).collect();
        Rotations { directions, inverse }
    }

    /// No candidate yet.
    pub fn nothing(&self) -> Largest {
        Largest { fractions: Vec::new(), count: self.inverse.len() }
    }

    /// Xᵀz* of the whitened columns of several candidates, one below the other.
    pub fn along(&self, candidates: &[DMatrix<f64>]) -> DMatrix<f32> {
        side_by_side(candidates, |v| v as f32).transpose() * &self.directions
    }

    /// Takes in a candidate: Xᵀz* (k × n) and the basis T of its projected columns (k × freedom).
    pub fn add<S: Storage<f32, Dyn, Dyn>>(
        &self,
        largest: &mut Largest,
        scores: &Matrix<f32, Dyn, Dyn, S>,
        basis: &DMatrix<f32>,
    ) {
        /// Beyond so many rows a product with a transposed copy, which is blocked, is faster than dot products.
        const THIN: usize = 6;
        let turned = if basis.nrows() > THIN { basis.transpose() * scores } else { basis.tr_mul(scores) };
        let most = largest.of(basis.ncols());
        for ((column, inverse), most) in turned.column_iter().zip(&self.inverse).zip(most) {
            *most = most.max(column.norm_squared() * inverse);
        }
    }
}

/// The largest explained fraction of any candidate with so many coefficients, of each direction.
pub(crate) struct Largest {
    fractions: Vec<Vec<f32>>,
    count: usize,
}

impl Largest {
    fn of(&mut self, freedom: usize) -> &mut Vec<f32> {
        if self.fractions.len() <= freedom {
            self.fractions.resize(freedom + 1, Vec::new());
        }
        let (most, count) = (&mut self.fractions[freedom], self.count);
        if most.is_empty() {
            most.resize(count, 0.0);
        }
        most
    }

    /// The fractions of candidates with so many coefficients.
    #[cfg(test)]
    pub fn fractions(&self, freedom: usize) -> &[f32] {
        &self.fractions[freedom]
    }

    /// The larger of each.
    pub fn with(mut self, other: Self) -> Self {
        for (freedom, fractions) in other.fractions.into_iter().enumerate().filter(|(_, f)| !f.is_empty()) {
            self.of(freedom).iter_mut().zip(fractions).for_each(|(a, b)| *a = a.max(b));
        }
        self
    }

    /// The distribution of the smallest p.
    pub fn distribution(self, freedom: usize) -> NullDistribution {
        let mut surprisals = vec![0.0f64; self.count];
        for (k, fractions) in self.fractions.iter().enumerate() {
            for (most, &fraction) in surprisals.iter_mut().zip(fractions) {
                *most = most.max(surprisal(f64::from(fraction), k, freedom));
            }
        }
        NullDistribution::new(surprisals, freedom)
    }
}

/// The distribution of the largest surprisal when nothing is missing.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NullDistribution {
    /// −ln of the smallest p of each direction, ascending.
    sorted: Vec<f64>,
    /// M, the effective number of independent tests.
    tests: f64,
    /// ν.
    freedom: usize,
}

impl NullDistribution {
    fn new(mut surprisals: Vec<f64>, freedom: usize) -> Self {
        /// The part of the sampled minima from which the tail is taken.
        const TAIL: f64 = 0.2;
        surprisals.sort_by(f64::total_cmp);
        // (1 − q)^M = 1 − TAIL at the quantile q of the smallest p.
        let at = ((1.0 - TAIL) * surprisals.len() as f64) as usize;
        let q = surprisals.get(at).map_or(1.0, |s| (-s).exp());
        let tests = ((1.0 - TAIL).ln() / (-q).ln_1p()).max(1.0);
        NullDistribution { sorted: surprisals, tests, freedom }
    }

    /// Family-wise p of a candidate with this surprisal; 1 where the model leaves hardly a number, so that there is none.
    pub fn p_value(&self, surprisal: f64) -> f64 {
        /// With fewer minima beyond it the tail's estimate is more precise than their count.
        const COUNTED: usize = 20;
        if surprisal.is_nan() {
            return 1.0;
        }
        let n = self.sorted.len();
        let beyond = n - self.sorted.partition_point(|&s| s < surprisal);
        if beyond >= COUNTED {
            return (1 + beyond) as f64 / (n + 1) as f64;
        }
        -(self.tests * (-(-surprisal).exp()).ln_1p()).exp_m1()
    }

    /// The surprisal that is significant at this level.
    pub fn critical(&self, alpha: f64) -> f64 {
        let single = -((-alpha).ln_1p() / self.tests).exp_m1();
        -single.ln()
    }

    /// The likelihood-ratio statistic of one coefficient that is significant at this level, of m observations.
    pub fn detectable(&self, alpha: f64, observations: usize) -> f64 {
        let critical = self.critical(alpha);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if surprisal(middle, 1, self.freedom) < critical { low = middle } else { high = middle }
        }
        -(observations as f64) * (1.0 - low).max(1e-12).ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_is_no_evidence() {
        let null = NullDistribution::new((1..200).map(|k| 0.05 * f64::from(k)).collect(), 30);
        assert!(null.p_value(30.0) < 1e-6 && null.p_value(0.01) > 0.9);
        assert_eq!(null.p_value(f64::NAN).to_bits(), 1f64.to_bits());
    }
}
