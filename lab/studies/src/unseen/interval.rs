//! Fractions with their intervals, and how well probabilities are calibrated.

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
        let percent = 100.0 * self.hits as f64 / self.of as f64;
        write!(f, "{}/{}, {percent:.0} % ({low:.0}–{high:.0})", self.hits, self.of)
    }
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
}
