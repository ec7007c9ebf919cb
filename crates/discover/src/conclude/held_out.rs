//! Intervals of the held-out errors.
//!
//! Held-out rows are those of a test set that is drawn before anything is fitted, or all rows, each predicted by a search that has not seen it
//! ([`crate::HeldOut`]): the gain on them is not the gain by which effects were selected. They decide one thing: whether all findings are withdrawn
//! ([`crate::conclude::fallback`]).

use crate::conclude::errors::Errors;
use crate::conclude::verdict::Estimate;
use crate::statistics::bootstrap::{Cluster, Intervals, intervals};
use truepose_errormodel::{Dataset, configurations};
use truepose_identify::Residuals;

/// 95 % intervals of held-out errors, without rows that no fit uses: bootstrap over its configurations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldOutIntervals {
    /// Of the 3-D RMS of the declared model, m.
    pub before: [f64; 2],
    /// Of the 3-D RMS of the final model, m.
    pub after: [f64; 2],
    /// The same of both models with the rows that no fit uses, m.
    pub with_outliers: [[f64; 2]; 2],
    /// RMS of the declared model less that of the final model, m; `None` where they are the same.
    pub gain: Option<Estimate>,
    /// Explained fraction of the mean square of the declared model; `None` where they are the same.
    pub explained: Option<Estimate>,
}

impl HeldOutIntervals {
    /// Of two models on the rows `held`; `None` of too few configurations.
    pub(crate) fn of(
        before: &Errors,
        after: &Errors,
        held: &Dataset,
        draws: usize,
        seed: u64,
    ) -> Option<Self> {
        let rows: Vec<usize> = (0..held.len()).filter(|row| !after.outliers[1].contains(row)).collect();
        let pair = [&before.holdout, &after.holdout];
        let Intervals { rms, gain, explained } = of_pair(pair, held, &rows, draws, seed)?;
        let all: Vec<usize> = (0..held.len()).collect();
        let with_outliers = match rows.len() == all.len() {
            true => rms,
            false => of_pair(pair, held, &all, draws, seed)?.rms,
        };
        let both = pair.map(|residuals| residuals.positions_of(&rows).rms);
        let same = before.holdout == after.holdout;
        let estimate = |value: f64, ci95: [f64; 2]| (!same).then_some(Estimate { value, ci95 });
        Some(HeldOutIntervals {
            before: rms[0],
            after: rms[1],
            with_outliers,
            gain: estimate(both[0] - both[1], gain),
            explained: estimate(1.0 - (both[1] / both[0]).powi(2), explained),
        })
    }
}

/// The intervals of two models' errors in these rows of a data set.
pub(crate) fn of_pair(
    pair: [&Residuals; 2],
    data: &Dataset,
    rows: &[usize],
    draws: usize,
    seed: u64,
) -> Option<Intervals> {
    let configuration = configurations(data);
    let mut clusters = vec![Cluster::default(); configuration.iter().max().map_or(0, |last| last + 1)];
    for &row in rows {
        let [Some(a), Some(b)] = pair.map(|residuals| residuals.distance(row)) else { continue };
        let own = &mut clusters[configuration[data.visit[row]]];
        own.squares[0] += a * a;
        own.squares[1] += b * b;
        own.rows += 1.0;
    }
    clusters.retain(|cluster| cluster.rows > 0.0);
    intervals(&clusters, draws, seed)
}
