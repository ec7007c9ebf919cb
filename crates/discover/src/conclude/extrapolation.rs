//! Errors outside of what a model was fitted to: the last part in time, and the ends of a joint's range.
//!
//! Random test poses lie between the training poses, in time and in joint space: their error is one of interpolation. Here the coefficients of
//! the declared and of the final model are estimated again without a part of the data, and that part is predicted.
//!
//! | part | pose measurements |
//! | --- | --- |
//! | [`Part::LastInTime`] | the last 30 % in time (without time: in order) of each session (and landmark), of configurations that were not measured before |
//! | [`Part::Region`] | the lowest and the highest sixth of the values of the joint with the largest standard deviation |
//!
//! The structure of the final model (effects, periods) was selected with these rows; only its coefficients do not know them.

use crate::conclude::held_out::{clusters, of_pair};
use crate::conclude::reach::{UnseenPart, UnseenRow, usual, variances};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::current::Context;
use crate::model::prepared::{with_found, without};
use std::collections::{BTreeMap, BTreeSet};
use truepose_errormodel::{Dataset, Visits, configurations};
use truepose_identify::{Fit, FitOptions, NoiseSource, Residuals, Spread, fit_again, measured};
use truepose_kinematics::JointId;

/// Share of the pose measurements that comes last. Convention.
const LAST: f64 = 0.3;
/// Share of the configurations at either end of a joint's range. Convention: together a third.
const END: f64 = 1.0 / 6.0;
/// Configurations below which an error is not told.
const FEWEST: usize = 5;
/// Pose measurements of a target, among those that are left, below which its own position is not known well enough to predict it: three
/// unknowns from fifteen observations. Convention.
const OF_TARGET: usize = 5;
/// Observations of position for each unknown that have to be left. Convention.
const OBSERVATIONS: usize = 2;

/// A part of the data that a model was not fitted to.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Part {
    /// The last 30 % in time.
    LastInTime,
    /// The ends of a joint's range.
    Region {
        /// The joint.
        joint: JointId,
        /// The values of the part are below the first or above the second, rad or m.
        outside: [f64; 2],
    },
}

/// Errors on such a part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extrapolation {
    /// Which part.
    pub part: Part,
    /// Pose measurements in it.
    pub poses: usize,
    /// 3-D position error of the declared model, m.
    pub before: Spread,
    /// 3-D position error of the final model, m.
    pub after: Spread,
    /// 95 % intervals of the RMS of both, m.
    pub ci95: Option<[[f64; 2]; 2]>,
    /// 3-D RMS of the final model where it falls back to the declared one beyond its data, m: with the scale that suits these parts best.
    pub fallen_back: Option<f64>,
}

/// Which pose measurements are predicted, and which are left out of the fit without being predicted.
struct Parted {
    part: Part,
    predicted: Vec<bool>,
    left_out: Vec<bool>,
}

/// Errors on the parts for which the data is enough, with their rows. `fits` are the declared and the final model; `out` are outliers.
pub(crate) fn extrapolations(
    context: &Context<'_>,
    fits: [&Fit; 2],
    found: &[Candidate],
    data: &Dataset,
    out: &[usize],
) -> Vec<(Extrapolation, UnseenPart)> {
    let data = without(data, out);
    let parts = [last_in_time(&data), region(context, &data)];
    let each = parts.into_iter().flatten();
    // A figure beside others: where a fit of the rest fails, there is none.
    each.filter_map(|parted| judged(context, fits, found, &data, &parted).ok().flatten()).collect()
}

fn judged(
    context: &Context<'_>,
    fits: [&Fit; 2],
    found: &[Candidate],
    data: &Dataset,
    parted: &Parted,
) -> Result<Option<(Extrapolation, UnseenPart)>, DiscoverError> {
    let kept: Vec<bool> =
        parted.predicted.iter().zip(&parted.left_out).map(|(predicted, out)| !predicted && !out).collect();
    let mut of_target = BTreeMap::<_, BTreeSet<usize>>::new();
    for row in (0..data.len()).filter(|&row| kept[data.visit[row]]) {
        of_target.entry(data.aim(row)).or_default().insert(data.visit[row]);
    }
    let known = |row: usize| of_target.get(&data.aim(row)).is_some_and(|visits| visits.len() >= OF_TARGET);
    let configuration = configurations(data);
    let part: Vec<usize> =
        (0..data.len()).filter(|&row| parted.predicted[data.visit[row]] && known(row)).collect();
    let predicted: BTreeSet<usize> = part.iter().map(|&row| configuration[data.visit[row]]).collect();
    let rows = |those: &[bool]| (0..data.len()).filter(|&row| those[data.visit[row]]).collect::<Vec<_>>();
    let rest = data.select(&rows(&kept));
    let seen: usize = (0..rest.len()).map(|row| rest.seen(row).components()).sum();
    let rank = fits[1].reduction.rank();
    if predicted.len() < FEWEST
        || Visits::of(&rest).len() < context.policy().fewest_poses
        || seen < OBSERVATIONS * rank
    {
        return Ok(None);
    }
    let part = data.select(&part);
    let mut residuals = Vec::new();
    let mut reach = (Vec::new(), 0.0);
    let all: Vec<usize> = (0..part.len()).collect();
    for (fit, found) in fits.into_iter().zip([&[], found]) {
        let options = FitOptions { noise: NoiseSource::Fixed(fit.noise), ..context.fit.clone() };
        let (rest, part) = (with_found(&rest, found), with_found(&part, found));
        let again = fit_again(fit, &rest, context.solver, &options)?;
        residuals.push(Residuals::of(&again.fitted, &part)?);
        if !found.is_empty() {
            reach = (variances(&again.fitted, &part, &all)?, usual(&again.fitted, &rest)?);
        }
    }
    let [before, after] = [&residuals[0], &residuals[1]];
    // None without findings.
    let rows = (0..reach.0.len()).filter(|&row| before.distance(row).is_some());
    let unseen = rows.map(|row| UnseenRow {
        declared: measured(&before.position[row]),
        found: measured(&after.position[row]),
        variance: reach.0[row],
    });
    let unseen = UnseenPart { rows: unseen.collect(), usual: reach.1 };
    let draws = context.budget().bootstrap;
    let figures = Extrapolation {
        part: parted.part,
        poses: Visits::of(&part).len(),
        before: before.positions(),
        after: after.positions(),
        ci95: of_pair([before, after], &clusters(&part, None), &all, draws, context.options.seed)
            .map(|i| i.rms),
        fallen_back: None,
    };
    Ok(Some((figures, unseen)))
}

/// The last pose measurements in time.
fn last_in_time(data: &Dataset) -> Option<Parted> {
    let visits = Visits::of(data);
    let configuration = configurations(data);
    let time = |visit: usize| {
        let first = visits.rows[visit].first().copied().unwrap_or(0);
        if data.schema.time { data.time[first] } else { first as f64 }
    };
    // Of every session and every landmark: an installation or a place that was not seen cannot be predicted.
    let mut places = BTreeMap::<_, Vec<usize>>::new();
    for (visit, rows) in visits.rows.iter().enumerate() {
        let place = rows.first().map(|&row| (data.session(row), data.landmark(row), data.sensor(row)));
        places.entry(place).or_default().push(visit);
    }
    let mut left_out = vec![false; visits.len()];
    for order in places.values_mut() {
        order.sort_by(|&a, &b| time(a).total_cmp(&time(b)).then(a.cmp(&b)));
        let first = order.len() - (LAST * order.len() as f64).round() as usize;
        order[first..].iter().for_each(|&visit| left_out[visit] = true);
    }
    let known: BTreeSet<usize> =
        (0..visits.len()).filter(|&v| !left_out[v]).map(|v| configuration[v]).collect();
    let predicted = (0..visits.len()).map(|v| left_out[v] && !known.contains(&configuration[v])).collect();
    left_out.contains(&true).then_some(Parted { part: Part::LastInTime, predicted, left_out })
}

/// The pose measurements at both ends of the range of the joint with the largest standard deviation.
fn region(context: &Context<'_>, data: &Dataset) -> Option<Parted> {
    let visits = Visits::of(data);
    let values = |column: &[f64]| -> Vec<f64> {
        visits.rows.iter().map(|rows| rows.first().map_or(f64::NAN, |&row| column[row])).collect()
    };
    let spread = |column: &[f64]| {
        let mean = column.iter().sum::<f64>() / column.len().max(1) as f64;
        column.iter().map(|v| (v - mean).powi(2)).sum::<f64>()
    };
    let (joint, own) = (context.chain.movable().iter().zip(&data.joints))
        .map(|(joint, column)| (*joint, values(column)))
        .rev()
        .max_by(|a, b| spread(&a.1).total_cmp(&spread(&b.1)))?;
    let configuration = configurations(data);
    let mut first = BTreeMap::new();
    configuration.iter().zip(&own).for_each(|(c, v)| {
        first.entry(*c).or_insert(*v);
    });
    let mut sorted: Vec<f64> = first.into_values().collect();
    sorted.sort_by(f64::total_cmp);
    let end = (END * sorted.len() as f64).round() as usize;
    if end == 0 || 2 * end >= sorted.len() {
        return None;
    }
    let outside = [sorted[end], sorted[sorted.len() - 1 - end]];
    let predicted: Vec<bool> = own.iter().map(|v| *v < outside[0] || *v > outside[1]).collect();
    Some(Parted { part: Part::Region { joint, outside }, left_out: vec![false; predicted.len()], predicted })
}
