//! A tool that is declared as known, and is not there.

use super::misread::{GAIN, Misread, Misreading, NEGLIGIBLE, better, explains};
use super::placed::{flanges, some};
use crate::suspicion::registration::{self, Offset, Point};
use std::f64::consts::{FRAC_PI_2, PI};
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, Pose};

/// Rows that are looked at.
const ROWS: usize = 300;

/// What is wrong with a declared tool, where the positions fit with another one; `fitted` is the RMS with the best tool, m.
pub(super) fn misread(chain: &Chain, data: &Dataset, fitted: f64) -> Option<Misread> {
    let known = chain.tool().known && chain.targets().iter().all(|target| target.known);
    if !known {
        return None;
    }
    let rows = some(data, ROWS);
    let point = |(row, flange)| Point {
        measured: rows.measured_position(row),
        flange,
        target: rows.target[row].map_or(0, |t| t.0 + 1),
    };
    let points: Vec<Point> = flanges(chain, &rows).into_iter().enumerate().map(point).collect();
    let with = |tool: &Pose| {
        let fixed = |at| Offset { at, known: true };
        let mut offsets = vec![fixed(tool.translation)];
        offsets.extend(chain.targets().iter().map(|target| fixed(tool.apply(&target.position))));
        registration::anywhere(&points, &offsets)
    };
    let tool = chain.tool().pose;
    let (before, length) = (with(&tool), chain.characteristic_length());
    if before < NEGLIGIBLE * length || fitted > GAIN * before {
        return None;
    }
    let mut best = None;
    for (what, other) in readings(&tool) {
        let after = with(&other);
        if explains(before, after, length) {
            better(&mut best, Misread { what, before, after });
        }
    }
    Some(best.unwrap_or(Misread { what: Misreading::ToolElsewhere, before, after: fitted }))
}

/// What the tool may have been meant as.
fn readings(tool: &Pose) -> Vec<(Misreading, Pose)> {
    let mut list = Vec::new();
    for (axis, angle) in [(2, FRAC_PI_2), (2, -FRAC_PI_2), (2, PI), (0, PI), (1, PI)] {
        list.push((Misreading::ToolTurned { axis, angle }, Pose::rot(axis, angle) * *tool));
    }
    for axis in 0..3 {
        let mut other = *tool;
        other.translation[axis] = -other.translation[axis];
        list.push((Misreading::ToolSign { axis }, other));
    }
    list
}
