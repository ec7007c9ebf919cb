//! Family-wise p-values by sign-flipping whole units: visits, or neighbouring visits together.
//!
//! ```text
//! T  = max over all candidates of the surprise of −m ln(1 − SS/RSS)
//! T* = the same of P S r̃, S a random sign for each unit
//! p  = (1 + #{T* ≥ T}) / (B + 1)
//! ```
//!
//! RSS is that of the flipped residual after the present model has been projected out of it, so that the statistic is normalised.
//! Source: Freedman and Lane (1983); Winkler et al. (2014) for exchangeable blocks.

use crate::projection::Projection;
use crate::surprise::surprise;
use nalgebra::DMatrix;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// The distribution of the largest statistic when nothing is missing.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NullDistribution {
    /// Ascending.
    largest: Vec<f64>,
}

/// Scores of several statistics side by side: units × (sum of freedoms).
pub(crate) struct Block<'a> {
    pub by_unit: &'a DMatrix<f32>,
    /// Degrees of freedom of each statistic, in the order of the columns.
    pub freedoms: Vec<usize>,
}

impl NullDistribution {
    pub fn new(projection: &Projection, blocks: &[Block<'_>], flips: usize, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x5167_f11b);
        let signs = DMatrix::<f32>::from_fn(flips, projection.units, |_, _| {
            if random.next_u32() & 1 == 0 { 1.0 } else { -1.0 }
        });
        // ‖P S r̃‖² = ‖r̃‖² − ‖Q_1ᵀ S r̃‖².
        let absorbed = &signs * projection.q_by_unit.map(|v| v as f32);
        let whole = projection.residual.norm_squared();
        let inverse: Vec<f32> = (0..flips)
            .map(|b| {
                let gone: f64 = absorbed.row(b).iter().map(|&v| f64::from(v).powi(2)).sum();
                (1.0 / (whole - gone).max(1e-3 * whole)) as f32
            })
            .collect();
        // The surprise grows with the share: only the largest share of each number of unknowns has to be turned into one.
        let widest = blocks.iter().flat_map(|block| block.freedoms.iter().copied()).max().unwrap_or(0);
        let shares = blocks
            .par_iter()
            .map(|block| {
                let sums = &signs * block.by_unit;
                let mut shares = DMatrix::<f32>::zeros(flips, widest + 1);
                let mut squares = vec![0.0f32; flips];
                let mut first = 0;
                for &freedom in &block.freedoms {
                    squares.fill(0.0);
                    for column in
                        sums.as_slice()[first * flips..(first + freedom) * flips].chunks_exact(flips)
                    {
                        for (square, v) in squares.iter_mut().zip(column) {
                            *square += v * v;
                        }
                    }
                    let most = &mut shares.as_mut_slice()[freedom * flips..(freedom + 1) * flips];
                    for ((most, square), inverse) in most.iter_mut().zip(&squares).zip(&inverse) {
                        *most = most.max(square * inverse);
                    }
                    first += freedom;
                }
                shares
            })
            .reduce(|| DMatrix::zeros(flips, widest + 1), |a, b| a.zip_map(&b, f32::max));
        let mut largest: Vec<f64> = shares
            .row_iter()
            .map(|row| {
                row.iter()
                    .enumerate()
                    .filter(|(_, share)| **share > 0.0)
                    .map(|(freedom, &share)| surprise(projection.gain(f64::from(share), 1.0), freedom))
                    .fold(f64::NEG_INFINITY, f64::max)
            })
            .collect();
        largest.sort_by(f64::total_cmp);
        NullDistribution { largest }
    }

    /// (1 + #{T* ≥ T}) / (B + 1).
    pub fn p_value(&self, statistic: f64) -> f64 {
        let below = self.largest.partition_point(|&t| t < statistic);
        (1 + self.largest.len() - below) as f64 / (self.largest.len() + 1) as f64
    }

    /// The statistic that is reached by chance with this probability.
    pub fn critical(&self, alpha: f64) -> f64 {
        let n = self.largest.len();
        let at = ((1.0 - alpha) * n as f64).ceil() as usize;
        self.largest.get(at.min(n.saturating_sub(1))).copied().unwrap_or(f64::INFINITY)
    }
}
