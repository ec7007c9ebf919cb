//! Rows and poses that no repeatable effect explains.
//!
//! A row is standardised by what all others of its pose say, a pose by its marginal covariance: where the robot had not settled, or a reflector was
//! re-seated, all rows of a pose are displaced together, and none of them by the others' account. `t² = Σ e²` of the three components has three
//! degrees of freedom, and those that lie outside are found by [`crate::problem::outside`].
//!
//! Orientations are judged by themselves in the same way. A row of which one or two components were measured has fewer degrees of freedom: its
//! t² counts as the one that is as improbable with three.

use crate::policy::Policy;
use crate::problem::linearisation::Linearisation;
use crate::problem::outside::{Judged, judged, units};
use crate::problem::shared::{Shared, level_of, stretch_of};
use crate::problem::whitening::{Mean, Whitener};
use std::collections::BTreeMap;
use truepose_errormodel::{Dataset, Visits};
use truepose_identify::NoiseModel;

/// Rows that lie outside.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Outliers {
    /// Rows that are kept out of fits.
    pub suspects: Vec<usize>,
    /// Rows that are reported.
    pub certain: Vec<usize>,
    /// Rows that would be kept out, but have a declared payload in common: a label may be wrong there, which is an effect.
    pub admitted: Vec<usize>,
    /// Poses of several rows that are reported with all of them.
    pub poses: Vec<usize>,
    /// How many good rows would be expected beyond the least of those: the family-wise p; 1 without any.
    pub p_value: f64,
    /// Standardised distance of every row of the data, in robust deviations of one axis; NaN where nothing was measured.
    pub distance: Vec<f64>,
}

/// Judges the rows and poses of a linearised problem by these raw residuals.
pub(crate) fn outliers(linearisation: &Linearisation<'_>, residual: &[f64], noise: NoiseModel) -> Outliers {
    let data = linearisation.data;
    let whitener = linearisation.whitener(noise);
    let mut found = Outliers { distance: vec![f64::NAN; data.len()], ..Outliers::default() };
    let positions = one_by_one(linearisation, &whitener, residual, 0);
    positions.distances.iter().for_each(|&(row, distance)| found.distance[row] = distance);
    found.join(&positions, |row| vec![row]);
    found.join(&one_by_one(linearisation, &whitener, residual, 3), |row| vec![row]);
    // A pose of one row is that row.
    let visits = Visits::of(data);
    if visits.rows.iter().any(|rows| rows.len() > 1) {
        let mut sums = vec![(0.0, 0); visits.len()];
        // A row that is displaced by itself says nothing about its pose: it lies outside by the others' account, wherever the pose is.
        let apart = judged(
            &units(apart(linearisation, &whitener, residual)),
            linearisation.visits,
            linearisation.policy,
        )
        .suspects;
        let good =
            |row: usize| apart.binary_search(&row).is_err() || found.suspects.binary_search(&row).is_err();
        for mean in whitener.means() {
            let o = linearisation.observations[mean.members[0]];
            let (mut squares, mut along) = (0.0, 0.0);
            for ((&at, d), v) in mean.members.iter().zip(mean.weights).zip(mean.along) {
                if good(linearisation.observations[at].row) {
                    squares += v * v;
                    along += v * d * residual[at];
                }
            }
            if o.component < 3 && squares > 0.0 {
                let variance = noise.visit_sd.powi(2) + 1.0 / squares;
                sums[o.visit].0 += (along / squares).powi(2) / variance;
                sums[o.visit].1 += 1;
            }
        }
        let several = |visit: usize| visits.rows[visit].iter().filter(|&&row| good(row)).count() > 1;
        let mut poses = judged(&units(sums), linearisation.visits, linearisation.policy);
        poses.suspects.retain(|&visit| several(visit));
        poses.certain.retain(|&(visit, _)| several(visit));
        for &(visit, distance) in poses.distances.iter().filter(|(visit, _)| poses.suspects.contains(visit)) {
            visits.rows[visit]
                .iter()
                .for_each(|&row| found.distance[row] = found.distance[row].max(distance));
        }
        found.join(&poses, |visit| visits.rows[visit].clone());
        let out = |row: &usize| found.certain.binary_search(row).is_ok();
        let displaced = |&visit: &usize| visits.rows[visit].len() > 1 && visits.rows[visit].iter().all(out);
        found.poses = (0..visits.len()).filter(displaced).collect();
    }
    if found.certain.is_empty() {
        found.p_value = 1.0;
    }
    found
}

impl Outliers {
    /// Leaves those that have a declared payload in common in the fits.
    pub fn admit(&mut self, data: &Dataset, policy: &Policy) {
        let Some(shared) = level_of(data, &self.suspects, policy.outlier_shared) else { return };
        let other = |row: &usize| shared.rows.binary_search(row).is_err();
        self.suspects.retain(other);
        self.certain.retain(other);
        self.poses.clear();
        if self.certain.is_empty() {
            self.p_value = 1.0;
        }
        self.admitted = shared.rows;
    }

    /// Those that have a declared payload or a stretch of the record in common, which are certain then: so many gross errors are not by
    /// chance where they are.
    pub fn together(&mut self, data: &Dataset, policy: &Policy) -> Option<Shared> {
        let chance = policy.outlier_shared;
        let shared =
            level_of(data, &self.suspects, chance).or_else(|| stretch_of(data, &self.suspects, chance))?;
        self.p_value = match self.certain.is_empty() {
            true => shared.p_value,
            false => self.p_value.max(shared.p_value),
        };
        self.certain.extend(&shared.rows);
        self.certain.sort_unstable();
        self.certain.dedup();
        Some(shared)
    }

    /// Adds the rows of units that lie outside.
    fn join(&mut self, judged: &Judged, rows: impl Fn(usize) -> Vec<usize>) {
        self.suspects.extend(judged.suspects.iter().flat_map(|&unit| rows(unit)));
        self.certain.extend(judged.certain.iter().flat_map(|&(unit, _)| rows(unit)));
        self.p_value = judged.certain.iter().map(|c| c.1).fold(self.p_value, f64::max);
        for list in [&mut self.suspects, &mut self.certain] {
            list.sort_unstable();
            list.dedup();
        }
    }
}

/// Judges rows by their position (orientation: `first` = 3). The worst suspect of each pose is set aside, and the others are judged by each
/// other's account without it, until none is left that is a suspect by the account of good rows.
fn one_by_one(
    linearisation: &Linearisation<'_>,
    whitener: &Whitener,
    residual: &[f64],
    first: usize,
) -> Judged {
    let observations = &linearisation.observations;
    let mut aside = vec![false; linearisation.data.len()];
    loop {
        let standardised = whitener.deleted(residual, &|at| aside[observations[at].row]);
        let mut sums = vec![(0.0, 0); aside.len()];
        for (o, e) in observations.iter().zip(&standardised) {
            if (first..first + 3).contains(&o.component) {
                sums[o.row] = (sums[o.row].0 + e * e, sums[o.row].1 + 1);
            }
        }
        let found = judged(&units(sums), linearisation.visits, linearisation.policy);
        let mut worst: BTreeMap<usize, (usize, f64)> = BTreeMap::new();
        let suspect = |row: &usize| found.suspects.binary_search(row).is_ok() && !aside[*row];
        for &(row, distance) in found.distances.iter().filter(|(row, _)| suspect(row)) {
            let of_pose = worst.entry(linearisation.data.visit[row]).or_insert((row, distance));
            if distance > of_pose.1 {
                *of_pose = (row, distance);
            }
        }
        if worst.is_empty() {
            return found;
        }
        worst.values().for_each(|&(row, _)| aside[row] = true);
    }
}

/// Sum of squares, and how many numbers, of each row's position against the mean of the other rows of its pose, wherever the pose is.
fn apart(linearisation: &Linearisation<'_>, whitener: &Whitener, residual: &[f64]) -> Vec<(f64, usize)> {
    let mut sums = vec![(0.0, 0); linearisation.data.len()];
    for mean in whitener.means().filter(|mean| mean.on_axis) {
        let Mean { members, weights, .. } = mean;
        let squares: f64 = weights.iter().map(|d| d * d).sum();
        let along: f64 = members.iter().zip(weights).map(|(&at, d)| d * d * residual[at]).sum();
        for (&at, d) in members.iter().zip(weights) {
            let (o, own, others) = (linearisation.observations[at], d * d, squares - d * d);
            if o.component < 3 && others > 1e-9 * squares {
                let away = residual[at] - (along - own * residual[at]) / others;
                sums[o.row].0 += away * away / (1.0 / own + 1.0 / others);
                sums[o.row].1 += 1;
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::DiscoverOptions;
    use crate::problem::synthetic::{data, fitted, normal};

    const NOISE: NoiseModel = NoiseModel { position_sd: 3e-5, visit_sd: 0.0, orientation_sd: 2e-4 };

    /// Outliers of 80 poses with normal residuals of which some rows are displaced so many standard deviations.
    fn judged(displaced: &[usize], deviations: f64) -> Outliers {
        let (chain, data) = data(80, 3, &|_, _, _| [0.0; 3]);
        let fit = fitted(&chain, &data);
        let options = DiscoverOptions::default();
        let linearisation = Linearisation::new(&fit, &data, &options).unwrap();
        let residual: Vec<f64> = (linearisation.observations.iter().enumerate())
            .map(|(at, o)| {
                let sd = if o.component < 3 { NOISE.position(2e-5) } else { 2e-4 };
                let moved = if displaced.contains(&o.row) && o.component == 0 { deviations } else { 0.0 };
                sd * (normal(at) + moved)
            })
            .collect();
        outliers(&linearisation, &residual, NOISE)
    }

    #[test]
    fn normal_residuals_have_no_outliers() {
        let none = judged(&[], 0.0);
        assert!(none.suspects.is_empty() && none.certain.is_empty());
        assert!((none.p_value - 1.0).abs() < 1e-12);
    }

    #[test]
    fn displaced_rows_are_reported_and_no_others() {
        for rows in [vec![5], vec![5, 30, 62, 90]] {
            let found = judged(&rows, 25.0);
            assert_eq!(found.certain, rows);
            assert!(found.p_value < DiscoverOptions::default().policy.outlier_certain);
            assert!(rows.iter().all(|&row| found.distance[row] > 8.0));
        }
    }

    #[test]
    fn a_pose_whose_rows_are_displaced_together_is_reported() {
        // Poses 0, 4, 8 … have three rows. What two of them share is ten times what poses scatter by, and nothing to their rows.
        let noise = NoiseModel { visit_sd: 4e-5, ..NOISE };
        let (chain, data) = data(120, 3, &|_, _, _| [0.0; 3]);
        let fit = fitted(&chain, &data);
        let options = DiscoverOptions::default();
        let linearisation = Linearisation::new(&fit, &data, &options).unwrap();
        let residual = |displaced: &[usize]| -> Vec<f64> {
            let of = |(at, o): (usize, &crate::problem::observation::Observation)| {
                if o.component >= 3 {
                    return 2e-4 * normal(at);
                }
                let moved = if displaced.contains(&o.visit) { 4e-4 } else { 0.0 };
                let shared = noise.visit_sd * normal(50_000 + 3 * o.visit + o.component);
                noise.position(2e-5) * normal(at) + shared + moved
            };
            linearisation.observations.iter().enumerate().map(of).collect()
        };
        let none = outliers(&linearisation, &residual(&[]), noise);
        assert!(none.certain.is_empty() && none.poses.is_empty(), "{none:?}");
        let found = outliers(&linearisation, &residual(&[8, 44]), noise);
        assert_eq!(found.poses, [8, 44]);
        let rows: Vec<usize> = (0..data.len()).filter(|&row| [8, 44].contains(&data.visit[row])).collect();
        assert_eq!((rows.len(), &found.certain), (6, &rows));
        assert!(rows.iter().all(|&row| found.distance[row] > 5.0));
    }

    #[test]
    fn a_displaced_pose_is_one_however_many_of_its_rows_look_displaced_alone() {
        // The fit without the pose: poses scatter little, so that its rows lie outside by themselves. The smaller the displacement, the fewer do.
        let (chain, data) = data(120, 3, &|_, _, _| [0.0; 3]);
        let fit = fitted(&chain, &data);
        let options = DiscoverOptions::default();
        let linearisation = Linearisation::new(&fit, &data, &options).unwrap();
        let noise = NoiseModel { visit_sd: 2.5e-5, ..NOISE };
        let judged = |moved: &dyn Fn(usize) -> f64| {
            let of = |(at, o): (usize, &crate::problem::observation::Observation)| match o.component {
                0..3 => {
                    let shared = noise.visit_sd * normal(50_000 + 3 * o.visit + o.component);
                    noise.position(2e-5) * normal(at) + shared + moved(o.row)
                }
                _ => 2e-4 * normal(at),
            };
            let residual: Vec<f64> = linearisation.observations.iter().enumerate().map(of).collect();
            outliers(&linearisation, &residual, noise)
        };
        let of_pose =
            |pose: usize| -> Vec<usize> { (0..data.len()).filter(|&row| data.visit[row] == pose).collect() };
        let pose = of_pose(44);
        for size in [2.2e-4, 2.6e-4, 3e-4, 3.5e-4, 5e-4, 8e-4] {
            let found = judged(&|row| if pose.contains(&row) { size } else { 0.0 });
            assert_eq!((&found.suspects, &found.poses), (&pose, &vec![44]), "{size}");
            // One row of it alone is no displaced pose, and takes none of the others with it.
            let found = judged(&|row| if row == pose[1] { 2.0 * size } else { 0.0 });
            assert_eq!((&found.suspects, &found.poses), (&vec![pose[1]], &vec![]), "{size}");
        }
    }

    #[test]
    fn orientations_and_single_components_are_judged() {
        let (chain, mut data) = data(120, 3, &|_, _, _| [0.0; 3]);
        // One row lost two components.
        let partial = data.visit.iter().position(|&visit| visit == 7).unwrap();
        data.position[partial][1] = f64::NAN;
        data.position[partial][2] = f64::NAN;
        let turned = data.visit.iter().position(|&visit| visit == 33).unwrap();
        let fit = fitted(&chain, &data);
        let options = DiscoverOptions::default();
        let linearisation = Linearisation::new(&fit, &data, &options).unwrap();
        let residual: Vec<f64> = (linearisation.observations.iter().enumerate())
            .map(|(at, o)| {
                let sd = if o.component < 3 { NOISE.position(2e-5) } else { 2e-4 };
                let moved = (o.row, o.component) == (partial, 0) || (o.row, o.component) == (turned, 4);
                sd * (normal(at) + if moved { 15.0 } else { 0.0 })
            })
            .collect();
        assert_eq!(outliers(&linearisation, &residual, NOISE).certain, [partial, turned]);
    }

    #[test]
    fn what_a_quarter_of_the_rows_have_is_an_effect() {
        let rows: Vec<usize> = (0..110).step_by(4).collect();
        assert!(judged(&rows, 25.0).suspects.is_empty());
    }
}
