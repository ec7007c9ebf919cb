//! Gains of candidates X beside the present model with further columns C, under any noise: from normal equations.
//!
//! ```text
//! ZᵀV⁻¹Z + P = L Lᵀ,   Z = [A | C],   H = ZᵀV⁻¹X,   T: basis of XᵀV⁻¹X − (L⁻¹H)ᵀ(L⁻¹H)
//! SS = ‖Tᵀ(XᵀV⁻¹y − Hᵀβ)‖²,   LR = −m ln(1 − SS/RSS)
//! ```
//!
//! P is the precision of the priors ([`precision`]), β the solution without X. Everything that does not depend on the noise is formed once:
//! where numbers go by classes ([`crate::problem::normal`]), another noise costs no product of m rows with the model's columns.

use crate::problem::basis::{basis, gain};
use crate::problem::equations::{precision, solved};
use crate::problem::likelihood::joined;
use crate::problem::linearisation::Linearisation;
use crate::problem::noise::Noise;
use crate::problem::normal::Grouped;
use crate::statistics::product::{cross, gram_matrix};
use nalgebra::DMatrix;
use std::ops::Range;

/// Candidates that are judged beside others.
pub(crate) struct Pool {
    /// Raw columns, side by side: m × K.
    columns: DMatrix<f64>,
    /// Those of each candidate.
    each: Vec<Range<usize>>,
    grouped: Option<Grouped>,
}

/// ZᵀV⁻¹Z with Z = [A | C | y], ZᵀV⁻¹X of all candidates, and XᵀV⁻¹X of each.
type Sums = (DMatrix<f64>, DMatrix<f64>, Vec<DMatrix<f64>>);

impl Pool {
    /// Candidates of these raw columns, m × k each.
    pub fn new(linearisation: &Linearisation<'_>, candidates: &[&DMatrix<f64>]) -> Self {
        let mut each = Vec::with_capacity(candidates.len());
        let mut all = Vec::new();
        let mut first = 0;
        for columns in candidates {
            each.push(first..first + columns.ncols());
            first += columns.ncols();
            all.extend_from_slice(columns.as_slice());
        }
        let columns = DMatrix::from_vec(linearisation.len(), first, all);
        let grouped = linearisation.normal().map(|normal| normal.grouped(&columns));
        Pool { columns, each, grouped }
    }

    /// (gain, freedom) of each candidate beside further raw columns (m × k) under a noise; none where nothing of it is left, or where the
    /// equations have no solution.
    pub fn gains(
        &self,
        linearisation: &Linearisation<'_>,
        more: &DMatrix<f64>,
        noise: Noise,
    ) -> Vec<Option<(f64, usize)>> {
        let nothing = || vec![None; self.each.len()];
        let (gram, across, own) = self.sums(linearisation, more, noise);
        let (r, k) = (linearisation.base.ncols(), more.ncols());
        let (n, m) = (r + k, linearisation.len());
        let prior =
            precision(linearisation.prior_precision(), &Vec::from_iter(0..r), k, linearisation.policy.wide);
        let Ok((solution, factor)) = solved(&gram, &prior) else { return nothing() };
        let rss = gram[(n, n)] - gram.view((0, n), (n, 1)).dot(&solution);
        let along = across.rows(0, n).into_owned();
        let score = across.row(n).transpose() - along.tr_mul(&solution);
        let half = factor.half(along);
        let one = |(own, which): (&DMatrix<f64>, &Range<usize>)| {
            let half = half.columns(which.start, which.len()).into_owned();
            let basis = basis(own, &(own - gram_matrix(&half)), linearisation.policy.absorbed)?;
            let squares = basis.tr_mul(&score.rows(which.start, which.len())).norm_squared();
            Some((gain(m, squares, rss), basis.ncols()))
        };
        own.iter().zip(&self.each).map(one).collect()
    }

    fn sums(&self, linearisation: &Linearisation<'_>, more: &DMatrix<f64>, noise: Noise) -> Sums {
        let k = more.ncols();
        if let (Some(normal), Some(grouped)) = (linearisation.normal(), &self.grouped)
            && !noise.joints.is_some()
        {
            let gram = normal.gram(noise.rows, &normal.candidate_products(more)).0;
            let of_model = normal.across(noise.rows, grouped);
            let (n, all) = (of_model.nrows() - 1 + k, self.columns.ncols());
            let mut across = DMatrix::zeros(n + 1, all);
            across.rows_mut(0, n - k).copy_from(&of_model.rows(0, n - k));
            across.rows_mut(n - k, k).copy_from(&normal.between(noise.rows, &normal.grouped(more), grouped));
            across.row_mut(n).copy_from(&of_model.row(n - k));
            let own = self.each.iter().map(|which| normal.own(noise.rows, grouped, which.clone()));
            return (gram, across, own.collect());
        }
        let whitener = linearisation.whitener(noise);
        let (model, white) = (whitener.of(&joined(linearisation, more)), whitener.of(&self.columns));
        let own = |which: &Range<usize>| gram_matrix(&white.columns(which.start, which.len()).into_owned());
        (gram_matrix(&model), cross(&model, &white), self.each.iter().map(own).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::DiscoverOptions;
    use crate::problem::synthetic::{data_of, fitted, normal, wave};
    use truepose_identify::NoiseModel;

    #[test]
    fn gains_are_those_of_least_squares_with_the_priors_rows() {
        let (chain, data) = data_of(40, 4, &|joints| joints.to_vec(), &|_, _, row| {
            std::array::from_fn(|axis| 3e-5 * normal(3 * row + axis))
        });
        let fit = fitted(&chain, &data);
        let options = DiscoverOptions::default();
        let mut uneven = data.clone();
        uneven.position_sd.iter_mut().enumerate().for_each(|(row, sd)| *sd = [1e-5 * (1.0 + row as f64); 3]);
        for data in [&data, &uneven] {
            let mut linearisation = Linearisation::new(&fit, data, &options).unwrap();
            let r = linearisation.base.ncols();
            linearisation.prior = Some(DMatrix::from_fn(r, r, |i, j| f64::from(u8::from(i == j)) * 40.0));
            let noise: Noise = NoiseModel { position_sd: 2e-5, visit_sd: 1e-5, orientation_sd: 1e-4 }.into();
            let columns = |k: usize, seed: usize| {
                DMatrix::from_fn(linearisation.len(), k, |i, j| 1e-4 * wave(seed + 31 * i + 7 * j))
            };
            let more = columns(3, 5);
            let candidates = [columns(1, 100), columns(4, 200), more.clone()];
            let pool = Pool::new(&linearisation, &candidates.iter().collect::<Vec<_>>());
            let gains = pool.gains(&linearisation, &more, noise);
            assert!(gains[2].is_none(), "nothing is left of what stands there already: {gains:?}");
            // The rows of the priors below those of the data.
            let whitener = linearisation.whitener(noise);
            let tall = |raw: &DMatrix<f64>, below: DMatrix<f64>| {
                let white = whitener.of(raw);
                let rows = white.nrows();
                let mut tall = white.resize_vertically(rows + r + 3, 0.0);
                tall.rows_mut(rows, r + 3).copy_from(&below);
                tall
            };
            let mut below = DMatrix::zeros(r + 3, r + 4);
            (0..r).for_each(|k| below[(k, k)] = 40.0);
            (r..r + 3).for_each(|k| below[(k, k)] = 1.0 / options.policy.wide);
            let all = tall(&joined(&linearisation, &more), below);
            let q = all.columns(0, r + 3).into_owned().qr().q();
            let left = |x: DMatrix<f64>| &x - &q * q.tr_mul(&x);
            let y = left(all.columns(r + 3, 1).into_owned());
            for (x, found) in candidates.iter().zip(&gains).take(2) {
                let k = x.ncols();
                let q = left(tall(x, DMatrix::zeros(r + 3, k))).qr().q();
                let share = q.tr_mul(&y).norm_squared() / y.norm_squared();
                let expected = -(linearisation.len() as f64) * (1.0 - share).ln();
                let (gain, freedom) = found.unwrap();
                assert_eq!(freedom, k);
                assert!((gain - expected).abs() < 1e-6 * (1.0 + expected), "{gain} {expected}");
            }
        }
    }
}
