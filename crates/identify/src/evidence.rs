//! The marginal likelihood of a linear picture, in the directions of the prior.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | R L = U diag(d) Vᵀ | whitened data in prior units (κ = 1) | r × r | 1 |
//! | t = Uᵀ z | `(d², t²)` are the `pairs` | r | 1 |
//! | s | factor on all standard deviations | 1 | 1 |
//! | N, q | numbers measured, squares that no column reaches | 1 | 1 |
//!
//! ```text
//! min_κ       Σ_k  ln(1 + κ² d_k²) + t_k² / (1 + κ² d_k²)                               the noise is known
//! min_{κ,s}   N ln s² + Σ_k ln(1 + g² d_k²) + (q + Σ_k t_k² / (1 + g² d_k²)) / s²,  κ = g s     its shape alone is known
//! ```
//!
//! Directions that are held to nothing (`free`) are eliminated first, and take as many of the N numbers: that they are small beside their width
//! says nothing of κ.
//!
//! For a given g the best s² is `(q + Σ_k t_k² / (1 + g² d_k²)) / N`. Source: as of [`crate::Prior`].

use crate::IdentifyError;
use nalgebra::DMatrix;
use truepose_solvers::accumulator::{ColumnScale, Factor, Triangular};
use truepose_solvers::minimum;

/// κ before the data has been looked at, and where it has nothing to say of it.
pub(crate) const START: f64 = 30.0;

/// The range in which κ is looked for.
pub(crate) const LEAST: f64 = 0.1;
pub(crate) const MOST: f64 = 1e4;

/// The squares of d and t.
pub(crate) struct Evidence {
    pairs: Vec<(f64, f64)>,
    /// Directions that are held to nothing.
    free: usize,
}

impl Evidence {
    /// Of a whitened factor with absolute coefficients on its right, and L; `free`: the unknowns that are held to nothing.
    pub(crate) fn new(factor: &Factor, spread: &DMatrix<f64>, free: &[usize]) -> Result<Self, IdentifyError> {
        // R L: columns of data in prior units.
        let mut inner = factor.clone();
        inner.r = &factor.r * spread;
        if !free.is_empty() {
            inner = without(&inner, free)?;
        }
        let turned = inner.directions(ColumnScale::Unit)?;
        let pairs = turned.values.iter().zip(&turned.projections).map(|(d, t)| (d * d, t * t)).collect();
        Ok(Evidence { pairs, free: free.len() })
    }

    /// Σ ln(1 + g² d²) and Σ t²/(1 + g² d²).
    fn parts(&self, square: f64) -> (f64, f64) {
        let (mut logarithm, mut rest) = (0.0, 0.0);
        // Logarithms of products: of so many factors that none is beyond what a number can hold.
        for some in self.pairs.chunks(8) {
            let mut product = 1.0;
            for (d, t) in some {
                let variance = 1.0 + square * d;
                product *= variance;
                rest += t / variance;
            }
            logarithm += if product.is_finite() {
                product.ln()
            } else {
                some.iter().map(|(d, _)| (1.0 + square * d).ln()).sum()
            };
        }
        (logarithm, rest)
    }

    /// κ where the noise is known.
    pub(crate) fn kappa(&self) -> f64 {
        if self.pairs.is_empty() {
            return START; // nothing is held
        }
        let deviance = |log_kappa: f64| {
            let (logarithm, rest) = self.parts((2.0 * log_kappa).exp());
            logarithm + rest
        };
        minimum(LEAST.ln(), MOST.ln(), deviance).exp()
    }

    /// κ, and the factor on all standard deviations.
    pub(crate) fn kappa_and_scale(&self, rss: f64, numbers: usize) -> (f64, f64) {
        let count = numbers.saturating_sub(self.free).max(1) as f64;
        if self.pairs.is_empty() {
            return (START, (rss / count).max(f64::MIN_POSITIVE).sqrt());
        }
        let variance = |square: f64| {
            let (logarithm, rest) = self.parts(square);
            (logarithm, ((rss + rest) / count).max(f64::MIN_POSITIVE))
        };
        // A model that explains everything to the last digit would have no noise: g without end.
        let deviance = |log_ratio: f64| {
            let (logarithm, variance) = variance((2.0 * log_ratio).exp());
            count * variance.ln() + logarithm
        };
        let ratio = minimum(SMALLEST.ln(), LARGEST.ln(), deviance).exp();
        let scale = variance(ratio * ratio).1.sqrt();
        ((ratio * scale).clamp(LEAST, MOST), scale)
    }

    /// The factor on all standard deviations where κ is known: what is left over, over the numbers that are free.
    pub(crate) fn scale(&self, kappa: f64, rss: f64, numbers: usize) -> f64 {
        let numbers = numbers.saturating_sub(self.free);
        if kappa.is_finite() {
            // κ stays while s moves: the fixed point, a few turns from the plain one.
            return (0..20).fold(1.0, |s: f64, _| {
                let (_, rest) = self.parts((kappa / s).powi(2));
                ((rss + rest) / numbers.max(1) as f64).max(f64::MIN_POSITIVE).sqrt()
            });
        }
        let free = numbers.saturating_sub(self.pairs.len()).max(1) as f64;
        (rss / free).max(f64::MIN_POSITIVE).sqrt()
    }
}

/// A factor without these unknowns, whatever they are.
fn without(factor: &Factor, free: &[usize]) -> Result<Factor, IdentifyError> {
    let held: Vec<usize> = (0..factor.columns()).filter(|k| !free.contains(k)).collect();
    let order: Vec<usize> = free.iter().chain(&held).copied().collect();
    let mut all = Triangular::new(factor.columns(), factor.z.ncols());
    all.update(&factor.r.select_columns(&order), &factor.z)?;
    let mut rest = all.finish();
    let (begin, count) = (free.len(), held.len());
    rest.r = rest.r.view((begin, begin), (count, count)).into_owned();
    rest.z = rest.z.rows(begin, count).into_owned();
    rest.rss.clone_from(&factor.rss);
    Ok(rest)
}

/// The range of κ over the noise's factor.
const SMALLEST: f64 = 1e-4;
const LARGEST: f64 = 1e8;
