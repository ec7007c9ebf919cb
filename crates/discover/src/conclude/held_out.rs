//! Intervals of the held-out errors.
//!
//! Held-out rows are those of a test set that is drawn before anything is fitted, or all rows, each predicted by a search that has not seen it
//! ([`crate::HeldOut`]): the gain on them is not the gain by which effects were selected. They decide one thing: whether all findings are withdrawn
//! ([`crate::conclude::fallback`]).

use crate::conclude::cross_validated::CrossValidated;
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
    /// Of two models, where `cluster` numbers the cluster of each held-out row; `None` of too few clusters. `folds` where the rows were
    /// predicted by cross-validation.
    pub(crate) fn of(
        [before, after]: [&Errors; 2],
        cluster: &[usize],
        folds: Option<CrossValidated>,
        draws: usize,
        seed: u64,
    ) -> Option<Self> {
        let rows: Vec<usize> = (0..cluster.len()).filter(|row| !after.outliers[1].contains(row)).collect();
        let pair = [&before.holdout, &after.holdout];
        let of_rows = |rows: &[usize]| {
            let found = of_pair(pair, cluster, rows, draws, seed)?;
            let rms = pair.map(|residuals| residuals.positions_of(rows).rms);
            Some(folds.map_or(found, |folds| folds.widen(found, rms)))
        };
        let Intervals { rms, gain, explained } = of_rows(&rows)?;
        let all: Vec<usize> = (0..cluster.len()).collect();
        let with_outliers = match rows.len() == all.len() {
            true => rms,
            false => of_rows(&all)?.rms,
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

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// Residuals of 1 to 2 mm in so many rows; those in `missing` are not known.
    fn errors(count: usize, missing: &[usize], factor: f64) -> Errors {
        let one = |row: usize| match missing.contains(&row) {
            true => Vector3::repeat(f64::NAN),
            false => Vector3::x() * (factor * (1.5e-3 + 5e-4 * (row as f64).sin())),
        };
        let holdout = Residuals { position: (0..count).map(one).collect(), orientation: vec![None; count] };
        Errors { holdout, ..Errors::default() }
    }

    #[test]
    fn equal_models_have_no_gain_whatever_is_not_known() {
        let cluster: Vec<usize> = (0..20).collect();
        let of = |a: &Errors, b: &Errors| HeldOutIntervals::of([a, b], &cluster, None, 99, 0).unwrap();
        let (before, after) = (errors(20, &[3, 4], 1.0), errors(20, &[3, 4], 1.0));
        assert_eq!(of(&before, &after).gain, None);
        let better = of(&before, &errors(20, &[3, 4], 0.5)).gain.unwrap();
        assert!(better.value > 0.0 && better.ci95[0] > 0.0, "{better:?}");
    }

    #[test]
    fn clusters_are_configurations_or_stretches_of_time() {
        let n = 40;
        let data = Dataset {
            joints: vec![(0..n).map(|row| 0.1 * (row / 2) as f64).collect()],
            approach: vec![vec![0.0; n]],
            visit: (0..n).map(|row| row / 2).collect(),
            time: (0..n).map(|row| 10.0 * row as f64).collect(),
            position: vec![[0.0; 3]; n],
            orientation: vec![None; n],
            position_sd: vec![[f64::NAN; 3]; n],
            orientation_sd: vec![[f64::NAN; 3]; n],
            target: vec![None; n],
            load: vec![truepose_kinematics::Load::None; n],
            ..Dataset::default()
        };
        let by_configuration: Vec<usize> = (0..n).map(|row| row / 2).collect();
        assert_eq!(clusters(&data, None), by_configuration);
        let wandering = |time_constant| Dependence {
            autocorrelation: 0.5,
            p_value: 1e-3,
            wander: Some(1e-4),
            time_constant: Some(time_constant),
            timed: true,
        };
        // Where nothing wanders the time constant of the test says nothing.
        let still = Dependence { wander: None, ..wandering(10.0) };
        assert_eq!(clusters(&data, Some(&still)), by_configuration);
        // 20 s are two rows; of a longer time constant ten stretches are left.
        let stretches = |found: &[usize]| found.iter().max().map(|last| last + 1);
        assert_eq!(stretches(&clusters(&data, Some(&wandering(10.0)))), Some(20));
        assert_eq!(stretches(&clusters(&data, Some(&wandering(1e6)))), Some(11));
    }
}
