//! Rows that lie outside what all others scatter by, and targets whose names were swapped in some of them.
//!
//! Errors that nobody declared make the tail of t ([`super::constants`]) heavier than normal, and of no known law; but a tail has no gap. Above the
//! largest of the others, x_{k+1}, it falls as a power, P(t > x) ~ x^{−α}, with Hill's estimate of α from the upper tenth of them; by chance the k
//! largest are then all g times x_{k+1} with
//!
//! ```text
//! p = g^{−α k},      g = x_k / x_{k+1},      1/α = mean ln(x_i / x_{k+1+m})  of the m next
//! ```
//!
//! α is taken one standard error (α/√m) on the heavy side. k counts visits, since rows of one visit may share what sets them apart, and only those
//! that are less than twice as far as x_k: what lies far beyond is outside by itself.
//! Source: Hill (1975), docs/references.md; the law of the ratios is Rényi's representation of order statistics.

use super::cause::{Cause, Suspicion};
use super::constants::{Constants, Judged};
use std::collections::BTreeMap;
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, TargetId};

/// Chance of a gap below which rows are outside. Odds of one in fifty, for a warning that changes nothing, against a tail that is taken heavier than
/// it looks: tests/all/suspicions.rs counts over clean campaigns.
const CHANCE: f64 = 0.02;
/// No row is outside that is nearer than so many deviations, or not so many times as far as the farthest of the others.
const DEVIATIONS: f64 = 5.0;
const GAP: f64 = 2.0;
/// Share of the others, and least number of them, that show how their tail falls.
const TAIL: f64 = 0.1;
const TAIL_ROWS: usize = 5;
/// Shares of the robot's length: nothing below this is worth a word, in a calibration by any instrument.
const LEAST: f64 = 1e-4;
/// Rows below which nothing is known of a tail.
const FEWEST: usize = 20;
/// Rows of a point of unknown place that determine it, at the least, with one to spare.
const PLACED: usize = 3;
/// More rows than this share are no outliers.
const MOST: f64 = 0.3;
/// Under its right name a row has no more than this share of its distance, and is within so many deviations of the others.
const NAMED_RIGHT: f64 = 0.25;
const BACK: f64 = 8.0;

/// What is wrong with single rows; `gross` are known to lie far out and take no part in the first fit. None where too little was measured for
/// a fit.
pub(super) fn outlying(chain: &Chain, data: &Dataset, gross: &[usize]) -> Option<Vec<Suspicion>> {
    let mut bare = data.clone();
    bare.orientation.fill(None);
    let whole = |row: &usize| bare.whole_position(*row);
    let all: Vec<usize> = (0..bare.len()).filter(whole).collect();
    if all.len() < FEWEST {
        return None;
    }
    let without = |rows: &[usize]| -> Vec<usize> {
        let mut out = vec![false; bare.len()];
        rows.iter().for_each(|&row| out[row] = true);
        all.iter().copied().filter(|&row| !out[row]).collect()
    };
    let least = LEAST * chain.characteristic_length();
    let (mut constants, mut outside, mut bulk) = once(chain, &bare, &without(gross), &all, least)?;
    if !outside.is_empty() {
        // Where base and targets were looked for, the rows outside have moved them.
        let rows: Vec<usize> = outside.iter().map(|o| o.row).collect();
        if let Some(again) = once(chain, &bare, &without(&rows), &all, least)
            && !again.1.is_empty()
        {
            (constants, outside, bulk) = again;
        }
    }
    let mut found = Vec::new();
    let mut rest = outside.clone();
    for ((a, b), rows) in swapped(chain, &bare, &constants, &outside, bulk.most) {
        let before = outside.iter().filter(|o| rows.contains(&o.row)).map(|o| o.distance).fold(0.0, f64::max);
        rest.retain(|o| !rows.contains(&o.row));
        found.push(Suspicion { cause: Cause::SwappedLabels { a, b, rows }, before, after: bulk.rms });
    }
    rest.sort_by(|a, b| b.distance.total_cmp(&a.distance).then(a.row.cmp(&b.row)));
    if let Some(first) = rest.first() {
        let before = first.distance;
        let rows = rest.iter().map(|o| o.row).collect();
        found.push(Suspicion { cause: Cause::StrayRows { rows }, before, after: bulk.rms });
    }
    Some(found)
}

/// The rows that lie inside: RMS and largest distance, m.
#[derive(Clone, Copy)]
struct Bulk {
    rms: f64,
    most: f64,
}

/// A fit to these rows, what of all rows lies outside, and the rest.
fn once<'a>(
    chain: &Chain,
    data: &'a Dataset,
    fitted: &[usize],
    all: &[usize],
    least: f64,
) -> Option<(Constants<'a>, Vec<Judged>, Bulk)> {
    let constants = Constants::fit(chain, data, fitted)?;
    let rows = judgeable(chain, data, fitted, all);
    if rows.len() < FEWEST {
        return None;
    }
    let judged = constants.judge(&rows)?;
    let (outside, rest) = parted(data, judged, least);
    let rms = (rest.iter().map(|j| j.distance.powi(2)).sum::<f64>() / rest.len().max(1) as f64).sqrt();
    let most = rest.iter().map(|j| j.distance).fold(0.0, f64::max);
    Some((constants, outside, Bulk { rms, most }))
}

/// Rows that others determine: of a tool or a target of unknown place a few of the fitted rows are needed to know where it is.
fn judgeable(chain: &Chain, data: &Dataset, fitted: &[usize], all: &[usize]) -> Vec<usize> {
    let point = |row: usize| (data.target[row].map(|target| target.0), data.tool(row).0);
    let known = |(target, tool): (Option<usize>, usize)| {
        target.is_none_or(|target| chain.targets()[target].known) && chain.tools()[tool].placed.known
    };
    let mut count = BTreeMap::new();
    fitted.iter().for_each(|&row| *count.entry(point(row)).or_insert(0) += 1);
    let placed = |row: usize| known(point(row)) || count.get(&point(row)).is_some_and(|&rows| rows >= PLACED);
    all.iter().copied().filter(|&row| placed(row)).collect()
}

/// Rows outside, and the others.
fn parted(data: &Dataset, mut judged: Vec<Judged>, least: f64) -> (Vec<Judged>, Vec<Judged>) {
    judged.sort_by(|a, b| b.square.total_cmp(&a.square).then(a.row.cmp(&b.row)));
    let n = judged.len();
    let most = ((MOST * n as f64) as usize).min(n.saturating_sub(FEWEST / 2));
    let far = |j: &&Judged| j.square > DEVIATIONS * DEVIATIONS && j.distance > least;
    let beyond = judged.iter().take(most).take_while(far).count();
    let outside = |&k: &usize| {
        let gap = (judged[k - 1].square / judged[k].square.max(f64::MIN_POSITIVE)).sqrt();
        // Those far beyond are outside by themselves, and are no measure of the nearer ones.
        let near = |j: &&Judged| j.square < GAP * GAP * judged[k - 1].square;
        let near = judged[..k].iter().filter(near).chain([&judged[k - 1]]);
        let mut visits: Vec<usize> = near.map(|j| data.visit[j.row]).collect();
        visits.sort_unstable();
        visits.dedup();
        gap > GAP && -(gap.ln() * index(&judged[k..]) * visits.len() as f64) < CHANCE.ln()
    };
    let count = (1..=beyond).rev().find(outside).unwrap_or(0);
    let rest = judged.split_off(count);
    (judged, rest)
}

/// α of the tail of these, the farthest first; on the heavy side.
fn index(rest: &[Judged]) -> f64 {
    let m = ((TAIL * rest.len() as f64) as usize).max(TAIL_ROWS).min(rest.len().saturating_sub(1));
    let behind = rest[m].square.max(f64::MIN_POSITIVE);
    let mean = rest[..m].iter().map(|j| 0.5 * (j.square / behind).ln()).sum::<f64>() / m.max(1) as f64;
    (1.0 - 1.0 / (m.max(2) as f64).sqrt()) / mean.max(1e-3)
}

/// Pairs of targets, and the rows that come back to the others when their name is that of the other one.
fn swapped(
    chain: &Chain,
    data: &Dataset,
    constants: &Constants<'_>,
    outside: &[Judged],
    farthest: f64,
) -> BTreeMap<(usize, usize), Vec<usize>> {
    let mut pairs: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    let rows: Vec<usize> = outside.iter().map(|o| o.row).filter(|&row| data.target[row].is_some()).collect();
    if rows.is_empty() || chain.described_targets().len() < 2 {
        return pairs;
    }
    // Under which other names a row comes back to the others, and how many rows of each pair do.
    let good = (BACK * constants.scale()).max(GAP * farthest);
    let mut names: BTreeMap<usize, Vec<(usize, usize)>> = BTreeMap::new();
    let mut votes: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for other in 0..chain.described_targets().len() {
        let Some(judged) = constants.judge_as(&rows, Some(TargetId(other))) else { continue };
        for (j, o) in judged.iter().zip(outside.iter().filter(|o| data.target[o.row].is_some())) {
            if let Some(own) = data.target[j.row].filter(|own| own.0 != other)
                && j.distance < NAMED_RIGHT * o.distance
                && j.distance < good
            {
                let pair = (own.0.min(other), own.0.max(other));
                names.entry(j.row).or_default().push(pair);
                *votes.entry(pair).or_default() += 1;
            }
        }
    }
    // Targets may stand near each other: the pair that most rows speak for.
    for (row, of_row) in names {
        let most =
            of_row.iter().copied().max_by_key(|pair| (votes.get(pair).copied(), std::cmp::Reverse(*pair)));
        most.into_iter().for_each(|pair| pairs.entry(pair).or_default().push(row));
    }
    pairs.values_mut().for_each(|rows| rows.sort_unstable());
    pairs
}
