//! Rows that no pass over all rows uses.

use truepose_errormodel::Dataset;
use truepose_identify::Residuals;

/// Standard deviations, from the median, from which a row is gross: no row in 10⁸ of normal errors. The search, which sees fewer rows, judges
/// them more closely ([`crate::problem::outliers`]).
const FAR: f64 = 7.69;
/// Medians of χ with one, two and three degrees of freedom: of a distance over as many components, in standard deviations of one.
const MEDIAN: [f64; 3] = [0.674_490, 1.177_410, 1.538_172];

/// Rows whose position is farther from the model than many times the median of rows in which as many components were measured.
pub(crate) fn gross(residuals: &Residuals, data: &Dataset) -> Vec<usize> {
    let size = |row: usize| {
        let components = data.seen(row).components().checked_sub(1)?;
        Some(residuals.distance(row)? / MEDIAN[components])
    };
    let mut distances: Vec<f64> = (0..residuals.position.len()).filter_map(size).collect();
    if distances.is_empty() {
        return Vec::new();
    }
    let middle = distances.len() / 2;
    let deviation = *distances.select_nth_unstable_by(middle, f64::total_cmp).1;
    let far = |&row: &usize| residuals.distance(row).is_some_and(|distance| distance > FAR * deviation);
    (0..residuals.position.len()).filter(far).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_row_far_out_is_gross_and_one_without_a_position_is_not() {
        let position = [1.0, -1.2, f64::NAN, 0.9, 5.9, 1.1].map(|v| Vector3::x() * v).to_vec();
        let data = seen(position.iter().map(|v| v.map(|_| v.x).into()).collect());
        let residuals = Residuals { orientation: vec![None; position.len()], position };
        assert_eq!(gross(&residuals, &data), [4]);
    }

    /// A single component is often far from zero in units of its median: 5 medians are 3.4 standard deviations.
    #[test]
    fn a_single_component_is_not_judged_like_three() {
        let x = [0.1, -0.7, 0.6, 0.8, -0.5, 3.6, 8.2].map(|v| Vector3::new(v, f64::NAN, f64::NAN)).to_vec();
        let data = seen(x.iter().map(|&v| v.into()).collect());
        let residuals = Residuals { orientation: vec![None; x.len()], position: x };
        assert_eq!(gross(&residuals, &data), [6]);
    }

    fn seen(position: Vec<[f64; 3]>) -> Dataset {
        let n = position.len();
        Dataset { visit: (0..n).collect(), orientation: vec![None; n], position, ..Dataset::default() }
    }
}
