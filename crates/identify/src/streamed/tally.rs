//! Statistics of any number of magnitudes, in memory that does not grow with them.

use crate::Spread;

/// Up to so many are kept, unless more are asked for, and their statistics are those of [`Spread::of`].
const KEPT: usize = 1 << 16;
/// Beyond that a quantile comes from a histogram of this many bins an octave: right to a four-hundredth part.
const BINS: usize = 256;
/// Octaves of the histogram, downwards from 2^32.
const OCTAVES: usize = 96;

/// Sums are kept in units of 2⁻⁹⁶ as whole numbers: so they are exact, and whoever adds up the parts in whatever order has the same sum.
const UNIT: f64 = (1u128 << 96) as f64;

/// A number above zero in those units; what is beyond 4e9 is that.
fn units(value: f64) -> u128 {
    (value * UNIT) as u128
}

/// Count, mean, root mean square, maximum, and the 95 % quantile: exact up to 65 536 values or as many as are to be kept,
/// right to 0.4 % beyond.
#[derive(Debug, Clone)]
pub struct Tally {
    most: usize,
    kept: Vec<f64>,
    bins: Vec<u64>,
    count: usize,
    sum: u128,
    squares: u128,
    max: f64,
}

impl Default for Tally {
    fn default() -> Self {
        Tally::keeping(KEPT)
    }
}

impl Tally {
    /// One that is exact up to so many values.
    pub fn keeping(most: usize) -> Self {
        Tally { most, kept: Vec::new(), bins: Vec::new(), count: 0, sum: 0, squares: 0, max: 0.0 }
    }

    /// Takes in some more; what is no number is left out.
    pub fn add(&mut self, values: impl Iterator<Item = f64>) {
        for value in values.filter(|value| value.is_finite()) {
            self.count += 1;
            self.sum = self.sum.saturating_add(units(value));
            self.squares = self.squares.saturating_add(units(value * value));
            self.max = self.max.max(value);
            self.keep(value);
        }
    }

    fn keep(&mut self, value: f64) {
        if self.bins.is_empty() {
            self.kept.push(value);
            if self.kept.len() > self.most {
                self.bins = vec![0; BINS * OCTAVES];
                std::mem::take(&mut self.kept).into_iter().for_each(|value| self.bins[bin(value)] += 1);
            }
        } else {
            self.bins[bin(value)] += 1;
        }
    }

    /// Takes in what another one has seen. The result does not depend on who has seen what, nor on the order, to the last bit.
    pub fn merge(&mut self, other: &Tally) {
        self.count += other.count;
        self.sum = self.sum.saturating_add(other.sum);
        self.squares = self.squares.saturating_add(other.squares);
        self.max = self.max.max(other.max);
        if !other.bins.is_empty() && self.bins.is_empty() {
            self.bins = vec![0; BINS * OCTAVES];
            std::mem::take(&mut self.kept).into_iter().for_each(|value| self.bins[bin(value)] += 1);
        }
        self.bins.iter_mut().zip(&other.bins).for_each(|(into, more)| *into += more);
        other.kept.iter().for_each(|&value| self.keep(value));
    }

    /// Everything in it as numbers, for [`Tally::restored`].
    pub fn stored(&self) -> (u128, u128, f64, Vec<f64>, Vec<(u32, u64)>) {
        let filled = self.bins.iter().enumerate().filter(|(_, count)| **count > 0);
        let bins = filled.map(|(bin, &count)| (bin as u32, count)).collect();
        (self.sum, self.squares, self.max, self.kept.clone(), bins)
    }

    /// What [`Tally::stored`] gave; bins that do not exist are left out.
    pub fn restored((sum, squares, max, kept, filled): (u128, u128, f64, Vec<f64>, Vec<(u32, u64)>)) -> Self {
        let mut made = Tally { sum, squares, max, count: kept.len(), kept, ..Tally::default() };
        if !filled.is_empty() {
            made.bins = vec![0; BINS * OCTAVES];
            for (bin, count) in filled {
                if let Some(into) = made.bins.get_mut(bin as usize) {
                    *into += count;
                    made.count += count as usize;
                }
            }
        }
        made
    }

    /// The statistics.
    pub fn spread(&self) -> Spread {
        if self.bins.is_empty() {
            return Spread::of(self.kept.iter().copied());
        }
        let n = self.count as f64;
        Spread {
            count: self.count,
            mean: self.sum as f64 / UNIT / n,
            rms: (self.squares as f64 / UNIT / n).sqrt(),
            p95: self.quantile(0.95).min(self.max),
            max: self.max,
        }
    }

    fn quantile(&self, share: f64) -> f64 {
        let wanted = share * (self.count - 1) as f64;
        let mut below = 0.0;
        for (k, &count) in self.bins.iter().enumerate() {
            let next = below + count as f64;
            if next > wanted {
                let (from, to) = (edge(k), edge(k + 1));
                return from + (to - from) * (wanted - below) / count as f64;
            }
            below = next;
        }
        self.max
    }
}

/// Where the octaves begin.
const LOWEST: i32 = 32 - OCTAVES as i32;

fn bin(value: f64) -> usize {
    let place = (value.max(f64::MIN_POSITIVE).log2() - f64::from(LOWEST)) * BINS as f64;
    // Below the first and beyond the last octave: the outermost bins.
    (place.max(0.0) as usize).min(BINS * OCTAVES - 1)
}

fn edge(bin: usize) -> f64 {
    (bin as f64 / BINS as f64 + f64::from(LOWEST)).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_are_exact_and_many_are_right_to_a_part_in_four_hundred() {
        let value = |k: usize| 1e-4 * (1.0 + (k as f64 * 0.754).sin()).powi(2);
        for count in [0, 1, 1000, KEPT, 4 * KEPT] {
            let mut tally = Tally::default();
            (0..count).for_each(|k| tally.add(std::iter::once(value(k))));
            tally.add([f64::NAN].into_iter());
            let (found, exact) = (tally.spread(), Spread::of((0..count).map(value)));
            assert_eq!(found.count, exact.count);
            let close = |a: f64, b: f64, share: f64| assert!((a - b).abs() <= share * b, "{a} {b}");
            close(found.mean, exact.mean, 1e-12);
            close(found.rms, exact.rms, 1e-12);
            close(found.max, exact.max, 0.0);
            close(found.p95, exact.p95, if count > KEPT { 4e-3 } else { 0.0 });
        }
    }

    #[test]
    fn parts_merge_to_the_whole_in_any_order() {
        let value = |k: usize| 1e-4 * (1.0 + (k as f64 * 0.754).sin()).powi(2);
        for count in [1000, KEPT, 4 * KEPT] {
            let part = |from: usize, step: usize| {
                let mut tally = Tally::default();
                tally.add((from..count).step_by(step).map(value));
                tally
            };
            let whole = part(0, 1).spread();
            for order in [[0, 1, 2], [2, 0, 1], [1, 2, 0]] {
                let mut sum = Tally::default();
                order.into_iter().for_each(|k| sum.merge(&Tally::restored(part(k, 3).stored())));
                assert_eq!(sum.spread(), whole);
            }
        }
    }
}
