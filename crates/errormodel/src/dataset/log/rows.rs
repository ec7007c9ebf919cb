//! The standstills of a log as a table of measurements: one row for each target that was measured in each.

use super::streams::Streams;
use crate::{Dataset, approach_from_order};
use nalgebra::{Matrix4, SymmetricEigen, Vector4};
use std::collections::BTreeMap;

/// What is a standstill.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DwellOptions {
    /// How far turning joints may move in it, rad, and slides, m.
    pub still: [f64; 2],
    /// How long it lasts at least, s.
    pub dwell: f64,
    /// Time after its beginning that is left out, s.
    pub settle: f64,
    /// By how much the clock of the instrument is late, s; found from the data where none is given.
    pub lag: Option<f64>,
}

impl Default for DwellOptions {
    fn default() -> Self {
        DwellOptions { still: [2e-4, 2e-4], dwell: 0.5, settle: 0.2, lag: None }
    }
}

/// Measurements at the standstills of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Segmented {
    /// One row for each target in each standstill: means of joints, position, orientation and channels.
    pub data: Dataset,
    /// Rows of the log that each row is the mean of.
    pub samples: Vec<usize>,
    /// Standstills without a position.
    pub unseen: usize,
    /// The lag that was used, s.
    pub lag: f64,
    /// The lag that was found, s, and the correlation of the speeds there.
    pub found: (f64, f64),
}

/// Correlation from which on the lag that was found is used.
const TRUSTED: f64 = 0.5;

impl Dataset {
    /// The standstills of a log whose rows have a time; `slides`: which joints are prismatic.
    pub fn standstills(&self, slides: &[bool], options: &DwellOptions) -> Segmented {
        let mut order: Vec<usize> = (0..self.len()).collect();
        order.sort_by(|&a, &b| self.time[a].total_cmp(&self.time[b]));
        // Rows of one instant are one sample of the joints.
        let mut instants = order.clone();
        instants.dedup_by(|b, a| self.time[*a] >= self.time[*b]);
        let seen: Vec<usize> =
            order.iter().copied().filter(|&row| self.position[row].iter().all(|v| v.is_finite())).collect();
        let time = |rows: &[usize]| -> Vec<f64> { rows.iter().map(|&row| self.time[row]).collect() };
        let joints: Vec<Vec<f64>> =
            self.joints.iter().map(|column| instants.iter().map(|&row| column[row]).collect()).collect();
        let (joint_times, position_times) = (time(&instants), time(&seen));
        let positions: Vec<[f64; 3]> = seen.iter().map(|&row| self.position[row]).collect();
        let streams = Streams {
            joint_times: &joint_times,
            joints: &joints,
            position_times: &position_times,
            positions: &positions,
        };
        let still: Vec<f64> = slides.iter().map(|&slide| options.still[usize::from(slide)]).collect();
        let found = streams.standstills(&still, options.dwell);
        let lag = options.lag.unwrap_or(if found.lag.1 >= TRUSTED { found.lag.0 } else { 0.0 });
        let mut rows: Vec<Row> = Vec::new();
        let mut unseen = 0;
        for (visit, [first, last]) in found.samples.iter().enumerate() {
            let within = [joint_times[*first], joint_times[*last]];
            let from = position_times.partition_point(|t| t - lag < within[0] + options.settle);
            let to = position_times.partition_point(|t| t - lag <= within[1]);
            let mut of_target: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
            for &row in seen.get(from..to).unwrap_or_default() {
                let target = self.target[row].map_or(0, |target| target.0 + 1);
                of_target.entry(target).or_default().push(row);
            }
            unseen += usize::from(of_target.is_empty());
            rows.extend(of_target.into_values().map(|measured| Row {
                visit,
                joints: instants[*first..=*last].to_vec(),
                measured,
                time: 0.5 * (within[0] + within[1]),
            }));
        }
        Segmented {
            samples: rows.iter().map(|row| row.measured.len()).collect(),
            data: self.averaged(&rows),
            unseen,
            lag,
            found: found.lag,
        }
    }

    fn averaged(&self, rows: &[Row]) -> Dataset {
        let firsts: Vec<usize> = rows.iter().map(|row| row.measured[0]).collect();
        let mut made = self.select(&firsts);
        for (k, row) in rows.iter().enumerate() {
            for (into, column) in made.joints.iter_mut().zip(&self.joints) {
                into[k] = mean(row.joints.iter().map(|&row| column[row]));
            }
            for (into, column) in made.channels.iter_mut().zip(&self.channels) {
                into[k] = mean(row.joints.iter().map(|&row| column[row]).filter(|v| v.is_finite()));
            }
            made.position[k] =
                [0, 1, 2].map(|axis| mean(row.measured.iter().map(|&row| self.position[row][axis])));
            made.orientation[k] = mean_rotation(row.measured.iter().map(|&row| self.orientation[row]));
            made.time[k] = row.time;
        }
        let mut numbers: Vec<usize> = rows.iter().map(|row| row.visit).collect();
        numbers.dedup();
        made.visit = rows.iter().map(|row| numbers.partition_point(|&visit| visit < row.visit)).collect();
        made.record = None;
        made.line = Vec::new();
        made.schema.approach = false;
        made.approach = approach_from_order(&made);
        made
    }
}

/// A row to be: rows of the log for its joints and for what was measured.
struct Row {
    visit: usize,
    joints: Vec<usize>,
    measured: Vec<usize>,
    time: f64,
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), v| (sum + v, count + 1));
    sum / count as f64
}

/// Mean of rotations: the eigenvector of the largest eigenvalue of the sum of their outer products (Markley and others, 2007); none where one is
/// missing.
fn mean_rotation(each: impl Iterator<Item = Option<[f64; 4]>>) -> Option<[f64; 4]> {
    let mut sum = Matrix4::zeros();
    for quaternion in each {
        let q = Vector4::from(quaternion?);
        sum += q * q.transpose();
    }
    let eigen = SymmetricEigen::new(sum);
    let largest = eigen.eigenvalues.imax();
    let mean = eigen.eigenvectors.column(largest).normalize();
    let sign = if mean[0] < 0.0 { -1.0 } else { 1.0 };
    Some([mean[0], mean[1], mean[2], mean[3]].map(|v| sign * v))
}
