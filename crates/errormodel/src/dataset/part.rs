//! Parts of a data set: some of its rows, which remember the order of poses of the whole.

use super::record::Record;
use super::table::Dataset;
use super::visits::Visits;
use std::borrow::Cow;
use std::collections::HashMap;

impl Dataset {
    /// The rows with these indices, in that order; visits are numbered anew.
    pub fn select(&self, rows: &[usize]) -> Dataset {
        fn pick<T: Clone>(column: &[T], rows: &[usize]) -> Vec<T> {
            rows.iter().map(|&row| column[row].clone()).collect()
        }
        let columns = |table: &[Vec<f64>]| table.iter().map(|column| pick(column, rows)).collect();
        Dataset {
            schema: self.schema.clone(),
            joints: columns(&self.joints),
            position: pick(&self.position, rows),
            orientation: pick(&self.orientation, rows),
            position_sd: pick(&self.position_sd, rows),
            orientation_sd: pick(&self.orientation_sd, rows),
            target: pick(&self.target, rows),
            visit: renumbered(&pick(&self.visit, rows)),
            load: pick(&self.load, rows),
            time: pick(&self.time, rows),
            by_order: self.by_order,
            approach: columns(&self.approach),
            channels: columns(&self.channels),
            dwell: self.dwell.clone(),
            line: if self.line.is_empty() { Vec::new() } else { pick(&self.line, rows) },
            record: Some(self.whole().select(rows)),
        }
    }

    /// The same data with the order of its poses worked out: else every part that is taken of it works it out anew, which is quadratic where there are many
    /// parts.
    #[must_use]
    pub fn recorded(mut self) -> Dataset {
        if self.record.is_none() {
            self.record = Some(self.as_whole());
        }
        self
    }

    /// The order of poses of the whole record that this data is, or is a part of.
    pub(super) fn whole(&self) -> Cow<'_, Record> {
        self.record.as_ref().map_or_else(|| Cow::Owned(self.as_whole()), Cow::Borrowed)
    }

    fn as_whole(&self) -> Record {
        let visits = Visits::of(self);
        let mut order: Vec<usize> = (0..visits.len()).filter(|&k| !visits.rows[k].is_empty()).collect();
        if self.schema.time {
            order.sort_by(|&a, &b| self.time[visits.rows[a][0]].total_cmp(&self.time[visits.rows[b][0]]));
        }
        let mut pose = vec![0; self.len()];
        for (k, &visit) in order.iter().enumerate() {
            visits.rows[visit].iter().for_each(|&row| pose[row] = k);
        }
        let by_pose = |table: &[Vec<f64>]| {
            let first = |column: &Vec<f64>| order.iter().map(|&k| column[visits.rows[k][0]]).collect();
            table.iter().map(first).collect()
        };
        let still = (0..self.joints.len()).map(|joint| self.dwell.repeat_tolerance(joint)).collect();
        let first = |k: &usize| visits.rows[*k][0];
        let time = order.iter().map(|k| self.time[first(k)]).collect();
        let load = order.iter().map(|k| self.load[first(k)]).collect();
        Record::new([by_pose(&self.joints), by_pose(&self.approach)], still, (time, load), pose)
    }
}

/// Any labels as indices 0… in order of first appearance.
fn renumbered(labels: &[usize]) -> Vec<usize> {
    let mut seen: HashMap<usize, usize> = HashMap::new();
    labels
        .iter()
        .map(|&label| {
            let next = seen.len();
            *seen.entry(label).or_insert(next)
        })
        .collect()
}
