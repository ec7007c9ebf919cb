//! Visits: any integers of the file as numbers 0… in order of first appearance.

use super::header::Header;
use super::info::Grouping;
use crate::IoError;
use std::collections::BTreeMap;
use truepose_errormodel::{Dataset, Dwell, DwellTolerance};
use truepose_kinematics::{Chain, JointKind, Load};

/// What the label of a visit grows by from one session to the next: each may count its own visits from one.
const SESSION: i64 = 1 << 42;

/// The label of a visit among those of all sessions.
pub(crate) fn in_session(label: i64, session: usize) -> i64 {
    // Sessions are at most a thousand; a label that large is nobody's.
    label.wrapping_add((session as i64).wrapping_mul(SESSION))
}

/// What the file calls a visit. Labels of more than twelve digits, or without sessions, are as they are.
pub(crate) fn label_in_file(label: i64, sessions: usize) -> i64 {
    if sessions < 2 { label } else { label - (label + SESSION / 2).div_euclid(SESSION) * SESSION }
}

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

/// Refuses a visit whose rows differ in load, or in joints by more than encoders flicker: by more than repeats of one configuration do in
/// `still`, the default of this robot.
pub(crate) fn check_standstills(
    (data, still): (&Dataset, &Dwell),
    labels: &[i64],
    header: &Header,
) -> Result<(), IoError> {
    let mut first: Vec<usize> = vec![usize::MAX; labels.len()];
    for (row, &visit) in data.visit.iter().enumerate() {
        if first[visit] == usize::MAX {
            first[visit] = row;
        } else {
            check_same((data, still), [first[visit], row], labels[visit], header)?;
        }
    }
    Ok(())
}

fn check_same(
    (data, still): (&Dataset, &Dwell),
    [a, b]: [usize; 2],
    label: i64,
    header: &Header,
) -> Result<(), IoError> {
    let told = |what: String| {
        format!(
            "visit {label} has {what} than in line {}; rows of one visit are one pose measurement: give another visit number",
            data.line[a]
        )
    };
    for (k, column) in data.joints.iter().enumerate() {
        if (column[a] - column[b]).abs() > data.dwell.tolerance(k).max(still.repeat_tolerance(k)) {
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

/// How the rows of a whole file were grouped, given the configuration of each visit.
pub(crate) fn grouping(
    data: &Dataset,
    chain: &Chain,
    configuration: &[usize],
    tolerance: DwellTolerance,
    numbered: bool,
) -> Grouping {
    let [angle, length] = tolerance.on(chain);
    let [repeat_tolerance_angle, repeat_tolerance_length] = [angle, length].map(DwellTolerance::of_repeats);
    let mut found = Grouping {
        angle,
        length,
        repeat_tolerance_angle,
        repeat_tolerance_length,
        numbered,
        ..Grouping::default()
    };
    let slides: Vec<bool> =
        chain.movable().iter().map(|&joint| chain.joint(joint).kind == JointKind::Prismatic).collect();
    let mut begun = 0;
    let mut first: Vec<usize> = vec![usize::MAX; configuration.len()];
    let mut leader = vec![usize::MAX; configuration.iter().max().map_or(0, |last| last + 1)];
    let mut repeated = vec![false; leader.len()];
    // By how much a row differs from another one: of turning joints and of slides.
    let apart = |row: usize, from: usize| {
        let mut most = [0.0; 2];
        for (q, &slide) in data.joints.iter().zip(&slides) {
            let most = &mut most[usize::from(slide)];
            *most = f64::max(*most, (q[row] - q[from]).abs());
        }
        most
    };
    for row in 0..data.len() {
        let (visit, of) = (data.visit[row], configuration[data.visit[row]]);
        let beside = row.checked_sub(1).filter(|&before| data.visit[before] != visit);
        if let Some(before) = beside {
            found.parted += usize::from(!numbered && data.same_place(begun, row));
            begun = row;
            let apart = data.joints.iter().enumerate().map(|(k, q)| {
                let by = (q[row] - q[before]).abs();
                (by, by <= data.dwell.tolerance(k), by <= NEAR * data.dwell.tolerance(k))
            });
            let (mut most, mut near, mut same) = (0.0, true, true);
            for (by, within, almost) in apart {
                most = f64::max(most, by);
                near &= almost;
                same &= within;
            }
            if near && !same && data.load[before] == data.load[row] {
                found.near += 1;
                found.near_most = found.near_most.max(most);
            }
        }
        if first[visit] == usize::MAX {
            first[visit] = row;
            if leader[of] == usize::MAX {
                leader[of] = row;
            } else {
                found.repeats += 1;
                found.repeated += usize::from(!std::mem::replace(&mut repeated[of], true));
                let [angle, length] = apart(row, leader[of]);
                found.repeat_angle = found.repeat_angle.max(angle);
                found.repeat_length = found.repeat_length.max(length);
            }
            continue;
        }
        let [angle, length] = apart(row, first[visit]);
        found.flickering += usize::from(angle.max(length) > 0.0);
        found.flicker_angle = found.flicker_angle.max(angle);
        found.flicker_length = found.flicker_length.max(length);
    }
    found
}

/// Neighbours that differ by less than so many tolerances are suspicious.
const NEAR: f64 = 10.0;

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
