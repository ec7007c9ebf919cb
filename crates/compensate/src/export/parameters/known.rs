//! How well a number of the description is known, from how it moves with the coefficients of a fit.
//!
//! ```text
//! u² = g C gᵀ,     estimated where  |g s| ≥ 0.05 e
//! ```
//!
//! | symbol | here | shape | unit | |
//! | --- | --- | --- | --- | --- |
//! | g | `moves` | 1 × p | m or rad per unit of a coefficient | |
//! | C | covariance of the fit | p × p | | |
//! | s | `scales` | p | unit of a coefficient | expected sizes of the estimated coefficients, else 0 |
//! | e | `expected` | 1 | m, rad | expected size of a length, of an angle |
//!
//! A number that none of the estimated errors moves is not estimated, and its uncertainty is not the tiny one of what second-order terms
//! pass on to it: a roll of the tool that no position depends on would have ± 1e-6°.

use nalgebra::{DMatrix, DVector, RowDVector};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{Effect, FittedModel};

/// Fraction of expected errors below which a number follows them by terms of second order alone: errors are 1e-3 and some of them tenfold what is
/// expected, and so are those terms.
const FOLLOWS: f64 = 0.05;

/// What is known of the coefficients.
pub(super) struct Knowledge {
    covariance: DMatrix<f64>,
    scales: DVector<f64>,
    /// Expected size of an angle, of a length.
    expected: [f64; 2],
}

impl Knowledge {
    pub fn new(fitted: &FittedModel) -> Self {
        let mut expected = [1e-3; 2];
        for column in Geometric::default().columns(fitted.chain()) {
            expected[usize::from(column.unit == "m")] = column.scale;
        }
        let covariance = fitted.covariance().clone();
        let columns = fitted.model().columns();
        let scale = |k: usize| if covariance[(k, k)] > 0.0 { columns[k].scale } else { 0.0 };
        let scales = DVector::from_fn(columns.len(), |k, _| scale(k));
        Knowledge { covariance, scales, expected }
    }

    /// Standard uncertainty of a number, a length or an angle; zero where it is not estimated, or below a picometre or a picoradian.
    pub fn uncertainty(&self, moves: &RowDVector<f64>, length: bool) -> f64 {
        let follows = moves.transpose().component_mul(&self.scales).norm();
        let variance = (moves * &self.covariance * moves.transpose())[(0, 0)];
        if follows < FOLLOWS * self.expected[usize::from(length)] || variance <= 1e-24 {
            return 0.0;
        }
        variance.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::{AnyEffect, ErrorModel};
    use truepose_kinematics::samples;

    #[test]
    fn what_follows_by_second_order_is_not_estimated() {
        let effects: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
        let model = ErrorModel::new(samples::ur10(), effects).unwrap();
        let n = model.columns().len();
        let turn = model.columns().iter().position(|column| column.name == "rx@j2").unwrap();
        // One error was estimated, to 10 µrad.
        let mut covariance = DMatrix::zeros(n, n);
        covariance[(turn, turn)] = 1e-10;
        let known = Knowledge::new(&FittedModel::new(model, vec![0.0; n], covariance).unwrap());
        let mut moves = RowDVector::zeros(n);
        moves[turn] = 1.0;
        assert!((known.uncertainty(&moves, false) - 1e-5).abs() < 1e-12);
        // Another number moves with it by a thousandth: ± 1e-8 rad is no knowledge of that number.
        moves[turn] = 1e-3;
        assert!(known.uncertainty(&moves, false) <= 0.0);
        // So does one whose own error was not estimated.
        moves[turn] = 0.0;
        moves[(turn + 1) % n] = 1.0;
        assert!(known.uncertainty(&moves, false) <= 0.0);
    }
}
