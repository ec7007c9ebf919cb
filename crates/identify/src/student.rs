//! Quantiles of Student's t.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Quantile of Student's t. Of many degrees of freedom from the normal distribution's z, as Fisher and Cornish (1960) expand it: right to
/// 1e-11, where an inverse of the incomplete beta function may look for ever.
///
/// ```text
/// t ≈ z + (z³ + z)/4ν + (5z⁵ + 16z³ + 3z)/96ν²
/// ```
pub fn student_quantile(probability: f64, freedom: usize) -> f64 {
    const MANY: usize = 10_000;
    let nu = freedom as f64;
    if freedom < MANY {
        return StudentsT::new(0.0, 1.0, nu).map_or(1.96, |t| t.inverse_cdf(probability));
    }
    let z = Normal::standard().inverse_cdf(probability);
    let square = z * z;
    z + z * (square + 1.0) / (4.0 * nu) + z * (5.0 * square * square + 16.0 * square + 3.0) / (96.0 * nu * nu)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_many_degrees_of_freedom_go_on_where_those_of_few_end() {
        for probability in [0.6, 0.975, 0.9995] {
            let exact = StudentsT::new(0.0, 1.0, 10_000.0).unwrap().inverse_cdf(probability);
            assert!((student_quantile(probability, 10_000) - exact).abs() < 1e-9, "{probability}");
        }
        // It comes to an end, and near the normal distribution's 1.959 963 985.
        assert!((student_quantile(0.975, 30_000_000) - 1.959_963_985).abs() < 1e-6);
    }
}
