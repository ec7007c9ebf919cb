//! The inputs on which a model was fitted: beyond them it extrapolates.

use crate::Dataset;
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Conditions, Load};

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

/// Ranges of joints, payload, time and channels in the data of a fit.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Domain {
    /// One a movable joint, rad or m.
    pub joints: Vec<Interval>,
    /// Mass carried, kg; absent when no payload was declared.
    pub payload: Option<Interval>,
    /// s; absent without a time column.
    pub time: Option<Interval>,
    /// One a channel.
    pub channels: Vec<Interval>,
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
            channels: ranges(&data.channels),
        }
    }

    /// True when every joint lies within the range that was seen.
    pub fn contains_joints(&self, conditions: &Conditions) -> bool {
        self.joints.iter().zip(&conditions.joints).all(|(range, &q)| range.beyond(q) <= 0.0)
    }
}
