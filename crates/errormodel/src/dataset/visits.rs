//! Visits and configurations: which rows belong together.
//!
//! Rows of one standstill share its repeatability; visits of one configuration and load are repeats of each
//! other. Splits and folds never cut the former and never part the latter.

use super::matching::same_load;
use super::table::Dataset;
use std::collections::HashMap;

/// The rows of each visit, in order of first appearance.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Visits {
    /// Row indices of visit k.
    pub rows: Vec<Vec<usize>>,
}

impl Visits {
    /// Groups the rows of a data set.
    pub fn of(data: &Dataset) -> Self {
        let count = data.visit.iter().max().map_or(0, |last| last + 1);
        let mut rows = vec![Vec::new(); count];
        for (row, &visit) in data.visit.iter().enumerate() {
            rows[visit].push(row);
        }
        Visits { rows }
    }

    /// How many visits.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// True without any visit.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }
}

/// Visits of rows without a visit number: consecutive rows of one dwell ([`Dataset::continues_dwell`]) are one visit.
pub fn visits_from_rows(data: &Dataset) -> Vec<usize> {
    let rows = data.load.len();
    let mut visit = Vec::with_capacity(rows);
    let (mut number, mut first) = (0, 0);
    for row in 0..rows {
        if row > 0 && !data.continues_dwell(first, row) {
            number += 1;
            first = row;
        }
        visit.push(number);
    }
    visit
}

/// The configuration of each visit: visits with the same joints, to the tolerance of [`super::Dwell`], and the same load share a number.
/// Each is matched with the *first* visit of a configuration, the nearest where there are several, so that a slow sweep is cut into
/// configurations no wider than the tolerance and never becomes one. Numbers are 0… in order of first appearance.
pub fn configurations(data: &Dataset) -> Vec<usize> {
    let visits = Visits::of(data);
    // The joints as one number, in which what is within all tolerances differs by less than the width of a cell: of all others, hardly any
    // are in the same cell or in one beside it. Of those a second number tells nearly all apart before their rows are read.
    let [by_cell, beside_it] =
        [0.618_033_988_749_895, 0.754_877_666_246_693].map(|share| Sum::new(data, share));
    let cell = |row: usize| (by_cell.of(data, row) / by_cell.width).floor() as i64;
    let mut cells: HashMap<i64, Vec<(f64, usize)>> = HashMap::new();
    // First row of each configuration.
    let mut first: Vec<usize> = Vec::new();
    visits
        .rows
        .iter()
        .map(|rows| {
            let row = rows[0];
            let (own, sum) = (cell(row), beside_it.of(data, row));
            let known = (-1..=1)
                .filter_map(|beside| cells.get(&own.saturating_add(beside)))
                .flatten()
                .filter(|(other, _)| (other - sum).is_nan() || (other - sum).abs() <= beside_it.width)
                .filter(|&&(_, c)| same_load(&data.load[first[c]], &data.load[row]))
                .filter_map(|&(_, c)| Some((data.repeat_distance(first[c], row)?, c)))
                .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            known.map(|(_, nearest)| nearest).unwrap_or_else(|| {
                cells.entry(own).or_default().push((sum, first.len()));
                first.push(row);
                first.len() - 1
            })
        })
        .collect()
}

/// A weighted sum of the joints, each in its tolerance.
struct Sum {
    weights: Vec<f64>,
    /// What it differs by, at most, where each joint is within its tolerance.
    width: f64,
}

impl Sum {
    fn new(data: &Dataset, share: f64) -> Self {
        let weights: Vec<f64> = (0..data.joints.len()).map(|k| 0.5 + (share * k as f64).fract()).collect();
        let width = weights.iter().sum::<f64>() * (1.0 + 1e-9) + 1e-3;
        Sum { weights, width }
    }

    fn of(&self, data: &Dataset, row: usize) -> f64 {
        let joints = data.joints.iter().zip(&self.weights).enumerate();
        joints.map(|(k, (q, w))| w * q[row] / data.dwell.repeat_tolerance(k).max(1e-12)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dwell, DwellTolerance};
    use truepose_kinematics::{Load, samples};

    /// Rows of two joints, without a position.
    fn rows(joints: &[[f64; 2]]) -> Dataset {
        let n = joints.len();
        let mut data = Dataset {
            joints: (0..2).map(|k| joints.iter().map(|q| q[k]).collect()).collect(),
            position: vec![[f64::NAN; 3]; n],
            position_sd: vec![[f64::NAN; 3]; n],
            target: vec![None; n],
            load: vec![Load::None; n],
            ..Dataset::default()
        };
        data.visit = visits_from_rows(&data);
        data
    }

    #[test]
    fn a_slow_sweep_is_not_one_pose() {
        // Steps of a third of the tolerance: every fourth row begins a visit, and no visit is wider than the tolerance.
        let sweep: Vec<[f64; 2]> = (0..40).map(|k| [0.4 + 3.3e-6 * f64::from(k), 1.0]).collect();
        let data = rows(&sweep);
        assert_eq!(data.visit[..9], [0, 0, 0, 0, 1, 1, 1, 1, 2]);
        // Configurations are cut from it by their own tolerance: none is wider, and a sweep of any length is never one of them.
        let sweep: Vec<[f64; 2]> = (0..400).map(|k| [0.4 + 2.1e-5 * f64::from(k), 1.0]).collect();
        let data = rows(&sweep);
        let configuration = configurations(&data);
        assert_eq!(configuration, (0..400).map(|k| k / 5).collect::<Vec<_>>());
    }

    #[test]
    fn a_robot_that_was_sent_to_the_same_place_again_is_in_the_same_configuration() {
        // What it reports differs by less than 1e-4 rad, far beyond flicker; a new visit by any measure.
        let place = |k: usize| [0.013 * k as f64 - 2.0, 1.0 - 0.007 * k as f64];
        let again = |k: usize| {
            let p = place(k);
            [p[0] + 6e-5 * (1.7 * k as f64).sin(), p[1] - 9e-5 * (2.3 * k as f64).cos()]
        };
        let all: Vec<[f64; 2]> = (0..200).map(place).chain((0..200).map(again)).collect();
        let data = rows(&all);
        assert_eq!(data.visit, (0..400).collect::<Vec<_>>());
        let found = configurations(&data);
        assert_eq!(found[200..], found[..200]);
        assert_eq!(found.iter().max(), Some(&199));
    }

    #[test]
    fn configurations_are_matched_across_flicker_wherever_they_lie() {
        // Each configuration comes again with flicker, around every possible border of a cell.
        let place = |k: usize| [0.1 * k as f64 - 2.0 + 1.3e-6 * k as f64, 1.0 - 1e-3 * k as f64];
        let flicker = |k: usize, p: [f64; 2]| {
            let off = 4e-6 * if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            [p[0] + off, p[1] - off]
        };
        let mut all: Vec<[f64; 2]> = (0..500).map(place).collect();
        all.extend((0..500).map(|k| flicker(k, place(k))));
        let found = configurations(&rows(&all));
        assert_eq!(found[500..], found[..500]);
        assert_eq!(found.iter().max(), Some(&499));
        // Without a tolerance they are a thousand, and equal bits still are one.
        let mut exact = rows(&all);
        exact.dwell.joints = vec![0.0; 2];
        assert_eq!(configurations(&exact).iter().max(), Some(&999));
        let again: Vec<[f64; 2]> = (0..500).chain(0..500).map(place).collect();
        let mut again = rows(&again);
        again.dwell.joints = vec![0.0; 2];
        assert_eq!(configurations(&again).iter().max(), Some(&499));
    }

    #[test]
    fn positions_part_rows_of_equal_joints() {
        let mut data = rows(&[[0.2, 0.3]; 5]);
        let chain = samples::scara();
        data.dwell = Dwell::of(&chain, DwellTolerance::default());
        data.dwell.joints.truncate(2);
        let length = chain.characteristic_length();
        data.position = vec![[1.0, 0.0, 0.0]; 5];
        data.position[3][1] = 5e-4 * length;
        // Half of what the coarsest instrument scatters by: noise, for all that is known.
        assert_eq!(visits_from_rows(&data), [0; 5]);
        data.position[3][1] = 5e-3 * length;
        assert_eq!(visits_from_rows(&data), [0, 0, 0, 1, 2]);
        // An instrument that states what it scatters by is believed.
        data.position[3][1] = 5e-4 * length;
        data.position_sd = vec![[5e-6 * length; 3]; 5];
        assert_eq!(visits_from_rows(&data), [0, 0, 0, 1, 2]);
        // They are repeats of each other all the same: nothing parts them in folds.
        data.visit = visits_from_rows(&data);
        assert_eq!(configurations(&data), [0; 3]);
        // Another target stands elsewhere.
        data.target[3] = Some(truepose_kinematics::TargetId(0));
        assert_eq!(visits_from_rows(&data), [0; 5]);
    }
}
