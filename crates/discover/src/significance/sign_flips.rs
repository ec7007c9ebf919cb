//! Family-wise p-values by sign-flipping whole units: visits, or neighbouring visits together.
//!
//! ```text
//! T  = max over all candidates of the surprise of SS/RSS, among numbers and among visits
//! T* = the same of P S r̃, S a random sign for each unit
//! r  = the better of the ranks of its two parts among all B + 1
//! p  = #{r* ≤ r} / (B + 1), itself counted
//! ```
//!
//! RSS is that of the flipped residual after the present model has been projected out of it, so that the statistic is normalised. *Among numbers* the
//! gain −m ln(1 − SS/RSS) is held against χ²: a cause that makes up most of the residual wins, even in a few visits. Where several causes
//! are still hidden and all numbers of a visit err together, rich candidates do as well by chance; *among visits* each is held against
//! the law of its own share ([`crate::problem::projection`]). The two are one test: p counts flips that are as extreme in either.
//! Source: Freedman and Lane (1983); Winkler et al. (2014) for exchangeable blocks; Pesarin (2001) for the combination.

use crate::problem::projection::Projection;
use crate::statistics::beta::{LEAST, Share};
use crate::statistics::chi_square::surprise;
use crate::statistics::surprisal::Surprise;
use nalgebra::DMatrix;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// The distribution of the largest statistics when nothing is missing.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NullDistribution {
    among_numbers: Ranked,
    among_visits: Ranked,
}

/// One statistic of all flips.
#[derive(Debug, Clone, PartialEq)]
struct Ranked {
    /// By flip.
    values: Vec<f64>,
    /// Ascending.
    sorted: Vec<f64>,
}

impl Ranked {
    fn new(values: Vec<f64>) -> Self {
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        Ranked { values, sorted }
    }

    /// How many flips are no smaller than this.
    fn above(&self, value: f64) -> usize {
        self.sorted.len() - self.sorted.partition_point(|&t| t < value)
    }

    /// The rank of a flip, the largest being the first, when this value is among them.
    fn rank(&self, flip: usize, beside: f64) -> usize {
        self.above(self.values[flip]) + usize::from(beside > self.values[flip])
    }
}

/// Scores of several statistics side by side: units × (sum of freedoms).
pub(crate) struct Block {
    pub by_unit: DMatrix<f32>,
    /// Degrees of freedom of each statistic, in the order of the columns, and the law of the share that it takes by chance.
    pub each: Vec<(usize, Share)>,
}

/// What the flips of some statistics come to.
struct Largest {
    /// Largest share by number of unknowns: flips × (1 + most unknowns).
    shares: DMatrix<f32>,
    /// Largest surprise among visits of each flip, [`LEAST`] or more.
    surprises: Vec<f64>,
}

impl Largest {
    fn none(flips: usize, widest: usize) -> Self {
        Largest { shares: DMatrix::zeros(flips, widest + 1), surprises: vec![LEAST; flips] }
    }

    fn of(block: &Block, signs: &DMatrix<f32>, inverse: &[f32], widest: usize) -> Self {
        let flips = signs.nrows();
        let mut largest = Largest::none(flips, widest);
        let sums = signs * &block.by_unit;
        let mut squares = vec![0.0f32; flips];
        let mut first = 0;
        for &(freedom, law) in &block.each {
            squares.fill(0.0);
            for column in sums.as_slice()[first * flips..(first + freedom) * flips].chunks_exact(flips) {
                for (square, v) in squares.iter_mut().zip(column) {
                    *square += v * v;
                }
            }
            let most = &mut largest.shares.as_mut_slice()[freedom * flips..(freedom + 1) * flips];
            let bound = law.bound();
            for (((most, surprising), square), inverse) in
                most.iter_mut().zip(&mut largest.surprises).zip(&squares).zip(inverse)
            {
                let share = square * inverse;
                *most = most.max(share);
                if f64::from(bound.of(share)) > *surprising {
                    *surprising = surprising.max(law.surprise(f64::from(share)));
                }
            }
            first += freedom;
        }
        largest
    }

    fn with(self, other: Self) -> Self {
        let pairs = self.surprises.into_iter().zip(other.surprises);
        Largest {
            shares: self.shares.zip_map(&other.shares, f32::max),
            surprises: pairs.map(|(a, b)| a.max(b)).collect(),
        }
    }
}

impl NullDistribution {
    pub fn new(projection: &Projection, blocks: &[Block], flips: usize, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x5167_f11b);
        let signs = DMatrix::<f32>::from_fn(flips, projection.units, |_, _| {
            if random.next_u32() & 1 == 0 { 1.0 } else { -1.0 }
        });
        // ‖P S r̃‖² = ‖r̃‖² − ‖Q_1ᵀ S r̃‖².
        let absorbed = &signs * projection.q_by_unit.map(|v| v as f32);
        let whole = projection.residual.norm_squared();
        let inverse: Vec<f32> = (0..flips)
            .map(|b| {
                let gone: f64 = absorbed.row(b).iter().map(|&v| f64::from(v).powi(2)).sum();
                (1.0 / (whole - gone).max(1e-3 * whole)) as f32
            })
            .collect();
        let widest = blocks.iter().flat_map(|block| &block.each).map(|&(freedom, _)| freedom).max();
        let widest = widest.unwrap_or(0);
        let largest = blocks
            .par_iter()
            .map(|block| Largest::of(block, &signs, &inverse, widest))
            .reduce(|| Largest::none(flips, widest), Largest::with);
        // The surprise grows with the share: only the largest share of each number of unknowns has to be turned into one.
        let among_numbers = largest.shares.row_iter().map(|row| {
            row.iter()
                .enumerate()
                .filter(|(_, share)| **share > 0.0)
                .map(|(freedom, &share)| surprise(projection.gain(f64::from(share), 1.0), freedom))
                .fold(f64::NEG_INFINITY, f64::max)
        });
        NullDistribution {
            among_numbers: Ranked::new(among_numbers.collect()),
            among_visits: Ranked::new(largest.surprises),
        }
    }

    /// #{r* ≤ r} / (B + 1), itself counted.
    pub fn p_value(&self, statistic: Surprise) -> f64 {
        let parts =
            [(&self.among_numbers, statistic.among_numbers), (&self.among_visits, statistic.among_visits)];
        let rank = parts.iter().map(|(ranked, value)| 1 + ranked.above(*value)).min().unwrap_or(1);
        let flips = self.among_numbers.values.len();
        let as_extreme =
            |&flip: &usize| parts.iter().any(|(ranked, value)| ranked.rank(flip, *value) <= rank);
        (1 + (0..flips).filter(as_extreme).count()) as f64 / (flips + 1) as f64
    }

    /// The surprise among numbers that is reached by chance with this probability.
    pub fn critical(&self, alpha: f64) -> f64 {
        let sorted = &self.among_numbers.sorted;
        let n = sorted.len();
        let at = ((1.0 - alpha) * n as f64).ceil() as usize;
        sorted.get(at.min(n.saturating_sub(1))).copied().unwrap_or(f64::INFINITY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;

    #[test]
    fn two_statistics_are_one_test() {
        // Of B + 1 alike each is as extreme as p says, however the two hang together.
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let (flips, trials) = (99, 2000);
        for together in [0.0, 0.7, 1.0] {
            let mut below = 0;
            for _ in 0..trials {
                let mut pair = || {
                    let (a, b): (f64, f64) = (random.random(), random.random());
                    (a, if b < together { a } else { random.random() })
                };
                let (numbers, visits): (Vec<f64>, Vec<f64>) = (0..flips).map(|_| pair()).unzip();
                let null = NullDistribution {
                    among_numbers: Ranked::new(numbers),
                    among_visits: Ranked::new(visits),
                };
                let (among_numbers, among_visits) = pair();
                below += usize::from(null.p_value(Surprise { among_numbers, among_visits }) <= 0.1);
            }
            let share = below as f64 / trials as f64;
            // Four deviations of a binomial law with 2000 trials.
            assert!((share - 0.1).abs() < 0.027, "{together}: {share}");
        }
    }

    #[test]
    fn the_first_in_either_is_among_the_first_two() {
        let values: Vec<f64> = (0..999).map(f64::from).collect();
        let back: Vec<f64> = values.iter().rev().copied().collect();
        let null = NullDistribution { among_numbers: Ranked::new(values), among_visits: Ranked::new(back) };
        let p = |among_numbers, among_visits| null.p_value(Surprise { among_numbers, among_visits });
        let thousandths =
            [p(1e3, 1e3), p(1e3, 500.0), p(-1.0, 1e3), p(-1.0, -1.0)].map(|p| (1e3 * p).round() as usize);
        assert_eq!(thousandths, [1, 2, 2, 1000]);
    }
}
