//! Intervals of the held-out errors.
//!
//! Held-out rows are those of a test set that is drawn before anything is fitted, or all rows, each predicted by a search that has not seen it
//! ([`crate::HeldOut`]): the gain on them is not the gain by which effects were selected. They decide one thing: whether all findings are withdrawn
//! ([`crate::conclude::fallback`]).

use crate::conclude::errors::Errors;
use crate::conclude::verdict::Estimate;
use crate::problem::dependence::Dependence;
use crate::statistics::bootstrap::{Cluster, Intervals, intervals};
use truepose_errormodel::{Dataset, configurations};
use truepose_identify::Residuals;

/// 95 % intervals of held-out errors, without rows that no fit uses: bootstrap over configurations, or over stretches of time where
/// poses depend on those measured shortly before.
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
    /// Of two models, where `cluster` numbers the cluster of each held-out row; `None` of too few clusters.
    pub(crate) fn of(
        before: &Errors,
        after: &Errors,
        cluster: &[usize],
        draws: usize,
        seed: u64,
    ) -> Option<Self> {
        let rows: Vec<usize> = (0..cluster.len()).filter(|row| !after.outliers[1].contains(row)).collect();
        let pair = [&before.holdout, &after.holdout];
        let Intervals { rms, gain, explained } = of_pair(pair, cluster, &rows, draws, seed)?;
        let all: Vec<usize> = (0..cluster.len()).collect();
        let with_outliers = match rows.len() == all.len() {
            true => rms,
            false => of_pair(pair, cluster, &all, draws, seed)?.rms,
        };
        let both = pair.map(|residuals| residuals.positions_of(&rows).rms);
        // Rows without a measurement have no distance in either.
        let same = all.iter().all(|&row| before.holdout.distance(row) == after.holdout.distance(row));
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

/// The number of each row's cluster: its configuration. Where poses depend on those measured shortly before, a stretch of time of twice the
/// time constant (numbers of poses where the data has no time), shorter where less than [`STRETCHES`] would come of it.
pub(crate) fn clusters(data: &Dataset, dependence: Option<&Dependence>) -> Vec<usize> {
    let constant = dependence.and_then(|d| d.wander.and(d.time_constant).map(|time| (time, d.timed)));
    let Some((constant, timed)) = constant else {
        let configuration = configurations(data);
        return data.visit.iter().map(|&visit| configuration[visit]).collect();
    };
    let at = |row: usize| if timed { data.time[row] } else { data.visit[row] as f64 };
    let known = (0..data.len()).map(at).filter(|t| t.is_finite());
    let (first, last) = known.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
    let length = (2.0 * constant).min((last - first) / STRETCHES).max(f64::MIN_POSITIVE);
    (0..data.len())
        .map(|row| if at(row).is_finite() { ((at(row) - first) / length) as usize } else { 0 })
        .collect()
}

/// Fewest stretches of time that rows are divided into: a bootstrap of fewer clusters says little.
const STRETCHES: f64 = 10.0;

/// The intervals of two models' errors in these rows, of which each has the number of its cluster.
pub(crate) fn of_pair(
    pair: [&Residuals; 2],
    cluster: &[usize],
    rows: &[usize],
    draws: usize,
    seed: u64,
) -> Option<Intervals> {
    let mut clusters = vec![Cluster::default(); cluster.iter().max().map_or(0, |last| last + 1)];
    for &row in rows {
        let [Some(a), Some(b)] = pair.map(|residuals| residuals.distance(row)) else { continue };
        let own = &mut clusters[cluster[row]];
        own.squares[0] += a * a;
        own.squares[1] += b * b;
        own.rows += 1.0;
    }
    clusters.retain(|cluster| cluster.rows > 0.0);
    intervals(&clusters, draws, seed)
}
