//! Which mistake of convention, undone, lets the positions fit.
//!
//! Every variant is placed by turns of two closed forms ([`registration`](crate::suspicion)), which costs a hundredth of a placement; those
//! that look better than the description as it is are placed exactly and judged.

use super::lengths;
use super::misread::{Misread, Misreading, better, explains};
use super::placed::{flanges, left, some};
use super::variants;
use crate::suspicion::registration::{self, Offset, Point};
use truepose_errormodel::Dataset;
use truepose_kinematics::Chain;

/// Rows on which variants are compared.
const ROWS: usize = 120;
/// Variants that are placed exactly.
const TRIED: usize = 6;

/// The mistake that, undone, leaves a fifth or less.
pub(super) fn misread(chain: &Chain, data: &Dataset) -> Option<Misread> {
    let rows = some(data, ROWS);
    let before = left(chain, &rows)?;
    let oriented = rows.orientation.iter().any(Option::is_some);
    let mut promising: Vec<(f64, Misreading)> = Vec::new();
    let asis = roughly(chain, &rows);
    for what in variants::readings(chain, oriented) {
        let (chain, rows) = with(&what, chain, &rows);
        let after = roughly(&chain, &rows);
        if after < asis {
            promising.push((after, what));
        }
    }
    promising.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Option<Misread> = None;
    for (_, what) in promising.into_iter().take(TRIED) {
        let (chain, rows) = with(&what, chain, &rows);
        let Some(after) = left(&chain, &rows) else { continue };
        // Undone, the mistake leaves a robot that is worth a calibration.
        if explains(before, after, chain.characteristic_length()) {
            better(&mut best, Misread { what, before, after });
        }
    }
    // A length of its own value fits more than a convention, so it comes last.
    if let Some(found) = lengths::misread(chain, &rows, before) {
        better(&mut best, found);
    }
    best
}

/// Robot and rows with a mistake undone.
fn with(what: &Misreading, chain: &Chain, rows: &Dataset) -> (Chain, Dataset) {
    let mut rows = rows.clone();
    let other = variants::undone(what, chain);
    if other.is_none() {
        variants::undo_rows(what, &mut rows);
        rows = some(&rows, ROWS);
    }
    (other.unwrap_or_else(|| chain.clone()), rows)
}

/// RMS of the positions with base and every target where alternating steps bring them, m.
fn roughly(chain: &Chain, rows: &Dataset) -> f64 {
    let tool = chain.tool().pose;
    let open = |at| Offset { at, known: false };
    let mut offsets = vec![open(tool.translation)];
    offsets.extend(chain.targets().iter().map(|target| open(tool.apply(&target.position))));
    let point = |(row, flange)| Point {
        measured: rows.measured_position(row),
        flange,
        target: rows.target[row].map_or(0, |t| t.0 + 1),
    };
    let points: Vec<Point> = flanges(chain, rows).into_iter().enumerate().map(point).collect();
    registration::anywhere(&points, &offsets)
}
