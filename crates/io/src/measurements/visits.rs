//! Visits: any integers of the file as numbers 0… in order of first appearance.

use super::header::Header;
use super::mixed::{AlreadyMixed, Mixed};
use crate::IoError;
use std::collections::{BTreeMap, HashSet};
use std::hash::BuildHasherDefault;
use truepose_errormodel::Dataset;
use truepose_kinematics::Load;

/// Joints of one standstill agree to this, rad or m: encoders flicker, robots that moved differ by more.
const STANDSTILL: f64 = 1e-4;

/// Numbers of visits, stored as runs of consecutive labels, so that an ordinary file of any length needs one.
#[derive(Debug, Clone, Default)]
pub(crate) struct VisitNumbers {
    /// First label of a run → number of that label and length of the run.
    runs: BTreeMap<i64, (usize, usize)>,
    last: Option<(i64, usize)>,
    count: usize,
}

impl VisitNumbers {
    /// The number of a label, and whether the label is new.
    pub fn number(&mut self, label: i64) -> (usize, bool) {
        if let Some((last, number)) = self.last
            && last == label
        {
            return (number, false);
        }
        let run = self.runs.range_mut(..=label).next_back();
        let found = run.as_ref().and_then(|(first, (number, length))| {
            let offset = label.abs_diff(**first) as usize;
            (offset < *length).then_some(number + offset)
        });
        if let Some(number) = found {
            self.last = Some((label, number));
            return (number, false);
        }
        let number = self.count;
        self.count += 1;
        match run {
            Some((first, (start, length)))
                if label.abs_diff(*first) as usize == *length && *start + *length == number =>
            {
                *length += 1;
            }
            _ => {
                self.runs.insert(label, (number, 1));
            }
        }
        self.last = Some((label, number));
        (number, true)
    }

    /// The label of each number.
    pub fn labels(&self) -> Vec<i64> {
        let mut labels = vec![0; self.count];
        for (&first, &(number, length)) in &self.runs {
            for k in 0..length {
                labels[number + k] = first + k as i64;
            }
        }
        labels
    }
}

/// Refuses a visit whose rows differ in joints or load.
pub(crate) fn check_standstills(data: &Dataset, labels: &[i64], header: &Header) -> Result<(), IoError> {
    let mut first: Vec<usize> = vec![usize::MAX; labels.len()];
    for (row, &visit) in data.visit.iter().enumerate() {
        if first[visit] == usize::MAX {
            first[visit] = row;
        } else {
            check_same(data, first[visit], row, labels[visit], header)?;
        }
    }
    Ok(())
}

fn check_same(data: &Dataset, a: usize, b: usize, label: i64, header: &Header) -> Result<(), IoError> {
    let told = |what: String| {
        format!(
            "visit {label} has {what} than in line {}; rows of one visit are one standstill: give another visit number",
            data.line[a]
        )
    };
    for (k, column) in data.joints.iter().enumerate() {
        if (column[a] - column[b]).abs() > STANDSTILL {
            let slot = header.slots.joints.as_ref().map_or(0, |slots| slots[k]);
            return Err(header.cell_error(data.line[b], slot, told("another joint value".into())));
        }
    }
    let different = match (&data.load[a], &data.load[b]) {
        // A sensor never reads the same wrench twice.
        (Load::Wrench(_), Load::Wrench(_)) => false,
        (a, b) => a != b,
    };
    if different {
        let slot = header.slots.payload.or(header.slots.wrench.map(|slots| slots[0])).unwrap_or(0);
        return Err(header.cell_error(data.line[b], slot, told("another load".into())));
    }
    Ok(())
}

/// How many different pairs of joints and load the visits have; a measured wrench does not count as a load,
/// since it is never the same twice.
pub(crate) fn count_configurations(data: &Dataset) -> usize {
    let mut last = usize::MAX;
    let mut seen = HashSet::with_hasher(BuildHasherDefault::<AlreadyMixed>::default());
    for row in 0..data.len() {
        if data.visit[row] == last {
            continue;
        }
        last = data.visit[row];
        let mut key = Mixed::default();
        for column in &data.joints {
            key.add(column[row]);
        }
        match &data.load[row] {
            Load::None => key.add(0.0),
            Load::Payload(payload) => {
                key.add(payload.mass);
                payload.com.iter().for_each(|&v| key.add(v));
            }
            Load::Wrench(_) => key.add(1.0),
        }
        seen.insert(key);
    }
    seen.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ordinary_files_need_one_run() {
        let mut visits = VisitNumbers::default();
        for label in 5..1000 {
            assert_eq!(visits.number(label), (label as usize - 5, true));
            assert_eq!(visits.number(label), (label as usize - 5, false));
        }
        assert_eq!(visits.number(7), (2, false));
        assert_eq!(visits.runs.len(), 1);
        assert_eq!(visits.labels()[..3], [5, 6, 7]);
    }

    proptest! {
        #[test]
        fn numbers_follow_first_appearance(labels in prop::collection::vec(-4i64..12, 0..60)) {
            let mut visits = VisitNumbers::default();
            let mut order: Vec<i64> = Vec::new();
            for &label in &labels {
                let (number, new) = visits.number(label);
                prop_assert_eq!(new, !order.contains(&label));
                if new {
                    order.push(label);
                }
                prop_assert_eq!(order[number], label);
            }
            prop_assert_eq!(visits.labels(), order);
        }
    }

    #[test]
    fn extreme_labels() {
        let mut visits = VisitNumbers::default();
        for label in [i64::MAX, i64::MIN, 0, i64::MAX] {
            visits.number(label);
        }
        assert_eq!(visits.labels(), [i64::MAX, i64::MIN, 0]);
    }
}
