//! Where a function of one variable is least.

/// Minimum in [lower, upper] of a function with few wiggles: a coarse scan of 61 points, then golden sections around the best of
/// them (Kiefer 1953). The place, to 1e-10 of the scan's step; in the variable's unit.
pub fn minimum(lower: f64, upper: f64, f: impl Fn(f64) -> f64) -> f64 {
    const SCAN: usize = 60;
    const STEPS: usize = 50;
    let at = |k: usize| lower + (upper - lower) * k as f64 / SCAN as f64;
    let best = (0..=SCAN).fold(0, |best, k| if f(at(k)) < f(at(best)) { k } else { best });
    golden_section(at(best.saturating_sub(1)), at((best + 1).min(SCAN)), STEPS, f)
}

/// Minimum in [lower, upper] of a function with one valley there: each step leaves 0.618 of the interval (Kiefer 1953). In the variable's
/// unit.
pub fn golden_section(lower: f64, upper: f64, steps: usize, f: impl Fn(f64) -> f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut lower, mut upper) = (lower, upper);
    for _ in 0..steps {
        let (left, right) = (upper - RATIO * (upper - lower), lower + RATIO * (upper - lower));
        if f(left) < f(right) { upper = right } else { lower = left }
    }
    0.5 * (lower + upper)
}

#[cfg(test)]
mod tests {
    use super::{golden_section, minimum};

    #[test]
    fn the_deeper_of_two_valleys_is_found() {
        let wave = |x: f64| (3.0 * x).cos() + 0.1 * x;
        // cos 3x = −1 at π/3 and π; the slope makes the first the deeper one and moves it left by 0.1/9.
        let found = minimum(0.0, 4.0, wave);
        assert!(
            (found - (std::f64::consts::FRAC_PI_3 - (0.1f64 / 3.0).asin() / 3.0)).abs() < 1e-6,
            "{found}"
        );
        // At an end.
        assert!((minimum(-1.0, 2.0, |x| x) + 1.0).abs() < 1e-6);
    }

    #[test]
    fn golden_section_finds_the_minimum() {
        assert!((golden_section(-2.0, 5.0, 60, |x| (x - 0.3).powi(2)) - 0.3).abs() < 1e-7);
    }
}
