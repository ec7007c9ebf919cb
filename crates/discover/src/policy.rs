//! What the search believes before it has seen the data.

/// Scores that differ by less cannot be told apart.
pub(crate) const TIE: f64 = 6.0;

/// κ: expected sizes within which coefficients of a candidate lie.
pub(crate) const WIDE: f64 = 100.0;

/// What an unknown costs: BIC's logarithm of the number of rows.
pub(crate) fn price(numbers: usize) -> f64 {
    (numbers.max(2) as f64).ln()
}
