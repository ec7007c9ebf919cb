//! Tests of the best candidate on all rows, from its scores in contiguous parts of the data.
//!
//! ```text
//! b_u = Tᵀ X̃_uᵀ r_u,  I_u = Tᵀ X̃_uᵀ X̃_u T                 X̃ = X − A Z, unit u
//! ĉ_F = (Σ_{u∉F} I_u)⁻¹ Σ_{u∉F} b_u                        without the units of fold F
//! won by fold F: Σ_{u∈F} 2 ĉ_Fᵀ b_u − ĉ_Fᵀ I_u ĉ_F         decrease of the held-out sum of squares
//! T² = Sᵀ V⁻¹ S / U,   S = Σ b_u,   V = Σ e_u e_uᵀ/(U − 1),   e_u = b_u − I_u ĉ        T² (U − k)/(k (U − 1)) ~ F(k, U − k)
//! ```
//!
//! The last line takes the scatter of the scores from the units themselves: it holds where the noise is not that of the fit, changes from place to
//! place, or depends on the poses before (Hotelling 1931; clustered errors: Liang and Zeger 1986). At so many rows that is what decides.

use crate::accept::evidence::{Evidence, Gain};
use crate::census::all_rows::AllRows;
use crate::census::blocks::Blocks;
use crate::census::details::Detail;
use crate::census::white::White;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::options::DiscoverOptions;
use crate::significance::rotation::NullDistribution;
use crate::statistics::beta::surprisal;
use crate::statistics::paired::{median, students_t};
use nalgebra::{DMatrix, DVector};
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use truepose_errormodel::Dataset;

/// What a contiguous part of the data says of a candidate.
#[derive(Clone)]
struct Unit {
    score: DVector<f64>,
    information: DMatrix<f64>,
    /// Σ ‖r‖², whitened, and numbers.
    squares: f64,
    count: usize,
}

impl Unit {
    fn nothing(freedom: usize) -> Self {
        Unit {
            score: DVector::zeros(freedom),
            information: DMatrix::zeros(freedom, freedom),
            squares: 0.0,
            count: 0,
        }
    }

    fn add(&mut self, other: &Unit) {
        self.score += &other.score;
        self.information += &other.information;
        self.squares += other.squares;
        self.count += other.count;
    }

    fn sum<'a>(units: impl Iterator<Item = &'a Unit>, freedom: usize) -> Unit {
        units.fold(Unit::nothing(freedom), |mut sum, unit| {
            sum.add(unit);
            sum
        })
    }

    /// ĉ and its Wald statistic.
    fn estimate(&self) -> Option<(DVector<f64>, f64)> {
        let estimate = self.information.clone().cholesky()?.solve(&self.score);
        let statistic = estimate.dot(&self.score);
        Some((estimate, statistic))
    }

    /// Decrease of the sum of squares by these coefficients.
    fn won(&self, estimate: &DVector<f64>) -> f64 {
        2.0 * estimate.dot(&self.score) - estimate.dot(&(&self.information * estimate))
    }
}

/// −ln p of all units together, with the scatter of their scores among themselves; zero where there are too few of them.
fn surprisal_of_units(units: &[Unit], freedom: usize) -> f64 {
    let count = units.len();
    let whole = Unit::sum(units.iter(), freedom);
    let Some((estimate, _)) = whole.estimate() else { return 0.0 };
    if count < 2 * freedom + 2 {
        return 0.0;
    }
    let mut scatter = DMatrix::zeros(freedom, freedom);
    for unit in units {
        let left = &unit.score - &unit.information * &estimate;
        scatter += &left * left.transpose() / (count - 1) as f64;
    }
    let Some(factor) = scatter.cholesky() else { return 0.0 };
    let squared = whole.score.dot(&factor.solve(&whole.score)) / count as f64;
    let ratio = squared / (count - 1) as f64;
    surprisal(ratio / (1.0 + ratio), freedom, count)
}

/// The evidence for a candidate. Its family-wise p is the larger one of that of the fit's noise and that of the units' own scatter.
pub(crate) fn evidence(
    candidate: &Candidate,
    detail: &Detail,
    null: &NullDistribution,
    (all, blocks): (&AllRows, &Blocks),
    options: &DiscoverOptions,
) -> Result<Evidence, DiscoverError> {
    let units = units(candidate, detail, (all, blocks), options)?;
    let (policy, budget) = (&options.policy, &options.budget);
    let p_value = null.p_value(detail.surprisal.min(surprisal_of_units(&units, detail.freedom())));
    let mut random = ChaCha8Rng::seed_from_u64(options.seed ^ 0x4a1f);
    let k = detail.freedom();
    let mut order: Vec<usize> = (0..units.len()).collect();
    order.shuffle(&mut random);
    let folds = |count: usize, place: &dyn Fn(usize) -> usize| -> Vec<usize> {
        (0..units.len()).map(|unit| place(unit) * count / units.len()).collect()
    };
    let place: Vec<usize> = {
        let mut place = vec![0; units.len()];
        order.iter().enumerate().for_each(|(at, &unit)| place[unit] = at);
        place
    };
    let scale = all.fit.noise.floor(f64::NAN);
    let gain = |fold: Vec<usize>| gain(&units, &fold, (k, scale));
    let halves = budget.halves;
    let enough = k as f64 + policy.half_sample_deviations * (2.0 * k as f64).sqrt();
    let apart = k as f64 + policy.agreement_deviations * (2.0 * k as f64).sqrt();
    let (mut there, mut agree) = (0, 0);
    for _ in 0..halves {
        order.shuffle(&mut random);
        let half = order.len() / 2;
        let parts =
            [&order[..half], &order[half..]].map(|part| Unit::sum(part.iter().map(|&unit| &units[unit]), k));
        let [Some((a, first)), Some((b, second))] = parts.each_ref().map(Unit::estimate) else { continue };
        there += usize::from(first > enough) + usize::from(second > enough);
        let covariance = parts.map(|part| part.information.try_inverse());
        if let [Some(ca), Some(cb)] = covariance
            && let Some(factor) = (ca + cb).cholesky()
        {
            let difference = a - b;
            agree += usize::from(difference.dot(&factor.solve(&difference)) < apart);
        }
    }
    let (flips, effective) = sign_flips(&units, &mut random);
    let single = ChiSquared::new(k as f64).map_or(1.0, |d| d.sf(detail.gain.max(0.0)));
    Ok(Evidence {
        p_value,
        p_sign_flips: flips,
        p_surrogates: None,
        effective_poses: effective,
        p_parametric: single.min(1.0),
        unknowns: k,
        gain: detail.gain,
        random: gain(folds(budget.folds.min(units.len()), &|unit| place[unit])),
        blocks: Some(gain(folds(budget.blocks.min(units.len()), &|unit| unit))),
        stability: there as f64 / (2 * halves) as f64,
        agreement: agree as f64 / halves as f64,
    })
}

fn units(
    candidate: &Candidate,
    detail: &Detail,
    (all, blocks): (&AllRows, &Blocks),
    options: &DiscoverOptions,
) -> Result<Vec<Unit>, DiscoverError> {
    let of = |block: &Dataset| -> Result<Unit, DiscoverError> {
        let white = White::of((block, blocks), (&all.at, &all.fit), candidate.effects(), options)?;
        let White { base, columns, residual } = white;
        let left = (columns - base * &detail.taken) * &detail.basis;
        Ok(Unit {
            score: left.tr_mul(&residual),
            information: left.tr_mul(&left),
            squares: residual.norm_squared(),
            count: residual.len(),
        })
    };
    let derived = blocks.derived(&all.fit, candidate.effects().iter());
    let mut units = vec![Unit::nothing(detail.freedom()); blocks.units()];
    blocks.each(1, &derived, &of, &mut |block, part| units[blocks.unit(block)].add(&part))?;
    Ok(units)
}

/// The held-out gain over folds of units: `fold` of each unit. `scale`: 3-D standard deviation that a whitened residual of one stands for, m.
fn gain(units: &[Unit], fold: &[usize], (freedom, scale): (usize, f64)) -> Gain {
    let count = fold.iter().max().map_or(0, |last| last + 1);
    let mut each = Vec::new();
    let (mut before, mut after, mut numbers) = (0.0, 0.0, 0);
    for held in 0..count {
        let of = |inside: bool| {
            let chosen = units.iter().zip(fold).filter(move |(_, f)| (**f == held) == inside);
            Unit::sum(chosen.map(|(unit, _)| unit), freedom)
        };
        let (test, train) = (of(true), of(false));
        let Some((estimate, _)) = train.estimate() else { continue };
        let won = test.won(&estimate);
        before += test.squares;
        after += test.squares - won;
        numbers += test.count;
        each.push((won / test.count.max(1) as f64, won / test.squares.max(f64::MIN_POSITIVE)));
    }
    let (won, shares): (Vec<f64>, Vec<f64>) = each.into_iter().unzip();
    let rms = |squares: f64| scale * (squares.max(0.0) / numbers.max(1) as f64).sqrt();
    Gain {
        before: rms(before),
        after: rms(after),
        t: students_t(&won),
        won: if before > 0.0 { 1.0 - (after / before).max(0.0).sqrt() } else { 0.0 },
        middle: 1.0 - (1.0 - median(&shares)).max(0.0).sqrt(),
    }
}

/// p of 999 sign flips of units, and the number of units on which the candidate rests.
fn sign_flips(units: &[Unit], random: &mut ChaCha8Rng) -> (f64, f64) {
    const FLIPS: usize = 999;
    let squares: Vec<f64> = units.iter().map(|unit| unit.score.norm_squared()).collect();
    let (sum, fourth) = squares.iter().fold((0.0, 0.0), |(s, f), b| (s + b, f + b * b));
    let freedom = units.first().map_or(0, |unit| unit.score.len());
    let whole = Unit::sum(units.iter(), freedom).score.norm_squared();
    let mut as_large = 0;
    for _ in 0..FLIPS {
        let mut flipped = DVector::<f64>::zeros(freedom);
        for unit in units {
            let sign = if random.next_u32() & 1 == 0 { 1.0 } else { -1.0 };
            flipped += &unit.score * sign;
        }
        as_large += usize::from(flipped.norm_squared() >= whole * (1.0 - 1e-12));
    }
    ((1 + as_large) as f64 / (FLIPS + 1) as f64, if fourth > 0.0 { sum * sum / fourth } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::synthetic::normal;

    /// Units with scores of standard deviation `scatter` about `signal`, each with an information of one.
    fn units(signal: f64, scatter: f64, seed: usize) -> Vec<Unit> {
        (0..60)
            .map(|u| Unit {
                score: DVector::from_fn(2, |k, _| signal + scatter * normal(1000 * seed + 2 * u + k)),
                information: DMatrix::identity(2, 2),
                squares: 100.0,
                count: 100,
            })
            .collect()
    }

    #[test]
    fn the_scatter_of_the_units_decides_and_not_the_noise_of_the_fit() {
        // Under the fit's noise (scatter 1) a sum of 60 scores of scatter 5 is five deviations out.
        let p: Vec<f64> =
            (0..200).map(|seed| (-surprisal_of_units(&units(0.0, 5.0, seed), 2)).exp()).collect();
        let below = |level: f64| p.iter().filter(|p| **p < level).count();
        assert!((3..=20).contains(&below(0.05)) && (70..=130).contains(&below(0.5)), "{p:?}");
        assert!((-surprisal_of_units(&units(4.0, 5.0, 1), 2)).exp() < 1e-5);
    }

    #[test]
    fn what_is_in_all_units_is_won_on_unseen_ones_and_noise_is_not() {
        let folds: Vec<usize> = (0..60).map(|u| u % 10).collect();
        let there = gain(&units(1.0, 1.0, 3), &folds, (2, 1e-3));
        assert!(there.t > 2.0 && there.after < there.before, "{there:?}");
        let lost: usize =
            (0..40).filter(|&seed| gain(&units(0.0, 1.0, 100 + seed), &folds, (2, 1e-3)).t > 2.0).count();
        assert!(lost <= 4, "{lost}");
    }

    #[test]
    fn flips_of_signs_see_what_is_common() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let (p, effective) = sign_flips(&units(1.0, 1.0, 7), &mut random);
        assert!(p <= 0.001 + 1e-12 && effective > 20.0, "{p} {effective}");
        assert!(sign_flips(&units(0.0, 1.0, 8), &mut random).0 > 0.01);
    }
}
