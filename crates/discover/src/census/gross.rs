//! Rows that no pass over all rows uses.

use truepose_identify::Residuals;

/// Times the median distance from which a row is gross: no row in 10⁸ of normal errors. The search, which sees fewer rows, judges them more
/// closely ([`crate::problem::outliers`]).
const FAR: f64 = 5.0;

/// Rows whose position is farther from the model than many times the median.
pub(crate) fn gross(residuals: &Residuals) -> Vec<usize> {
    let mut distances: Vec<f64> =
        (0..residuals.position.len()).filter_map(|row| residuals.distance(row)).collect();
    if distances.is_empty() {
        return Vec::new();
    }
    let middle = distances.len() / 2;
    let median = *distances.select_nth_unstable_by(middle, f64::total_cmp).1;
    let far = |&row: &usize| residuals.distance(row).is_some_and(|distance| distance > FAR * median);
    (0..residuals.position.len()).filter(far).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_row_far_out_is_gross_and_one_without_a_position_is_not() {
        let position = [1.0, -1.2, f64::NAN, 0.9, 5.9, 1.1].map(|v| Vector3::x() * v).to_vec();
        let residuals = Residuals { orientation: vec![None; position.len()], position };
        assert_eq!(gross(&residuals), [4]);
    }
}
