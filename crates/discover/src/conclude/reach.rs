//! How far the findings reach: with which share they count where the fit has not been ([`Fallback`]).
//!
//! ```text
//! min_s Σ_parts mean_i |e_0i + w_i (e_1i − e_0i)|²,    w_i = 1/(1 + max(0, V_i − V_95)/s²),    s² = b²/f,  f = 1, 2, 4 … 1024
//! ```
//!
//! | symbol | here | unit | |
//! | --- | --- | --- | --- |
//! | e_0, e_1 | [`UnseenRow::declared`], [`UnseenRow::found`] | m | errors of declared and final model without that part of the data |
//! | V, V_95 | [`UnseenRow::variance`], [`UnseenPart::usual`] | m² | as in [`Fallback`], of the fit without the part |
//! | b² | mean of \|p_1 − p_0\|² over the fit | m² | |
//!
//! The parts are those of [`crate::conclude::extrapolation`]: the last in time, and the ends of a joint's range. With f = 1 the two
//! predictions are combined as their variances say; the parts say by how much more the findings miss beyond their data than their own variance
//! knows. Without a part f = 1 stands.

use crate::error::DiscoverError;
use nalgebra::Vector3;
use std::sync::Arc;
use truepose_errormodel::{Dataset, Fallback, FittedModel};
use truepose_identify::{Residuals, distance};
use truepose_kinematics::Conditions;

/// Rows of the fit whose variances are looked at, evenly taken.
const ROWS: usize = 500;
/// Share of them that counts as usual. Convention.
const USUAL: f64 = 0.95;
/// Factors f: powers of two up to this one.
const MOST: u32 = 10;
/// A larger f has to be better by this share.
const BETTER: f64 = 0.01;

/// A row that neither fit has seen.
pub(crate) struct UnseenRow {
    /// e_0.
    pub declared: Vector3<f64>,
    /// e_1.
    pub found: Vector3<f64>,
    /// V.
    pub variance: f64,
}

/// A part of the data that neither fit has seen.
pub(crate) struct UnseenPart {
    pub rows: Vec<UnseenRow>,
    /// V_95 of the rest.
    pub usual: f64,
}

impl UnseenPart {
    /// Mean square of the combined errors, m².
    pub fn mean_square(&self, scale: f64) -> f64 {
        let one = |row: &UnseenRow| {
            let share = 1.0 / (1.0 + (row.variance - self.usual).max(0.0) / scale);
            (row.declared + (row.found - row.declared) * share).norm_squared()
        };
        self.rows.iter().map(one).sum::<f64>() / self.rows.len().max(1) as f64
    }
}

/// V of each row, m².
pub(crate) fn variances(
    fitted: &FittedModel,
    data: &Dataset,
    rows: &[usize],
) -> Result<Vec<f64>, DiscoverError> {
    let data = &*data.derived_for(fitted.model())?;
    let mut predictor = fitted.bind(&data.schema)?;
    let mut conditions = Conditions::default();
    let of = |&row: &usize| {
        data.conditions_into(row, &mut conditions);
        predictor.with_covariance(&conditions, data.target[row]).1.trace()
    };
    Ok(rows.iter().map(of).collect())
}

/// V_95 of the rows of a fit.
pub(crate) fn usual(fitted: &FittedModel, data: &Dataset) -> Result<f64, DiscoverError> {
    let rows: Vec<usize> = (0..data.len()).step_by(data.len().div_ceil(ROWS).max(1)).collect();
    let mut all = variances(fitted, data, &rows)?;
    all.sort_by(f64::total_cmp);
    Ok(all.get((USUAL * all.len() as f64) as usize).or(all.last()).copied().unwrap_or(0.0))
}

/// The declared model as the fallback of `found`; both were fitted to these rows, with loads as declared and as corrected.
pub(crate) fn fallback(
    (declared, as_declared): (&FittedModel, &Dataset),
    (found, corrected): (&FittedModel, &Dataset),
    parts: &[UnseenPart],
) -> Result<Fallback, DiscoverError> {
    let (before, after) = (Residuals::of(declared, as_declared)?, Residuals::of(found, corrected)?);
    let moves = before.position.iter().zip(&after.position).filter_map(|(a, b)| distance(&(a - b)));
    let moves: Vec<f64> = moves.map(|moved| moved * moved).collect();
    let size = moves.iter().sum::<f64>() / moves.len().max(1) as f64;
    let scale = scale(size, parts);
    Ok(Fallback { declared: Arc::new(declared.clone()), usual: usual(found, corrected)?, scale, size })
}

/// s², m².
fn scale(size: f64, parts: &[UnseenPart]) -> f64 {
    let missed = |scale: f64| parts.iter().map(|part| part.mean_square(scale)).sum::<f64>();
    let mut best = (size, missed(size));
    for power in 1..=MOST {
        let scale = size / f64::from(1u32 << power);
        let there = missed(scale);
        if there < (1.0 - BETTER) * best.1 {
            best = (scale, there);
        }
    }
    best.0.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(wrong: f64) -> UnseenPart {
        // A declared model that is wrong by one everywhere; findings that are right where they are known, and by `wrong` times their
        // own deviation where they are not.
        let row = |deviation: f64| UnseenRow {
            declared: Vector3::x(),
            found: Vector3::y() * (wrong * deviation),
            variance: deviation * deviation,
        };
        UnseenPart { rows: [0.0, 0.01, 0.02, 0.5, 1.0, 2.0].map(row).into(), usual: 1e-4 }
    }

    #[test]
    fn findings_that_miss_by_more_than_they_say_count_for_less() {
        let honest = scale(1.0, &[part(1.0)]);
        let too_sure = scale(1.0, &[part(20.0)]);
        assert!(honest >= 0.25, "{honest}");
        assert!(too_sure <= 1.0 / 64.0, "{too_sure}");
        for (wrong, scale) in [(1.0, honest), (20.0, too_sure)] {
            let part = part(wrong);
            let alone = part.mean_square(f64::INFINITY);
            assert!(part.mean_square(scale) < alone.min(1.0), "{wrong}: {} {alone}", part.mean_square(scale));
        }
        // Nothing to learn from: as the variances say.
        assert!((scale_of_nothing() - 0.3).abs() < 1e-15);
    }

    fn scale_of_nothing() -> f64 {
        scale(0.3, &[])
    }
}
