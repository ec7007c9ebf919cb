//! Which rows of any kind to measure next: which sockets to touch from where, what a camera should look at.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | A = [A_c A_s] | what the coefficients c of the robot and the unknowns s of landmarks and sensors do to a visit, over its noise | numbers × (p + s) | |
//! | L, S | C = L Lᵀ of the fit; expected sizes of s | p × r; s × s, diagonal | |
//! | B = [A_c L, A_s S] | what the visit would show, in deviations | numbers × (r + s) | 1 |
//! | G | of the positions that matter; zero for s | 3g × (r + s) | m |
//!
//! As for positions, `min tr(G P Gᵀ)` with `P = (1 + Σ BᵀB)⁻¹` (I-optimality), over the robot alone: where a socket stands is of no interest, and
//! rows pay for finding it. The first row at a socket finds the socket and says nothing of the robot, so that choosing row by row would never begin
//! a second one: rows are first chosen as if everything stood where it is described, and then exchanged with the places unknown.
//!
//! Where nothing says where the base is, a displacement of all positions together does not count, nor where the tool's point sits that images alone do not show:
//! both are projected out of G, else every plan would be made to find what no row tells.
//! Where too few rows of a thing are chosen for a fit to find it, more of the others are taken in their place.
//! A landmark is taken as one that the fit has not seen: what its rows said of the landmark is not in the fit, what they said of the robot is.

use super::accuracy::{self, Free, best, exchanged, figures, greedy, inverse, wanted};
use super::choose::checked;
use super::options::PlanOptions;
use crate::IdentifyError;
use crate::landmarks::PlannedRows;
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::{Dataset, FittedModel, Landmark, Surroundings};

/// Passes of the exchange.
const PASSES: usize = 6;
/// How often all candidates are taken to see what they cannot tell.
const ENDLESS: f64 = 1e4;
/// Plans that are drawn at random, to hold the chosen one against.
const DRAWS: usize = 21;

/// A visit to make.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservedVisit {
    /// Its rows among the candidates.
    pub rows: Vec<usize>,
    /// Share of the expected squared error that it takes away, beside all others.
    pub worth: f64,
}

/// Which of some rows to measure, and what it would bring.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservedPlan {
    /// In the order of their worth.
    pub visits: Vec<ObservedVisit>,
    /// Expected 3-D RMS error that the coefficients leave at the poses that matter, now and then, m: the part of it that such rows can tell.
    pub accuracy: (f64, f64),
    /// What no number of these rows tells, m. A displacement of the base, where nothing says where it is, and of the tool's point, where images alone are taken,
    /// is in neither.
    pub beyond: f64,
    /// As `accuracy`, with as many visits drawn at random, in the median of some draws, m.
    pub at_random: f64,
    /// O1–O5 of what the fit and the plan determine, of the robot alone, in units of today's deviations; the first of each is of no plan.
    pub observability: [(f64, f64); 5],
}

/// Chooses `options.count` visits of `candidates`, rows of any kind whose landmarks count in `surroundings`, for accuracy at `goals` (the joints'
/// ranges when there are none). `options.pool` does not count.
///
/// ```text
/// min tr(G P Gᵀ),   P = (1 + Σ BᵀB)⁻¹,   B = [A_c L, A_s S]
/// ```
///
/// L Lᵀ: covariance of the fit; S: prior standard deviations of places of landmarks and sensors, which G leaves out; A: rows over their noise. I-optimality by
/// choice and exchange (Fedorov 1972; Wu, Klimchik, Caro, Furet and Pashkevich 2015).
///
/// # Errors
/// When the fit has no coefficient with a deviation; [`IdentifyError::Landmark`] where a row cannot be observed from its posture, or nothing says
/// where its sensor is.
pub fn plan_observed(
    fitted: &FittedModel,
    (candidates, surroundings): (&Dataset, &Surroundings),
    goals: Option<&Dataset>,
    options: &PlanOptions,
) -> Result<ObservedPlan, IdentifyError> {
    checked("count", options.count)?;
    let root = accuracy::root(fitted)?;
    let candidate = PlannedRows::of(fitted, candidates, surroundings)?;
    let (p, r, s) = (root.nrows(), root.ncols(), candidate.sizes.len());
    let shown = |whole: &DMatrix<f64>| {
        let mut b = DMatrix::zeros(whole.nrows(), r + s);
        b.columns_mut(0, r).copy_from(&(whole.columns(0, p) * &root));
        for (k, size) in candidate.sizes.iter().enumerate() {
            b.set_column(r + k, &(whole.column(p + k) * *size));
        }
        b
    };
    let rows: Vec<DMatrix<f64>> = candidate.visits.iter().map(shown).collect();
    let free = Free { base: !candidate.has_base, tool: candidate.images_only };
    let (of_robot, count) = wanted(fitted, goals, &root, (options.seed, free))?;
    let mut goal = DMatrix::zeros(r + s, r + s);
    goal.view_mut((0, 0), (r, r)).copy_from(&of_robot);
    let robot: Vec<DMatrix<f64>> = rows.iter().map(|b| b.columns(0, r).into_owned()).collect();
    let first = greedy(&robot, &of_robot, options.count);
    let mut chosen = exchanged(&rows, &goal, first, PASSES);
    enough(&mut chosen, (&rows, &goal), &things(candidates, surroundings));
    let beyond = untold(&told(&rows, &mut (0..rows.len()), r), &of_robot) / count;
    let of = |taken: &mut dyn Iterator<Item = usize>| {
        let information = DMatrix::identity(r, r) + told(&rows, taken, r);
        let ((now, then), observability) = figures(information, (&of_robot, count));
        let rest = |rms: f64| (rms * rms - beyond).max(0.0).sqrt();
        ((rest(now), rest(then)), observability)
    };
    let (accuracy, observability) = of(&mut chosen.iter().map(|&(k, _)| k));
    let mut visits = vec![Vec::new(); rows.len()];
    candidates.visit.iter().enumerate().for_each(|(row, &visit)| visits[visit].push(row));
    let planned = chosen.iter().map(|&(k, worth)| ObservedVisit { rows: visits[k].clone(), worth });
    let mut random = ChaCha8Rng::seed_from_u64(options.seed ^ 0x51c3);
    let mut order: Vec<usize> = (0..rows.len()).collect();
    let mut drawn: Vec<f64> = (0..DRAWS)
        .map(|_| {
            order.shuffle(&mut random);
            of(&mut order.iter().copied().take(options.count)).0.1
        })
        .collect();
    drawn.sort_by(f64::total_cmp);
    let at_random = drawn[DRAWS / 2];
    Ok(ObservedPlan { visits: planned.collect(), accuracy, beyond: beyond.sqrt(), at_random, observability })
}

/// A thing that is observed: how many rows of it each visit has, and how many a fit needs.
struct Thing {
    rows: Vec<usize>,
    need: usize,
}

fn things(candidates: &Dataset, surroundings: &Surroundings) -> Vec<Thing> {
    let visits = candidates.visit.iter().max().map_or(0, |last| last + 1);
    let of = |(k, thing): (usize, &Landmark)| {
        let mut rows = vec![0; visits];
        let own = (0..candidates.len()).filter(|&row| candidates.landmark(row) == Some(k));
        own.for_each(|row| rows[candidates.visit[row]] += 1);
        let need = match &thing.observed {
            Some(observed) => observed.unknowns(&thing.name, 1.0).len() / observed.numbers() + 1,
            None if thing.known => 1,
            None => 2,
        };
        Thing { rows, need }
    };
    surroundings.landmarks.iter().enumerate().map(of).collect()
}

/// Gives up things of which too little was chosen for a fit to find them, for more of the others.
fn enough(chosen: &mut Vec<(usize, f64)>, (rows, goal): (&[DMatrix<f64>], &DMatrix<f64>), things: &[Thing]) {
    let whole = goal.trace().max(f64::MIN_POSITIVE);
    for _ in 0..things.len() {
        let have = |thing: &Thing| chosen.iter().map(|&(k, _)| thing.rows[k]).sum::<usize>();
        let enough: Vec<bool> = things.iter().map(|thing| have(thing) >= thing.need).collect();
        let few = things.iter().zip(&enough).any(|(thing, enough)| !enough && have(thing) > 0);
        if !few || !enough.contains(&true) {
            break;
        }
        let given_up =
            |k: usize| things.iter().zip(&enough).any(|(thing, enough)| !enough && thing.rows[k] > 0);
        let wanted = chosen.len();
        chosen.retain(|&(k, _)| !given_up(k));
        let mut information = DMatrix::identity(goal.nrows(), goal.nrows());
        chosen.iter().for_each(|&(k, _)| information += rows[k].transpose() * &rows[k]);
        let barred: Vec<(usize, f64)> = (0..rows.len()).filter(|&k| given_up(k)).map(|k| (k, 0.0)).collect();
        while chosen.len() < wanted {
            let taken: Vec<(usize, f64)> = chosen.iter().chain(&barred).copied().collect();
            let Some((k, gain)) = best((rows, goal), &information, &taken) else { break };
            information += rows[k].transpose() * &rows[k];
            chosen.push((k, gain / whole));
        }
    }
    chosen.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
}

/// What some visits say of the robot, the places of everything else being unknown: the Schur complement of its part, r × r.
fn told(rows: &[DMatrix<f64>], taken: &mut dyn Iterator<Item = usize>, r: usize) -> DMatrix<f64> {
    let width = rows.first().map_or(r, DMatrix::ncols);
    let mut all = DMatrix::zeros(width, width);
    taken.for_each(|k| all += rows[k].transpose() * &rows[k]);
    let s = width - r;
    let across = all.view((0, r), (r, s));
    let places = all.view((r, r), (s, s)) + DMatrix::identity(s, s);
    all.view((0, 0), (r, r)) - across * inverse(&places) * across.transpose()
}

/// tr(G P Gᵀ) where these visits are made again and again.
fn untold(told: &DMatrix<f64>, goal: &DMatrix<f64>) -> f64 {
    /// What is told to rounding alone is not told.
    const ROUNDING: f64 = 1e-10;
    if told.is_empty() {
        return 0.0;
    }
    let eigen = told.clone().symmetric_eigen();
    let least = ROUNDING * eigen.eigenvalues.amax();
    let directions = eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter());
    let left = directions.map(|(value, v)| {
        let value = if *value > least { ENDLESS * value } else { 0.0 };
        v.dot(&(goal * v)) / (1.0 + value)
    });
    left.sum()
}

#[cfg(test)]
#[path = "observed_tests.rs"]
mod tests;
