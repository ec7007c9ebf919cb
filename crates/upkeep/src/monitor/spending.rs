//! The level of each look, so that all looks together keep one error rate.
//!
//! ```text
//! α_k = α / (k (k + 1)),    Σ_k α_k = α
//! ```
//!
//! However often one looks, an unchanged robot ever raises an alarm with probability α at most (Bonferroni; an alpha-spending function in the
//! sense of Lan and DeMets 1983 without a last look). The error of the fit, which all looks share, does no harm to that.

/// Level of look number `look`, from one.
pub fn level(alpha: f64, look: usize) -> f64 {
    let k = look.max(1) as f64;
    alpha / (k * (k + 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_looks_together_spend_alpha() {
        let spent: f64 = (1..=100_000).map(|look| level(0.01, look)).sum();
        assert!(spent < 0.01 && spent > 0.00999, "{spent}");
        assert!((level(0.01, 1) - 0.005).abs() < 1e-15);
    }
}
