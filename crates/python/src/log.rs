//! Standstills in two streams, for recordings and logs.

use crate::arrays::{Given1, Given2};
use crate::error::input;
use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;
use truepose_errormodel::{Standstills, Streams};

/// First and last joint sample of each standstill, the lag of the positions, s, and the correlation of the speeds there.
type Found = (Vec<[usize; 2]>, f64, f64);

/// Standstills of joints (times × joints, at `joint_times`, s) and the lag of positions (times × 3) behind them.
#[pyfunction]
pub fn standstills(
    joint_times: Given1<'_, f64>,
    joints: Given2<'_, f64>,
    position_times: Given1<'_, f64>,
    positions: Given2<'_, f64>,
    still: f64,
    dwell: f64,
) -> PyResult<Found> {
    let (rows, columns) = (joints.as_array(), joints.shape()[1]);
    if joints.shape()[0] != joint_times.len() || positions.shape() != [position_times.len(), 3] {
        return Err(input("joints, positions and their times have different lengths"));
    }
    let joints: Vec<Vec<f64>> = (0..columns).map(|k| rows.column(k).to_vec()).collect();
    let positions: Vec<[f64; 3]> =
        positions.as_array().outer_iter().map(|row| [row[0], row[1], row[2]]).collect();
    let (joint_times, position_times) = (joint_times.as_array().to_vec(), position_times.as_array().to_vec());
    let streams = Streams {
        joint_times: &joint_times,
        joints: &joints,
        position_times: &position_times,
        positions: &positions,
    };
    let Standstills { samples, lag } = streams.standstills(&vec![still; columns], dwell);
    Ok((samples, lag.0, lag.1))
}
