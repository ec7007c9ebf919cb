//! Tests of the best candidate before it is accepted.
//!
//! 1. Significance: the family-wise p of the rotation test ([`crate::significance`]) is at most α.
//! 2. Prediction of unseen configurations: paired, grouped cross-validation, t ≥ 2 with the variance of
//!    Nadeau and Bengio (2003); and contiguous blocks in time, in which the effect does not predict worse, in
//!    all blocks together or in the median block (one block may lie outside of the range of all others). An
//!    effect that depends on time has to keep half of its gain in these blocks.
//! 3. Relevance: a gain of 2 % of the held-out error of the rows on which it acts (those of one target or one
//!    payload), or of a tenth of the noise standard deviation.
//! 4. Stability: it is selected in 80 % of the half-samples (Meinshausen and Bühlmann 2010).

use crate::accept::surrogates::among_surrogates;
use crate::contest::competitor::Competitor;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::options::DiscoverOptions;
use crate::policy::Policy;
use crate::problem::dependence::BesideWander;
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Linearisation;
use crate::problem::residuals::distances;
use crate::screen::candidates::Screen;
use crate::significance::sign_flips::sign_flips;
use crate::statistics::paired::{median, students_t};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use truepose_errormodel::configurations;
use truepose_identify::{Folds, Split};

/// Evidence for an effect, from the linearised problem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Family-wise p-value of the rotation test: exact for normal errors. Where poses depend on those before and no other test
    /// refuses the effect, the larger one of this and of the likelihood ratio beside a wander.
    pub p_value: f64,
    /// p-value, as a single test, of 999 sign flips of whole poses: without the assumption of normal errors. Reported only; no
    /// decision uses it.
    pub p_sign_flips: f64,
    /// For an effect that reads a channel: p among 19 surrogates, the same channel moved in time. Above 0.05 another record would do as
    /// well, and the channel's name is doubtful.
    #[serde(default)]
    pub p_surrogates: Option<f64>,
    /// Number of poses on which the effect rests, (Σ b²)²/Σ b⁴ of their scores: with K of them, the sign flips cannot give a p below
    /// 2^(1−K).
    pub effective_poses: f64,
    /// Parametric p-value: χ² tail of the score statistic, times the number of tests (Bonferroni). Reported
    /// only; no decision uses it.
    pub p_parametric: f64,
    /// Degrees of freedom k: directions of the coefficients that the present model does not absorb.
    pub unknowns: usize,
    /// Likelihood-ratio statistic: decrease of −2 ln L, with the noise estimated with and without the effect.
    pub gain: f64,
    /// Cross-validation over random folds of whole configurations, at most ten.
    pub random: Gain,
    /// Cross-validation over contiguous blocks in time, at most five; `None` when a fold cannot be fitted.
    pub blocks: Option<Gain>,
    /// Selection frequency: fraction of 20 half-samples in which the Wald statistic exceeds k + 1.5 √(2k).
    pub stability: f64,
    /// Fraction of 10 pairs of complementary half-samples whose coefficients agree (Wald statistic of the
    /// difference below k + 3 √(2k)). Reported only; no decision uses it.
    pub agreement: f64,
}

/// Held-out error without and with an effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gain {
    /// 3-D RMS without the effect, m.
    pub before: f64,
    /// 3-D RMS with the effect, m.
    pub after: f64,
    /// Student's t of the paired difference over folds: the largest over three losses (mean squares; their
    /// logarithms, for an effect that is large in a few folds; the log score of a t distribution with 4
    /// degrees of freedom, for a few rows outside of the training range) and two scalings (each observation
    /// by its marginal standard deviation; whitened with the other observations of its pose).
    pub t: f64,
    /// Explained fraction of the held-out RMS of the standardised observations in the rows on which the
    /// effect acts; negative when it predicts worse.
    pub won: f64,
    /// The same of the median fold, over all observations: robust against one block outside of the range of
    /// all others.
    pub middle: f64,
}

/// Why a candidate with the best score is rejected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Doubt {
    /// Not significant: the family-wise p exceeds α.
    Chance,
    /// It does not predict unseen configurations better.
    NotPredictive,
    /// Its gain is below 2 % of the held-out error and below a tenth of the noise standard deviation, or does
    /// not exceed the penalty.
    TooSmall,
    /// Its selection frequency in half-samples is below 80 %.
    Unstable,
    /// The model contains it already.
    NothingNew,
    /// The fit with it does not converge.
    NotConverged,
    /// The fit with it has a larger training error.
    WorseFit,
    /// The refitted model with it predicts unseen poses no better than the model without.
    WorseUnseen,
    /// Its coefficients are not significant in the refitted model (Wald test).
    NotSignificant,
    /// A coefficient of the refitted model is outside of its physical bounds.
    NotPhysical,
}

/// Collects the evidence for a competitor, given its family-wise p.
pub(crate) fn collect(
    (linearisation, wander): (&Linearisation<'_>, &BesideWander<'_>),
    (screen, present): (&Screen, &Likelihood),
    competitor: &Competitor,
    p_value: f64,
    options: &DiscoverOptions,
) -> Result<Evidence, DiscoverError> {
    let seed = options.seed;
    let random = Folds::new(
        linearisation.data,
        &Split::Random { folds: folds(linearisation, linearisation.budget.folds), seed },
    )?;
    let blocks = Folds::new(
        linearisation.data,
        &Split::TimeBlocks { folds: folds(linearisation, linearisation.budget.blocks) },
    )?;
    let gain = |folds: &Folds| -> Result<Gain, DiscoverError> {
        let before = present.held_out(linearisation, folds, competitor.prior_width)?;
        let after = competitor.likelihood.held_out(linearisation, folds, competitor.prior_width)?;
        Ok(paired(linearisation, folds, competitor, &before, &after))
    };
    let (stability, agreement) = halves(linearisation, competitor, seed)?;
    let pose = linearisation.observations.iter().map(|o| o.visit);
    let check = sign_flips(&screen.projection, &competitor.columns, pose, seed);
    let mut evidence = Evidence {
        p_value,
        p_sign_flips: check.map_or(1.0, |check| check.p_value),
        effective_poses: check.map_or(0.0, |check| check.effective_poses),
        p_surrogates: among_surrogates(linearisation, screen, &competitor.candidate, options)?,
        p_parametric: parametric(screen, competitor),
        unknowns: competitor.freedom,
        gain: present.deviance - competitor.likelihood.deviance,
        random: gain(&random)?,
        blocks: gain(&blocks).ok(),
        stability,
        agreement,
    };
    // What is refused without a wander is refused beside it.
    let policy = (&options.policy, options.alpha);
    let slow = competitor.candidate.follows_time();
    if evidence.doubt_beyond_size(policy, slow).is_none() {
        let beside = wander.p_value(&competitor.columns, competitor.freedom);
        evidence.p_value = beside.map_or(p_value, |beside| beside.max(p_value));
        if slow {
            evidence.p_value = (options.policy.slow_tests * evidence.p_value).min(1.0);
        }
        if evidence.p_value <= options.alpha {
            let beside = wander.joints.p_value(&competitor.columns, competitor.freedom);
            evidence.p_value = beside.filter(|beside| *beside > options.alpha).unwrap_or(evidence.p_value);
        }
    }
    Ok(evidence)
}

impl Evidence {
    /// The first test that fails; `None` when all pass. `floor`: noise standard deviation of one position, m.
    pub(crate) fn doubt(
        &self,
        (policy, alpha): (&Policy, f64),
        floor: f64,
        belongs_to_time: bool,
    ) -> Option<Doubt> {
        let won = self.random.before - self.random.after;
        let doubt = self.doubt_beyond_size((policy, alpha), belongs_to_time);
        let small = self.random.won < policy.held_out_gain && won < policy.held_out_noise * floor;
        match doubt {
            None | Some(Doubt::Unstable) if small => Some(Doubt::TooSmall),
            doubt => doubt,
        }
    }

    /// The same without the lower bounds of its size: where the data is so much that the smallest effect that it shows is relevant.
    pub(crate) fn doubt_beyond_size(
        &self,
        (policy, alpha): (&Policy, f64),
        belongs_to_time: bool,
    ) -> Option<Doubt> {
        let blocks_agree = self.blocks.is_none_or(|blocks| {
            let won = blocks.won.max(blocks.middle);
            match belongs_to_time {
                true => won >= policy.time_gain_kept * self.random.won && blocks.t >= policy.time_t,
                false => won > -policy.blocks_loss,
            }
        });
        if self.p_value > alpha {
            Some(Doubt::Chance)
        } else if self.random.t < policy.held_out_t || !blocks_agree {
            Some(Doubt::NotPredictive)
        } else if self.stability < policy.stability {
            Some(Doubt::Unstable)
        } else {
            None
        }
    }
}

fn folds(linearisation: &Linearisation<'_>, most: usize) -> usize {
    let count = configurations(linearisation.data).iter().max().map_or(0, |last| last + 1);
    most.min(count).max(2)
}

/// The paired difference, fold by fold, over all standardised observations, positions and orientations alike.
/// `before` and `after` are held-out residuals, m or rad.
///
/// Two scalings: each observation by its marginal standard deviation, and whitened with the other
/// observations of its pose. While effects are missing that move all observations of a pose together, the
/// whitened residuals have more power.
fn paired(
    linearisation: &Linearisation<'_>,
    folds: &Folds,
    competitor: &Competitor,
    before: &[f64],
    after: &[f64],
) -> Gain {
    let noise = competitor.likelihood.noise;
    let deviations = linearisation.deviations(noise);
    let by_itself =
        |residual: &[f64]| -> Vec<f64> { deviations.iter().zip(residual).map(|(sd, r)| r / sd).collect() };
    let among_others = |residual: &[f64]| {
        let mut white = DMatrix::from_column_slice(residual.len(), 1, residual);
        linearisation.whitener(noise).apply(&mut white);
        white.as_slice().to_vec()
    };
    let alone = ByFold::new(linearisation, folds, &by_itself(before), &by_itself(after));
    let together = ByFold::new(linearisation, folds, &among_others(before), &among_others(after));
    let acts = acts(linearisation, competitor);
    let where_it_acts = |residual: &[f64]| -> f64 {
        let own = linearisation.observations.iter().zip(by_itself(residual)).filter(|(o, _)| acts[o.row]);
        own.map(|(_, deviation)| deviation * deviation).sum()
    };
    let rms = |residual: &[f64]| {
        let whole: Vec<f64> =
            distances(linearisation, residual).into_iter().filter(|v| v.is_finite()).collect();
        (whole.iter().sum::<f64>() / whole.len().max(1) as f64).sqrt()
    };
    let (without, with) = (where_it_acts(before), where_it_acts(after));
    Gain {
        before: rms(before),
        after: rms(after),
        t: alone.clearest().max(together.clearest()),
        won: if without > 0.0 { 1.0 - (with / without).sqrt() } else { 0.0 },
        middle: 1.0 - (-0.5 * median(&alone.ratios)).exp(),
    }
}

/// Paired differences of an effect in each fold, of squared standardised residuals.
struct ByFold {
    /// Mean difference of the squares.
    squares: Vec<f64>,
    /// Logarithm of the ratio of their sums.
    ratios: Vec<f64>,
    /// Mean difference of the log score under a t distribution.
    scores: Vec<f64>,
}

impl ByFold {
    /// From standardised residuals without and with the effect.
    fn new(linearisation: &Linearisation<'_>, folds: &Folds, without: &[f64], with: &[f64]) -> Self {
        let tail = linearisation.policy.score_tail;
        let surprisal = |square: f64| (1.0 + square / tail).ln();
        let mut sums = vec![[0.0; 4]; folds.count];
        for ((o, a), b) in linearisation.observations.iter().zip(without).zip(with) {
            let (a, b) = (a * a, b * b);
            let own = [a, b, surprisal(a) - surprisal(b), 1.0];
            sums[folds.of_visit[o.visit]].iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        }
        let filled: Vec<[f64; 4]> = sums.into_iter().filter(|[_, with, ..]| *with > 0.0).collect();
        let each = |of: fn(&[f64; 4]) -> f64| filled.iter().map(of).collect();
        ByFold {
            squares: each(|[a, b, _, n]| (a - b) / n),
            ratios: each(|[a, b, ..]| (a / b).ln()),
            scores: each(|[.., score, n]| score / n),
        }
    }

    /// The largest Student's t of the three losses.
    fn clearest(&self) -> f64 {
        students_t(&self.squares).max(students_t(&self.ratios)).max(students_t(&self.scores))
    }
}

/// Rows of the data in which the effect changes a prediction.
fn acts(linearisation: &Linearisation<'_>, competitor: &Competitor) -> Vec<bool> {
    let mut rows = vec![false; linearisation.data.len()];
    for (at, o) in linearisation.observations.iter().enumerate() {
        rows[o.row] |= competitor.columns.row(at).iter().any(|x| *x != 0.0);
    }
    rows
}

/// Selection frequency in half-samples, and fraction of complementary pairs whose coefficients agree.
fn halves(
    linearisation: &Linearisation<'_>,
    competitor: &Competitor,
    seed: u64,
) -> Result<(f64, f64), DiscoverError> {
    let (policy, count_of_halves) = (linearisation.policy, linearisation.budget.halves);
    let configuration = configurations(linearisation.data);
    let count = configuration.iter().max().map_or(0, |last| last + 1);
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x4a1f);
    let k = competitor.columns.ncols();
    let halves: Vec<Vec<bool>> = (0..count_of_halves)
        .map(|_| {
            let mut order: Vec<usize> = (0..count).collect();
            order.shuffle(&mut random);
            let first: std::collections::HashSet<usize> = order[..count / 2].iter().copied().collect();
            configuration.iter().map(|c| first.contains(c)).collect()
        })
        .collect();
    let size = |value: &nalgebra::DVector<f64>, covariance: nalgebra::DMatrix<f64>| {
        covariance.cholesky().map_or(0.0, |c| value.dot(&c.solve(value)))
    };
    let freedom = competitor.freedom as f64;
    let enough = freedom + policy.half_sample_deviations * (2.0 * freedom).sqrt();
    let judged: Vec<(usize, usize)> = halves
        .par_iter()
        .map(|mine| -> Result<(usize, usize), DiscoverError> {
            let [(a, ca), (b, cb)] = competitor.likelihood.on_halves(linearisation, mine, k)?;
            let difference = size(&(&a - &b), &ca + &cb);
            let there = usize::from(size(&a, ca) > enough) + usize::from(size(&b, cb) > enough);
            Ok((
                there,
                usize::from(difference < freedom + policy.agreement_deviations * (2.0 * freedom).sqrt()),
            ))
        })
        .collect::<Result<_, _>>()?;
    let (there, agree) = judged.iter().fold((0, 0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    Ok((there as f64 / (2 * count_of_halves) as f64, agree as f64 / count_of_halves as f64))
}

/// The parametric p-value of a competitor: χ² tail times the number of tests, at most one.
fn parametric(screen: &Screen, competitor: &Competitor) -> f64 {
    let tests = screen.tests();
    let distribution = ChiSquared::new(competitor.freedom as f64);
    let single = distribution.map_or(1.0, |distribution| distribution.sf(competitor.gain.max(0.0)));
    (single * tests.max(1) as f64).min(1.0)
}

/// A candidate that had the best score and failed a test.
#[derive(Debug, Clone)]
pub struct Refused {
    /// The candidate.
    pub candidate: Candidate,
    /// Its evidence in the linearised problem.
    pub evidence: Evidence,
    /// The test that it failed.
    pub doubt: Doubt,
}

impl Refused {
    /// Adds it to a list, unless the list has the same family and place with the same reason.
    pub(crate) fn note_in(self, refused: &mut Vec<Refused>) {
        if !refused.iter().any(|r| r.candidate.same_cause(&self.candidate) && r.doubt == self.doubt) {
            refused.push(self);
        }
    }
}
