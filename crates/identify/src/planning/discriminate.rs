//! Visits that tell two explanations apart.

use super::accuracy::{root, schema, shown, targets};
use crate::IdentifyError;
use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use truepose_errormodel::FittedModel;
use truepose_kinematics::Conditions;

/// What one visit shows of two fits.
struct Contrast {
    /// Difference of the predicted positions of all targets, m.
    difference: DVector<f64>,
    /// Sensitivities times L of each fit, m.
    a: DMatrix<f64>,
    b: DMatrix<f64>,
}

/// Positions in the pool with the T of each, best first; Σ T and the value that settles it.
#[allow(clippy::type_complexity)]
pub(super) fn choose(
    fitted: &FittedModel,
    rival: &FittedModel,
    pool: &[Conditions],
    count: usize,
) -> Result<(Vec<(usize, f64)>, (f64, f64)), IdentifyError> {
    if fitted.chain().movable().len() != rival.chain().movable().len()
        || fitted.chain().targets().len() != rival.chain().targets().len()
    {
        return Err(IdentifyError::Option {
            option: "rival",
            value: rival.chain().movable().len() as f64,
            expected: "a fit of the same robot, with as many joints and targets",
        });
    }
    let (root_a, root_b) = (root(fitted)?, root(rival)?);
    let (schema_a, schema_b, targets) = (schema(fitted), schema(rival), targets(fitted));
    fitted.bind(&schema_a)?;
    rival.bind(&schema_b)?;
    let contrasts: Vec<Contrast> = pool
        .par_iter()
        .map_init(
            || (fitted.bind(&schema_a), rival.bind(&schema_b)),
            |(a, b), conditions| match (a, b) {
                (Ok(a), Ok(b)) => {
                    let mut difference = DVector::zeros(3 * targets.len());
                    for (k, &target) in targets.iter().enumerate() {
                        let moved = a.predict(conditions, target).translation
                            - b.predict(conditions, target).translation;
                        difference.rows_mut(3 * k, 3).copy_from(&moved);
                    }
                    Ok(Contrast {
                        difference,
                        a: shown(a, conditions, &targets, &root_a),
                        b: shown(b, conditions, &targets, &root_b),
                    })
                }
                (Err(error), _) | (_, Err(error)) => Err(IdentifyError::from(error.clone())),
            },
        )
        .collect::<Result<_, _>>()?;
    let variance = fitted.noise.position_sd.max(1e-9).powi(2);
    let (mut p_a, mut p_b) = (
        DMatrix::identity(root_a.ncols(), root_a.ncols()),
        DMatrix::identity(root_b.ncols(), root_b.ncols()),
    );
    let mut chosen: Vec<(usize, f64)> = Vec::new();
    for _ in 0..count {
        let worth: Vec<f64> = contrasts
            .par_iter()
            .enumerate()
            .map(|(k, c)| {
                if chosen.iter().any(|taken| taken.0 == k) {
                    return f64::NEG_INFINITY;
                }
                let mut spread = &c.a * &p_a * c.a.transpose() + &c.b * &p_b * c.b.transpose();
                for k in 0..spread.nrows() {
                    spread[(k, k)] += variance;
                }
                Cholesky::new(spread).map_or(0.0, |s| s.solve(&c.difference).dot(&c.difference))
            })
            .collect();
        let Some(k) = (0..worth.len()).max_by(|&i, &j| worth[i].total_cmp(&worth[j]).then(j.cmp(&i))) else {
            break;
        };
        chosen.push((k, worth[k]));
        // Both will be fitted to what this visit shows.
        p_a = after(&p_a, &contrasts[k].a, variance);
        p_b = after(&p_b, &contrasts[k].b, variance);
    }
    let total = chosen.iter().map(|c| c.1).sum();
    let freedom = (3 * targets.len() * chosen.len()).max(1) as f64;
    let settled = ChiSquared::new(freedom).map_or(f64::INFINITY, |law| law.inverse_cdf(0.99));
    Ok((chosen, (total, settled)))
}

/// P after a visit.
fn after(p: &DMatrix<f64>, rows: &DMatrix<f64>, variance: f64) -> DMatrix<f64> {
    let bp = rows * p;
    let mut inner = &bp * rows.transpose();
    for k in 0..inner.nrows() {
        inner[(k, k)] += variance;
    }
    match Cholesky::new(inner) {
        Some(factor) => p - bp.transpose() * factor.solve(&bp),
        None => p.clone(),
    }
}
