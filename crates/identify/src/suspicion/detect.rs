//! What may be wrong with a table as a whole: columns swapped, a unit, an order, a sign, rows that belong to each other.
//!
//! A calibration moves a robot's prediction by millimetres. Where the robot as described misses the measured positions by
//! a good part of its own size, however its base is placed, and one of the mistakes that people make, undone, brings that
//! down to a fifth or less, that mistake is the likely cause. Where the table as a whole is right, single rows are judged by a robust fit of
//! constant errors. Nothing is changed: it is said.

use super::cause::{Cause, Suspicion};
use super::registration::{self, Offset, Point};
use super::{decisive, hypotheses, outlying};
use crate::place;
use nalgebra::Vector3;
use std::collections::BTreeSet;
use truepose_errormodel::{Dataset, Visits, configurations};
use truepose_kinematics::{Chain, Placed};

/// Rows that are looked at.
const ROWS: usize = 600;
/// Configurations below which a registration fits anything.
const CONFIGURATIONS: usize = 6;
/// A registration that leaves less than this share of the robot's length is none of these mistakes.
const NEGLIGIBLE: f64 = 2e-3;
/// Undone, a mistake leaves no more than this share of what it left.
const GAIN: f64 = 0.2;
/// Undone, a mistake leaves no more than this share of the robot's length.
const GOOD: f64 = 0.02;
/// A base that is off by more than this share of the robot's length is elsewhere.
const ELSEWHERE: f64 = 0.1;

/// A row in which a mistake is undone lies within this many times the RMS of the others.
const BACK: f64 = 5.0;

/// A row that is farther off than this many times what nine tenths of the rows are is a stray one.
const STRAY: f64 = 12.0;

/// The likeliest mistake of a table, if there is any: the first of [`suspicions`].
pub fn suspicion(chain: &Chain, data: &Dataset) -> Option<Suspicion> {
    suspicions(chain, data).into_iter().next()
}

/// What looks wrong with a table: one mistake about all of it; or the rows that lie far from where the others say, those first that do so because
/// the names of two targets are swapped in them.
pub fn suspicions(chain: &Chain, data: &Dataset) -> Vec<Suspicion> {
    let explained = |found: Suspicion| match &found.cause {
        Cause::StrayRows { rows } => in_some_rows(chain, data, rows).unwrap_or_else(|| vec![found.clone()]),
        _ => vec![found],
    };
    unexplained(chain, data).into_iter().flat_map(explained).collect()
}

/// The same, with rows that lie far off as no more than that.
fn unexplained(chain: &Chain, data: &Dataset) -> Vec<Suspicion> {
    let Some(whole) = of_the_whole(chain, data) else { return Vec::new() };
    match whole {
        Some(found) => match &found.cause {
            Cause::StrayRows { rows } => outlying::outlying(chain, data, rows)
                .filter(|more| !more.is_empty())
                .unwrap_or_else(|| vec![found.clone()]),
            Cause::BaseElsewhere => {
                let rows = outlying::outlying(chain, data, &[]).unwrap_or_default();
                std::iter::once(found).chain(rows).collect()
            }
            _ => vec![found],
        },
        None => outlying::outlying(chain, data, &[]).unwrap_or_default(),
    }
}

/// What is wrong with all of a table, or rows that are grossly so; none where too little was measured to say.
fn of_the_whole(chain: &Chain, data: &Dataset) -> Option<Option<Suspicion>> {
    if data.validate(chain).is_err()
        || configurations(data).iter().max().is_none_or(|last| last + 1 < CONFIGURATIONS)
    {
        return None;
    }
    let sampled = Sample::of(chain, data)?;
    let base = chain.base();
    let length = chain.characteristic_length();
    let asis = sampled.points(None);
    let mut free = registration::anywhere(&asis, &sampled.offsets);
    if !free.is_finite() || free >= NEGLIGIBLE * length {
        // Unknown tool and targets are found by a search of its own, where a registration rests elsewhere.
        free = free.min(sampled.placed(data).unwrap_or(f64::INFINITY));
    }
    let fixed = base.known.then(|| registration::at(&asis, &sampled.offsets, &base.pose));
    if !free.is_finite() {
        return None;
    }
    if free < NEGLIGIBLE * length {
        // The shape is right: only the place of the base can be wrong, or a few rows.
        return Some(
            fixed
                .filter(|fixed| *fixed > ELSEWHERE * length && sampled.placeable())
                .map(|before| Suspicion { cause: Cause::BaseElsewhere, before, after: free })
                .or_else(|| stray(&sampled, length)),
        );
    }
    if let Some(found) = stray(&sampled, length) {
        return Some(Some(found));
    }
    let mut best: Option<(f64, f64, Cause)> = None;
    for cause in hypotheses::causes(chain) {
        let points = sampled.points(Some(&cause));
        let after = match cause {
            // The first rows have no visit before.
            Cause::StaleJoints { .. } => registration::without_strays(&points, &sampled.offsets).0,
            _ => registration::anywhere(&points, &sampled.offsets),
        };
        if !((after < GAIN * free && after < GOOD * length) || decisive(free, after, length)) {
            continue;
        }
        // Of mirror images, which are all alike for a base that may stand anywhere, the one with the base where it is declared.
        let told = if base.known { registration::at(&points, &sampled.offsets, &base.pose) } else { after };
        let better = best.as_ref().is_none_or(|(least, least_told, _)| {
            after < 0.8 * least || (after < 1.25 * least && told < 0.8 * least_told)
        });
        if better {
            best = Some((after, told, cause));
        }
    }
    Some(best.map(|(after, _, cause)| Suspicion { cause, before: free, after }))
}

/// Of rows that lie far off, those that come back to the others when one mistake is undone in them, and the rest; none where too few do.
fn in_some_rows(chain: &Chain, data: &Dataset, stray: &[usize]) -> Option<Vec<Suspicion>> {
    let far: BTreeSet<usize> = stray.iter().copied().collect();
    let usable = |row: &usize| data.whole_position(*row) && !far.contains(row);
    let others = Sample::of_rows(chain, data, &(0..data.len()).filter(usable).collect::<Vec<_>>())?;
    let here = Sample::made(chain, data, far.iter().copied())?;
    let (rms, before) = registration::distances(&others.points(None), &here.points(None), &others.offsets);
    let good = f64::max(BACK * rms, NEGLIGIBLE * chain.characteristic_length());
    let mut best: Option<(usize, f64, Cause, Vec<bool>)> = None;
    for cause in hypotheses::causes(chain) {
        if matches!(cause, Cause::StaleJoints { .. }) {
            continue;
        }
        let after =
            registration::distances(&others.points(None), &here.points(Some(&cause)), &others.offsets).1;
        let back: Vec<bool> = after.iter().zip(&before).map(|(a, b)| *a < good && *a < GAIN * b).collect();
        let count = back.iter().filter(|back| **back).count();
        let left = after.iter().zip(&back).filter(|(_, back)| **back).map(|(a, _)| a * a).sum::<f64>();
        let left = (left / count.max(1) as f64).sqrt();
        // One row alone is turned by some change or other; a unit is no such change.
        let enough = if matches!(cause, Cause::PositionUnit { .. }) { 1 } else { 3 };
        let more =
            best.as_ref().is_none_or(|(most, least, ..)| count > *most || count == *most && left < *least);
        if count >= enough && 2 * count >= far.len() && more {
            best = Some((count, left, cause, back));
        }
    }
    let (_, after, mistake, back) = best?;
    let farthest = |of: bool| {
        let of = before.iter().zip(&back).filter(|(_, back)| **back == of);
        of.map(|(before, _)| *before).fold(0.0, f64::max)
    };
    let part = |of: bool| -> Vec<usize> {
        far.iter().zip(&back).filter(|(_, back)| **back == of).map(|(row, _)| *row).collect()
    };
    let cause = Cause::InSomeRows { rows: part(true), mistake: Box::new(mistake) };
    let mut all = vec![Suspicion { cause, before: farthest(true), after }];
    let mut rest: Vec<usize> = part(false);
    if !rest.is_empty() {
        let order = |row: &usize| stray.iter().position(|known| known == row);
        rest.sort_by_key(order);
        all.push(Suspicion { cause: Cause::StrayRows { rows: rest }, before: farthest(false), after: rms });
    }
    Some(all)
}

/// Rows far from where the others say, of those that are looked at.
fn stray(sampled: &Sample<'_>, length: f64) -> Option<Suspicion> {
    let points = sampled.points(None);
    let (kept, distances) = registration::without_strays(&points, &sampled.offsets);
    let mut sorted = distances.clone();
    sorted.sort_by(f64::total_cmp);
    let most = sorted[(sorted.len() - 1) * 9 / 10];
    let limit = f64::max(STRAY * most, NEGLIGIBLE * length);
    let mut rows: Vec<(f64, usize)> = distances
        .iter()
        .zip(&sampled.rows)
        .filter(|(d, _)| **d > limit)
        .map(|(d, row)| (*d, row.number))
        .collect();
    rows.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let farthest = rows.first()?.0;
    let rows = rows.into_iter().map(|r| r.1).collect();
    Some(Suspicion { cause: Cause::StrayRows { rows }, before: farthest, after: kept })
}

/// Rows of a table, evenly taken, with what a registration needs of them.
struct Sample<'a> {
    chain: &'a Chain,
    /// Without base and tool.
    bare: Chain,
    offsets: Vec<Offset>,
    /// Measured position, joints, target (0: the tool's origin), joints of the visit after and before.
    rows: Vec<Row>,
}

struct Row {
    /// In the table, from 0.
    number: usize,
    measured: Vector3<f64>,
    joints: Vec<f64>,
    next: Option<Vec<f64>>,
    previous: Option<Vec<f64>>,
    target: usize,
}

impl<'a> Sample<'a> {
    fn of(chain: &'a Chain, data: &Dataset) -> Option<Self> {
        let whole = |row: &usize| data.whole_position(*row);
        Self::of_rows(chain, data, &(0..data.len()).filter(whole).collect::<Vec<_>>())
    }

    /// Of these rows, evenly taken; none where they are too few.
    fn of_rows(chain: &'a Chain, data: &Dataset, usable: &[usize]) -> Option<Self> {
        let step = usable.len().div_ceil(ROWS).max(1);
        Self::made(chain, data, usable.iter().copied().step_by(step))
            .filter(|sampled| sampled.rows.len() >= CONFIGURATIONS)
    }

    /// RMS of its rows with the best base, and the best tool and targets where these are unknown, m.
    fn placed(&self, data: &Dataset) -> Option<f64> {
        let base = Placed { known: false, ..*self.chain.base() };
        let chain = self.chain.clone().with_base(base).ok()?;
        let rows: Vec<usize> = self.rows.iter().map(|row| row.number).collect();
        place(&chain, &data.select(&rows)).ok().map(|found| found.rms)
    }

    /// Of all these rows.
    fn made(chain: &'a Chain, data: &Dataset, chosen: impl Iterator<Item = usize>) -> Option<Self> {
        if !chain.is_serial() {
            return None;
        }
        let bare =
            chain.clone().with_base(Placed::default()).and_then(|c| c.with_tool(Placed::default())).ok()?;
        let visits = Visits::of(data).rows;
        let q = |row: usize| data.joints.iter().map(|column| column[row]).collect::<Vec<f64>>();
        let of_visit = |visit: Option<usize>| {
            visit.and_then(|v| visits.get(v)).and_then(|rows| rows.first()).map(|&r| q(r))
        };
        let rows: Vec<Row> = chosen
            .map(|row| Row {
                number: row,
                measured: data.measured_position(row),
                joints: q(row),
                next: of_visit(data.visit[row].checked_add(1)),
                previous: of_visit(data.visit[row].checked_sub(1)),
                target: data.target[row].map_or(0, |t| t.0 + 1),
            })
            .collect();
        let tool = chain.tool();
        let mut offsets = vec![Offset { at: tool.pose.translation, known: tool.known }];
        offsets.extend(
            chain
                .targets()
                .iter()
                .map(|t| Offset { at: tool.pose.apply(&t.position), known: t.known && tool.known }),
        );
        Some(Sample { chain, bare, offsets, rows })
    }

    /// The points with a cause undone.
    fn points(&self, cause: Option<&Cause>) -> Vec<Point> {
        let one = |row: &Row| {
            let mut q = match cause {
                Some(Cause::StaleJoints { late: true }) => row.next.clone()?,
                Some(Cause::StaleJoints { late: false }) => row.previous.clone()?,
                _ => row.joints.clone(),
            };
            let (mut measured, mut target) = (row.measured, row.target);
            if let Some(cause) = cause {
                // Columns hold the controller's values.
                self.chain.joints_to_controller(&mut q);
                hypotheses::joints(cause, self.chain, &mut q);
                self.chain.joints_from_controller(&mut q);
                measured = hypotheses::position(cause, measured);
                target = hypotheses::target(cause, target);
            }
            Some(Point { measured, flange: self.bare.forward(&q), target })
        };
        self.rows.iter().filter_map(one).collect()
    }

    /// Whether the points lie in more than a line, so that they place a base.
    fn placeable(&self) -> bool {
        let n = self.rows.len().max(1) as f64;
        let mean = self.rows.iter().map(|r| r.measured).sum::<Vector3<f64>>() / n;
        let spread = self
            .rows
            .iter()
            .map(|r| (r.measured - mean) * (r.measured - mean).transpose())
            .sum::<nalgebra::Matrix3<f64>>();
        let mut sizes: Vec<f64> = spread.symmetric_eigenvalues().iter().map(|v| v.max(0.0).sqrt()).collect();
        sizes.sort_by(f64::total_cmp);
        sizes[1] > 0.01 * sizes[2]
    }
}
