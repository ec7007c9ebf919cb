//! Paired differences over folds of a cross-validation.
//!
//! ```text
//! t = d̄ / √(s² (1/K + n_test/n_train)),   n_test/n_train = 1/(K − 1)
//! ```
//!
//! Folds share their training parts, so that K differences are not independent (Nadeau and Bengio 2003).

/// Student's t of the mean of K differences; zero where they do not scatter.
pub(crate) fn students_t(differences: &[f64]) -> f64 {
    let k = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / k.max(1.0);
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (k - 1.0).max(1.0);
    let spread = (variance * (1.0 / k.max(1.0) + 1.0 / (k - 1.0).max(1.0))).sqrt();
    if spread > 0.0 { mean / spread } else { 0.0 }
}

/// The median; zero of no values.
pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => 0.0,
        n => 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_training_parts_count() {
        // Mean 2, variance 1, five folds: 2 / √(1/5 + 1/4).
        let t = students_t(&[1.0, 3.0, 2.0 - 1.0, 3.0, 2.0]);
        assert!((t - 2.0 / 0.45f64.sqrt()).abs() < 1e-12, "{t}");
        assert!(students_t(&[1.0, 1.0]).abs() < 1e-15 && students_t(&[]).abs() < 1e-15);
    }

    #[test]
    fn a_median_halves_the_values() {
        assert!((median(&[3.0, 1.0, 2.0]) - 2.0).abs() < 1e-15);
        assert!((median(&[4.0, 1.0, 2.0, 3.0]) - 2.5).abs() < 1e-15);
        assert!(median(&[]).abs() < 1e-15);
    }
}
