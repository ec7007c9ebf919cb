//! Scores of every period of a joint, from sums over narrow intervals of its value.
//!
//! ```text
//! S(f) = Σ_v w_v e^{2πi f q_v}  ≈  Σ_b W_b e^{2πi f x_b}
//! ```
//!
//! w_v is the score of the joint's own motion at a visit. Shared linearly between the two nearest of the x_b, of which the shortest period has
//! [`PER_PERIOD`], a wave of that period is weakened by less than (2π/32)²/3 = 1.3 %.

use std::f64::consts::TAU;

/// Intervals of the shortest period.
const PER_PERIOD: f64 = 16.0;
/// Most intervals.
const MOST: usize = 1 << 17;

/// Sums of scores over intervals of a joint's value.
#[derive(Debug, Clone)]
pub(crate) struct MotionBins {
    from: f64,
    width: f64,
    sums: Vec<f64>,
}

impl MotionBins {
    /// Between two values of a joint, for periods down to `shortest`; rad or m.
    pub fn new([from, to]: [f64; 2], shortest: f64) -> Self {
        let count = ((to - from) / shortest * PER_PERIOD).ceil().clamp(1.0, MOST as f64) as usize;
        MotionBins {
            from,
            width: ((to - from) / count as f64).max(f64::MIN_POSITIVE),
            sums: vec![0.0; count + 1],
        }
    }

    /// Adds the score of a visit.
    pub fn add(&mut self, value: f64, score: f64) {
        let at = ((value - self.from) / self.width).clamp(0.0, (self.sums.len() - 1) as f64);
        let first = (at as usize).min(self.sums.len() - 2);
        let share = at - first as f64;
        self.sums[first] += (1.0 - share) * score;
        self.sums[first + 1] += share * score;
    }

    /// Adds those of others of the same intervals.
    pub fn merge(&mut self, other: &MotionBins) {
        self.sums.iter_mut().zip(&other.sums).for_each(|(sum, more)| *sum += more);
    }

    /// (Σ w sin, Σ w cos) at these periods, which are equally far apart in frequency.
    pub fn waves(&self, periods: &[f64]) -> Vec<[f64; 2]> {
        /// Steps of the recurrence before it begins anew: rounding grows with them.
        const ANEW: usize = 128;
        let mut out = vec![[0.0; 2]; periods.len()];
        for (from, part) in out.chunks_mut(ANEW).enumerate() {
            let first = 1.0 / periods[from * ANEW];
            let step = match periods.get(from * ANEW + 1) {
                Some(next) => 1.0 / next - first,
                None => 0.0,
            };
            for (k, &sum) in self.sums.iter().enumerate().filter(|(_, sum)| **sum != 0.0) {
                let x = self.from + k as f64 * self.width;
                let (mut sine, mut cosine) = (TAU * first * x).sin_cos();
                let (turn_sine, turn_cosine) = (TAU * step * x).sin_cos();
                for value in part.iter_mut() {
                    value[0] += sum * sine;
                    value[1] += sum * cosine;
                    (sine, cosine) =
                        (sine * turn_cosine + cosine * turn_sine, cosine * turn_cosine - sine * turn_sine);
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_over_intervals_are_those_over_the_visits() {
        let periods: Vec<f64> = (0..300).map(|k| 1.0 / (0.5 + 0.1 * f64::from(k))).collect();
        let mut bins = MotionBins::new([-2.0, 3.0], periods[299]);
        let visits: Vec<(f64, f64)> = (0..2000)
            .map(|k| (-2.0 + 5.0 * (f64::from(k) * 0.618).fract(), (f64::from(k) * 1.7).sin()))
            .collect();
        visits.iter().for_each(|&(q, w)| bins.add(q, w));
        let size = visits.iter().map(|v| v.1 * v.1).sum::<f64>().sqrt();
        for (period, [sine, cosine]) in periods.iter().zip(bins.waves(&periods)) {
            let exact =
                |of: fn(f64) -> f64| visits.iter().map(|(q, w)| w * of(TAU * q / period)).sum::<f64>();
            assert!((exact(f64::sin) - sine).abs() < 0.05 * size, "{period}");
            assert!((exact(f64::cos) - cosine).abs() < 0.05 * size, "{period}");
        }
    }
}
