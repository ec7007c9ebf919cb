//! Statistics of trials: proportions with their intervals, quantiles, calibration of probabilities, uniformity of p-values.

use truepose_solvers::order;

/// A fraction of trials.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fraction {
    pub hits: usize,
    pub of: usize,
}

/// 97.5 % point of the normal distribution.
const Z: f64 = 1.959_963_984_540_054;

impl Fraction {
    pub fn of(outcomes: impl IntoIterator<Item = bool>) -> Self {
        outcomes.into_iter().fold(Fraction { hits: 0, of: 0 }, |sum, hit| Fraction {
            hits: sum.hits + usize::from(hit),
            of: sum.of + 1,
        })
    }

    /// The hits in per cent; zero without trials.
    pub fn percent(self) -> f64 {
        100.0 * self.hits as f64 / self.of.max(1) as f64
    }

    /// Wilson's 95 % interval (Brown, Cai and DasGupta, *Interval estimation for a binomial proportion*, 2001).
    pub fn wilson(self) -> [f64; 2] {
        if self.of == 0 {
            return [0.0, 1.0];
        }
        let (n, p) = (self.of as f64, self.hits as f64 / self.of as f64);
        let middle = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
        let half = Z / (1.0 + Z * Z / n) * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        let low = if self.hits == 0 { 0.0 } else { middle - half };
        let high = if self.hits == self.of { 1.0 } else { middle + half };
        [low, high]
    }
}

impl std::fmt::Display for Fraction {
    /// `12/40, 30 % (18–45)`; a dash without trials.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.of == 0 {
            return f.write_str("–");
        }
        let [low, high] = self.wilson().map(|v| 100.0 * v);
        write!(f, "{}/{}, {:.0} % ({low:.0}–{high:.0})", self.hits, self.of, self.percent())
    }
}

/// Root mean square; zero of nothing.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0), |(sum, count), v| (sum + v * v, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}

/// Sum of squares and number of rows, fold by fold.
pub type Squares = Vec<(f64, usize)>;

/// Root mean square over all folds.
pub fn rms_of_folds(squares: &Squares) -> f64 {
    let (sum, rows) = squares.iter().fold((0.0, 0), |(s, n), (square, rows)| (s + square, n + rows));
    (sum / rows as f64).sqrt()
}

/// The finite values, ascending.
pub fn sorted(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    order::sorted(values.into_iter().filter(|value| value.is_finite()))
}

/// The upper of the two in the middle of the finite values; NaN of nothing.
pub fn upper_median(values: impl IntoIterator<Item = f64>) -> f64 {
    order::high_median(sorted(values)).unwrap_or(f64::NAN)
}

/// Quantile by linear interpolation between order statistics; NaN of nothing.
pub fn quantile(values: impl IntoIterator<Item = f64>, part: f64) -> f64 {
    order::quantile(&sorted(values), part).unwrap_or(f64::NAN)
}

/// The order statistic that is nearest to a quantile; NaN of nothing.
pub fn nearest_quantile(values: impl IntoIterator<Item = f64>, part: f64) -> f64 {
    let values = sorted(values);
    let at = (part * (values.len().max(1) - 1) as f64).round() as usize;
    values.get(at).copied().unwrap_or(f64::NAN)
}

/// `median (10 %–90 %)`; a dash of nothing.
pub fn quantiles(values: impl IntoIterator<Item = f64>) -> String {
    let values = sorted(values);
    let [low, middle, high] = [0.1, 0.5, 0.9].map(|part| nearest_quantile(values.iter().copied(), part));
    if values.is_empty() { "–".into() } else { format!("{middle:.2} ({low:.2}–{high:.2})") }
}

/// Largest finite value; NaN of nothing.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().filter(|value| value.is_finite()).fold(f64::NAN, f64::max)
}

/// Distance of Kolmogorov and Smirnov from the uniform distribution, and its probability (Stephens' form of the limit).
pub fn uniformity(values: &[f64]) -> (f64, f64) {
    let sorted = order::sorted(values.iter().copied());
    let n = sorted.len() as f64;
    let off = |(k, &p): (usize, &f64)| (p - k as f64 / n).abs().max(((k + 1) as f64 / n - p).abs());
    let distance = sorted.iter().enumerate().map(off).fold(0.0f64, f64::max);
    let x = distance * (n.sqrt() + 0.12 + 0.11 / n.sqrt());
    let terms = (1..=100).map(|k| {
        let sign = if k % 2 == 1 { 2.0 } else { -2.0 };
        sign * (-2.0 * f64::from(k) * f64::from(k) * x * x).exp()
    });
    let probability = if x < 0.2 { 1.0 } else { terms.sum::<f64>().clamp(0.0, 1.0) };
    (distance, probability)
}

/// Mean squared distance of probabilities from what happened; none without events.
pub fn brier(events: &[(f64, bool)]) -> Option<f64> {
    let square = |(p, hit): &(f64, bool)| (p - f64::from(u8::from(*hit))).powi(2);
    (!events.is_empty()).then(|| events.iter().map(square).sum::<f64>() / events.len() as f64)
}

/// Mean probability and fraction that happened, in these bins of the probability.
pub fn calibration(events: &[(f64, bool)], edges: &[f64]) -> Vec<(f64, Fraction)> {
    let bin = |pair: &[f64]| {
        let inside = |p: f64| p >= pair[0] && (p < pair[1] || pair[1] >= 1.0 && p <= pair[1]);
        let here: Vec<&(f64, bool)> = events.iter().filter(|(p, _)| inside(*p)).collect();
        let mean = here.iter().map(|(p, _)| p).sum::<f64>() / here.len().max(1) as f64;
        (mean, Fraction::of(here.iter().map(|(_, hit)| *hit)))
    };
    edges.windows(2).map(bin).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilsons_interval_is_that_of_the_books() {
        // Of 10 in 20: 0.2993 to 0.7007; of 0 in 10: 0 to 0.2775.
        let [low, high] = Fraction { hits: 10, of: 20 }.wilson();
        assert!((low - 0.299_298).abs() < 1e-5 && (high - 0.700_702).abs() < 1e-5, "{low} {high}");
        let [low, high] = Fraction { hits: 0, of: 10 }.wilson();
        assert!(low == 0.0 && (high - 0.277_533).abs() < 1e-5, "{high}");
        assert_eq!(Fraction { hits: 0, of: 0 }.to_string(), "–");
        assert_eq!(Fraction { hits: 12, of: 40 }.to_string(), "12/40, 30 % (18–45)");
    }

    #[test]
    fn a_sure_and_right_name_has_no_brier_score() {
        assert_eq!(brier(&[(1.0, true), (0.0, false)]), Some(0.0));
        assert_eq!(brier(&[(0.5, true), (0.5, false)]), Some(0.25));
        assert_eq!(brier(&[]), None);
    }

    #[test]
    fn calibration_counts_each_event_once() {
        let events = [(0.05, false), (0.5, true), (0.5, false), (0.95, true), (1.0, true)];
        let bins = calibration(&events, &[0.0, 0.1, 0.9, 1.0]);
        let counts: Vec<(usize, usize)> = bins.iter().map(|(_, f)| (f.hits, f.of)).collect();
        assert_eq!(counts, [(0, 1), (1, 2), (2, 2)]);
        assert!((bins[2].0 - 0.975).abs() < 1e-12);
    }

    #[test]
    fn even_values_are_uniform_and_small_ones_are_not() {
        let even: Vec<f64> = (0..200).map(|k| (f64::from(k) + 0.5) / 200.0).collect();
        assert!(uniformity(&even).1 > 0.99);
        let small: Vec<f64> = even.iter().map(|p| p * p).collect();
        assert!(uniformity(&small).1 < 1e-6);
    }
}
