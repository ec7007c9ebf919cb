//! The inputs on which a model was fitted: beyond them it extrapolates.

use super::sample::Sample;
use crate::{Dataset, RobotPoint};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Load, TargetId};

/// A closed range.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Smallest value seen.
    pub lower: f64,
    /// Largest value seen.
    pub upper: f64,
}

impl Interval {
    /// Of these values; none when there are none.
    pub fn of(values: impl Iterator<Item = f64>) -> Option<Interval> {
        values.fold(None, |range, v| {
            Some(match range {
                None => Interval { lower: v, upper: v },
                Some(r) => Interval { lower: r.lower.min(v), upper: r.upper.max(v) },
            })
        })
    }

    /// How far a value lies outside, zero inside.
    pub fn beyond(&self, value: f64) -> f64 {
        (self.lower - value).max(value - self.upper).max(0.0)
    }
}

/// Ranges of joints, payload, time and channels in the data of a fit, the targets measured, and a sample of its rows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Domain {
    /// One a movable joint, rad or m.
    pub joints: Vec<Interval>,
    /// Mass carried, kg; absent when no payload was declared.
    pub payload: Option<Interval>,
    /// s; absent without a time column. With `by_order` numbers of pose measurements.
    pub time: Option<Interval>,
    /// Whether the order of the rows stands for the time ([`Dataset::ordered`]); never so of a fit from a file.
    pub by_order: bool,
    /// One a channel.
    pub channels: Vec<Interval>,
    /// The targets of which a position was measured, ascending; none is the tool's origin. Empty: not recorded.
    pub targets: Vec<Option<TargetId>>,
    /// Rows of the data; empty: not recorded.
    pub sample: Sample,
}

impl Domain {
    /// Of a data set.
    pub fn of(data: &Dataset) -> Self {
        let ranges = |columns: &[Vec<f64>]| {
            columns.iter().filter_map(|column| Interval::of(column.iter().copied())).collect()
        };
        let masses = data.load.iter().filter_map(|load| match load {
            Load::Payload(payload) => Some(payload.mass),
            _ => None,
        });
        Domain {
            joints: ranges(&data.joints),
            payload: Interval::of(masses),
            time: if data.schema.time { Interval::of(data.time.iter().copied()) } else { None },
            by_order: data.by_order,
            channels: ranges(&data.channels),
            targets: sorted(
                (0..data.len())
                    .filter(|&row| data.seen(row).position.contains(&true))
                    .flat_map(|row| [Some(data.target[row]), data.meets(row).map(RobotPoint::target)])
                    .flatten()
                    .collect(),
            ),
            sample: Sample::of(data),
        }
    }

    /// Widens it to what another one has seen as well.
    pub fn widen(&mut self, other: &Domain) {
        let both = |a: Option<Interval>, b: Option<Interval>| match (a, b) {
            (Some(a), Some(b)) => Some(Interval { lower: a.lower.min(b.lower), upper: a.upper.max(b.upper) }),
            (a, b) => a.or(b),
        };
        let all = |to: &mut Vec<Interval>, from: &[Interval]| {
            if to.is_empty() {
                to.extend_from_slice(from);
            }
            to.iter_mut().zip(from).for_each(|(a, b)| {
                *a = Interval { lower: a.lower.min(b.lower), upper: a.upper.max(b.upper) };
            });
        };
        all(&mut self.joints, &other.joints);
        all(&mut self.channels, &other.channels);
        self.payload = both(self.payload, other.payload);
        self.time = both(self.time, other.time);
        self.targets.extend_from_slice(&other.targets);
        self.targets = sorted(std::mem::take(&mut self.targets));
        self.sample.widen(&other.sample);
    }
}

/// Each target once, in order.
fn sorted(mut targets: Vec<Option<TargetId>>) -> Vec<Option<TargetId>> {
    targets.sort_unstable_by_key(|target| target.map_or(0, |t| t.0 + 1));
    targets.dedup();
    targets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_widen_to_the_whole() {
        let of = |lower: f64, upper: f64| Interval { lower, upper };
        let mut whole = Domain::default();
        whole.widen(&Domain { joints: vec![of(0.0, 1.0)], time: Some(of(5.0, 6.0)), ..Domain::default() });
        whole.widen(&Domain {
            joints: vec![of(-1.0, 0.5)],
            payload: Some(of(2.0, 2.0)),
            ..Domain::default()
        });
        assert_eq!(whole.joints, [of(-1.0, 1.0)]);
        assert_eq!((whole.time, whole.payload), (Some(of(5.0, 6.0)), Some(of(2.0, 2.0))));
    }
}
