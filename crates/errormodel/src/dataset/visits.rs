//! Visits and configurations: which rows belong together.
//!
//! Rows of one standstill share its repeatability; visits of one configuration and load are repeats of each
//! other. Splits and folds never cut the former and never part the latter.

use super::Dataset;
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

/// Visits of rows without a visit number: consecutive rows with equal joints and load are one visit.
pub fn visits_from_rows(data: &Dataset) -> Vec<usize> {
    let rows = data.load.len();
    let mut visit = Vec::with_capacity(rows);
    for row in 0..rows {
        let next = match visit.last() {
            None => 0,
            Some(&last) if data.same_configuration(row - 1, row) => last,
            Some(&last) => last + 1,
        };
        visit.push(next);
    }
    visit
}

/// The configuration of each visit: visits with equal joints and equal load share a number.
/// Numbers are 0… in order of first appearance.
pub fn configurations(data: &Dataset) -> Vec<usize> {
    let visits = Visits::of(data);
    let mut seen: HashMap<Vec<u64>, usize> = HashMap::new();
    visits
        .rows
        .iter()
        .map(|rows| {
            let row = rows[0];
            let mut key: Vec<u64> = data.joints.iter().map(|column| column[row].to_bits()).collect();
            match data.load[row] {
                truepose_kinematics::Load::None => key.push(0),
                truepose_kinematics::Load::Payload(p) => {
                    key.push(1);
                    key.push(p.mass.to_bits());
                    key.extend(p.com.iter().map(|v| v.to_bits()));
                }
                // A measured wrench is never the same twice: the joints alone tell repeats.
                truepose_kinematics::Load::Wrench(_) => key.push(2),
            }
            let next = seen.len();
            *seen.entry(key).or_insert(next)
        })
        .collect()
}

/// Any labels as indices 0… in order of first appearance.
pub(super) fn renumbered(labels: &[usize]) -> Vec<usize> {
    let mut seen: HashMap<usize, usize> = HashMap::new();
    labels
        .iter()
        .map(|&label| {
            let next = seen.len();
            *seen.entry(label).or_insert(next)
        })
        .collect()
}
