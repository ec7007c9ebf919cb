//! A sample of the rows on which a model was fitted: where the robot really was, and what was measured there.
//!
//! Rows are drawn by a hash of their own content: the rows with the smallest hashes are the sample. So every row is as likely as any
//! other, the order of the rows plays no part, and the sample of a whole is the sample of its parts' samples (bottom-k sampling, Cohen
//! and Kaplan 2007).

use crate::{BoundModel, Dataset, ErrorModel, MEETS, Schema, Signal};
use std::collections::HashSet;
use std::sync::Arc;
use truepose_kinematics::Load;

/// Rows that are kept. A projection on some thirty parameters from that many positions is worse than that of all rows by half a per cent
/// of its error (p/2m, m = 3000), and a fit file grows by a quarter of a megabyte at most.
const KEPT: usize = 1000;

/// Rows of a fit; cheap to clone.
#[derive(Debug, Clone, Default)]
pub struct Sample {
    rows: Arc<Dataset>,
    of: usize,
}

/// Equal content, row by row; what was not measured (NaN) is equal to itself.
impl PartialEq for Sample {
    fn eq(&self, other: &Self) -> bool {
        self.of == other.of
            && self.rows.schema == other.rows.schema
            && (0..self.rows.len())
                .map(|row| key(&self.rows, row))
                .eq((0..other.rows.len()).map(|row| key(&other.rows, row)))
    }
}

impl Sample {
    /// Of the rows of a data set of which anything was measured.
    pub fn of(data: &Dataset) -> Self {
        let measured: Vec<usize> = (0..data.len()).filter(|&row| data.seen(row).count() > 0).collect();
        Sample { of: measured.len(), rows: Arc::new(smallest(data, measured)) }
    }

    /// As it stands in a file: these rows, of so many.
    pub fn stored(rows: Dataset, of: usize) -> Self {
        Sample { rows: Arc::new(rows), of }
    }

    /// The rows: conditions as they were declared, and what was measured. Visits are counted anew.
    pub fn rows(&self) -> &Dataset {
        &self.rows
    }

    /// How many rows it was drawn from.
    pub fn drawn_from(&self) -> usize {
        self.of
    }

    /// Without the channels that a model does not read; which points met stays known.
    pub fn for_model(mut self, model: &ErrorModel) -> Self {
        let read: HashSet<String> = model
            .effects()
            .iter()
            .flat_map(|effect| effect.needs())
            .filter_map(|need| if let Signal::Channel(name) = need { Some(name) } else { None })
            .chain([MEETS.to_owned()])
            .collect();
        if self.rows.schema.channels.iter().all(|channel| read.contains(&channel.name)) {
            return self;
        }
        let rows = Arc::make_mut(&mut self.rows);
        let kept: Vec<bool> =
            rows.schema.channels.iter().map(|channel| read.contains(&channel.name)).collect();
        let mut keep = kept.iter();
        rows.schema.channels.retain(|_| keep.next().copied().unwrap_or(false));
        let mut keep = kept.iter();
        rows.channels.retain(|_| keep.next().copied().unwrap_or(false));
        self
    }

    /// Without the order of its rows, where that stands for their time.
    #[must_use]
    pub fn without_order(mut self) -> Self {
        if self.rows.by_order {
            let rows = Arc::make_mut(&mut self.rows);
            (rows.schema.time, rows.by_order) = (false, false);
            rows.time.fill(0.0);
        }
        self
    }

    /// The model, ready for these rows; none where the sample is empty or lacks a signal that the model reads.
    pub fn bound<'m>(&self, model: &'m ErrorModel) -> Option<BoundModel<'m>> {
        if self.rows.is_empty() { None } else { model.bind(&self.rows.schema).ok() }
    }

    /// Adds the sample of another part of the same data.
    pub(super) fn widen(&mut self, other: &Sample) {
        if self.rows.is_empty() {
            *self = other.clone();
            return;
        }
        self.of += other.of;
        let both = joined(&self.rows, &other.rows);
        let all = (0..both.len()).collect();
        self.rows = Arc::new(smallest(&both, all));
    }
}

/// The rows with the smallest keys, in their order.
fn smallest(data: &Dataset, rows: Vec<usize>) -> Dataset {
    let mut keyed: Vec<(u64, usize)> = rows.into_iter().map(|row| (key(data, row), row)).collect();
    if keyed.len() > KEPT {
        keyed.select_nth_unstable(KEPT - 1);
        keyed.truncate(KEPT);
    }
    keyed.sort_unstable();
    let rows: Vec<usize> = keyed.into_iter().map(|(_, row)| row).collect();
    let mut kept = data.select(&rows);
    kept.line = Vec::new();
    kept.record = None;
    kept
}

/// A number that depends on every bit of a row's content and nothing else.
fn key(data: &Dataset, row: usize) -> u64 {
    let mut state = 0u64;
    // SplitMix64 (Steele, Lea and Flood 2014), fed a number at a time.
    let mut feed = |bits: u64| {
        let mut z = (state ^ bits).wrapping_add(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        state = z ^ (z >> 31);
    };
    // A quiet NaN has one form in files; other forms are made the same.
    let bits = |v: f64| if v.is_nan() { f64::NAN.to_bits() } else { v.to_bits() };
    data.joints.iter().for_each(|column| feed(bits(column[row])));
    data.position[row].iter().for_each(|&v| feed(bits(v)));
    data.orientation[row].iter().flatten().for_each(|&v| feed(bits(v)));
    feed(data.target[row].map_or(0, |target| target.0 as u64 + 1));
    match data.load[row] {
        Load::None => {}
        Load::Payload(payload) => {
            feed(bits(payload.mass));
            payload.com.iter().for_each(|&v| feed(bits(v)));
        }
        Load::Wrench(wrench) => wrench.force.iter().chain(&wrench.moment).for_each(|&v| feed(bits(v))),
    }
    feed(bits(data.time[row]));
    data.approach.iter().chain(&data.channels).for_each(|column| feed(bits(column[row])));
    state
}

/// The rows of both, of one schema.
fn joined(a: &Dataset, b: &Dataset) -> Dataset {
    fn both<T: Clone>(a: &[T], b: &[T]) -> Vec<T> {
        a.iter().chain(b).cloned().collect()
    }
    let columns = |a: &[Vec<f64>], b: &[Vec<f64>]| a.iter().zip(b).map(|(a, b)| both(a, b)).collect();
    Dataset {
        dwell: a.dwell.clone(),
        schema: Schema {
            time: a.schema.time && b.schema.time,
            load: a.schema.load || b.schema.load,
            approach: a.schema.approach && b.schema.approach,
            ..a.schema.clone()
        },
        joints: columns(&a.joints, &b.joints),
        position: both(&a.position, &b.position),
        orientation: both(&a.orientation, &b.orientation),
        position_sd: both(&a.position_sd, &b.position_sd),
        orientation_sd: both(&a.orientation_sd, &b.orientation_sd),
        target: both(&a.target, &b.target),
        visit: (0..a.len() + b.len()).collect(),
        load: both(&a.load, &b.load),
        time: both(&a.time, &b.time),
        by_order: a.by_order || b.by_order,
        approach: columns(&a.approach, &b.approach),
        channels: columns(&a.channels, &b.channels),
        line: Vec::new(),
        record: None,
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // what is exact is tested as such
mod tests {
    use super::*;

    /// Rows of one joint; every seventh has no height.
    fn data(rows: std::ops::Range<usize>) -> Dataset {
        let n = rows.len();
        Dataset {
            joints: vec![rows.clone().map(|k| (k as f64).sin()).collect()],
            position: rows.map(|k| [k as f64, 0.0, if k % 7 == 0 { f64::NAN } else { 1.0 }]).collect(),
            orientation: vec![None; n],
            position_sd: vec![[f64::NAN; 3]; n],
            orientation_sd: vec![[f64::NAN; 3]; n],
            target: vec![None; n],
            visit: (0..n).collect(),
            load: vec![Load::None; n],
            time: vec![0.0; n],
            approach: vec![vec![0.0; n]],
            ..Dataset::default()
        }
    }

    #[test]
    fn the_sample_of_the_whole_is_that_of_its_parts() {
        let whole = Sample::of(&data(0..5000));
        assert_eq!((whole.rows().len(), whole.drawn_from()), (KEPT, 5000));
        let mut parts = Sample::default();
        for part in [0..17, 17..1500, 1500..5000] {
            parts.widen(&Sample::of(&data(part)));
        }
        assert_eq!(parts, whole);
        assert_ne!(parts, Sample::of(&data(0..4999)));
        // Every part of the data has its part of the sample: 500 ± 16 (one standard deviation) of the first half.
        let first = whole.rows().position.iter().filter(|p| p[0] < 2500.0).count();
        assert!((420..580).contains(&first), "{first}");
    }

    #[test]
    fn rows_without_a_measurement_are_left_out() {
        let mut few = data(0..10);
        few.position[3] = [f64::NAN; 3];
        let sample = Sample::of(&few);
        assert_eq!((sample.rows().len(), sample.drawn_from()), (9, 9));
        assert!(sample.rows().position.iter().all(|p| p[0] != 3.0));
    }
}
