//! ‖v‖₂ without overflow or underflow.

/// Euclidean norm, scaled by the largest entry where squares would leave the range.
pub(crate) fn norm(v: &[f64]) -> f64 {
    // Eight sums side by side, so that none waits for the one before.
    let mut sums = [0.0; 8];
    let eights = v.chunks_exact(8);
    let rest: f64 = eights.remainder().iter().map(|x| x * x).sum();
    for eight in eights {
        sums.iter_mut().zip(eight).for_each(|(sum, x)| *sum += x * x);
    }
    let plain = sums.iter().sum::<f64>() + rest;
    if plain > 1e-280 && plain < 1e280 {
        return plain.sqrt();
    }
    let top = v.iter().fold(0.0_f64, |t, x| t.max(x.abs()));
    if top == 0.0 || !top.is_finite() {
        return if v.iter().any(|x| x.is_nan()) { f64::NAN } else { top };
    }
    top * v.iter().map(|x| (x / top) * (x / top)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::norm;

    #[test]
    fn stays_in_range() {
        assert!((norm(&[3.0, 4.0]) - 5.0).abs() < 1e-15);
        assert!((norm(&[3e-300, 4e-300]) / 5e-300 - 1.0).abs() < 1e-15);
        assert!((norm(&[3e300, 4e300]) / 5e300 - 1.0).abs() < 1e-15);
        assert!(norm(&[]).abs() < f64::MIN_POSITIVE && norm(&[0.0, f64::NAN]).is_nan());
    }
}
