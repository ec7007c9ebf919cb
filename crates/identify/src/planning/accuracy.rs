//! Visits after which the robot is most accurate where it matters.

use super::pool;
use crate::IdentifyError;
use nalgebra::{Cholesky, DMatrix};
use rayon::prelude::*;
use truepose_errormodel::{Dataset, FittedModel, Predictor, Schema};
use truepose_kinematics::{Conditions, TargetId, skew};

/// Poses that stand for the workspace where nobody names any.
const GOALS: usize = 150;
/// Passes of the exchange.
const PASSES: usize = 2;

/// L of the coefficients that have a deviation, p × r; zero rows for all others.
pub(super) fn root(fitted: &FittedModel) -> Result<DMatrix<f64>, IdentifyError> {
    let covariance = fitted.covariance();
    let kept: Vec<usize> = (0..covariance.nrows()).filter(|&k| covariance[(k, k)] > 0.0).collect();
    let scale: Vec<f64> = kept.iter().map(|&k| covariance[(k, k)].sqrt()).collect();
    let inner = DMatrix::from_fn(kept.len(), kept.len(), |i, j| {
        covariance[(kept[i], kept[j])] / (scale[i] * scale[j]) + if i == j { 1e-12 } else { 0.0 }
    });
    let factor = (!kept.is_empty()).then(|| Cholesky::new(inner)).flatten();
    let Some(factor) = factor else {
        return Err(IdentifyError::Option {
            option: "fit",
            value: kept.len() as f64,
            expected: "a fit whose coefficients have a covariance",
        });
    };
    let mut root = DMatrix::zeros(covariance.nrows(), kept.len());
    let lower = factor.l();
    for (i, &k) in kept.iter().enumerate() {
        for j in 0..=i {
            root[(k, j)] = scale[i] * lower[(i, j)];
        }
    }
    Ok(root)
}

/// The schema of planned conditions: everything that the fit may read is there.
pub(super) fn schema(fitted: &FittedModel) -> Schema {
    Schema { channels: fitted.channels.clone(), time: true, load: true, approach: true }
}

/// Targets that a visit measures; the tool's origin when none is declared.
pub(super) fn targets(fitted: &FittedModel) -> Vec<Option<TargetId>> {
    match fitted.chain().targets().len() {
        0 => vec![None],
        count => (0..count).map(|k| Some(TargetId(k))).collect(),
    }
}

/// Positions' sensitivities of all targets times L, 3a × r, m.
pub(super) fn shown(
    predictor: &mut Predictor<'_>,
    conditions: &Conditions,
    targets: &[Option<TargetId>],
    root: &DMatrix<f64>,
) -> DMatrix<f64> {
    let mut rows = DMatrix::zeros(3 * targets.len(), root.ncols());
    for (k, &target) in targets.iter().enumerate() {
        let part = predictor.sensitivity(conditions, target).rows(0, 3) * root;
        rows.rows_mut(3 * k, 3).copy_from(&part);
    }
    rows
}

fn all_shown(
    fitted: &FittedModel,
    visits: &[Conditions],
    root: &DMatrix<f64>,
) -> Result<Vec<DMatrix<f64>>, IdentifyError> {
    let (schema, targets) = (schema(fitted), targets(fitted));
    fitted.bind(&schema)?;
    visits
        .par_iter()
        .map_init(
            || fitted.bind(&schema),
            |predictor, conditions| match predictor {
                Ok(predictor) => Ok(shown(predictor, conditions, &targets, root)),
                Err(error) => Err(IdentifyError::from(error.clone())),
            },
        )
        .collect()
}

/// What of the poses that matter does not count, since nothing that is measured can tell it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Free {
    /// Where the base stands: three displacements and three turns of all poses together.
    pub base: bool,
    /// Where the tool's point sits on the tool: three displacements.
    pub tool: bool,
}

/// Gᵀ G of the poses that matter, and how many there are. What is free is projected out of G.
pub(super) fn wanted(
    fitted: &FittedModel,
    goals: Option<&Dataset>,
    root: &DMatrix<f64>,
    (seed, free): (u64, Free),
) -> Result<(DMatrix<f64>, f64), IdentifyError> {
    let visits: Vec<Conditions> = match goals {
        Some(goals) => (0..goals.len()).map(|row| goals.conditions(row)).collect(),
        None => pool::everywhere(fitted, GOALS, seed),
    };
    let targets = targets(fitted);
    let parts = all_shown(fitted, &visits, root)?;
    let count = (parts.len() * targets.len()).max(1) as f64;
    let mut sum = DMatrix::zeros(root.ncols(), root.ncols());
    for part in &parts {
        sum += part.transpose() * part;
    }
    let width = if free.base { 6 } else { 0 } + if free.tool { 3 } else { 0 };
    if width > 0 {
        let mut predictor = fitted.bind(&schema(fitted))?;
        let mut square = DMatrix::zeros(width, width);
        let mut across = DMatrix::zeros(width, root.ncols());
        for (conditions, part) in visits.iter().zip(&parts) {
            let mut moves = DMatrix::zeros(part.nrows(), width);
            for (k, &target) in targets.iter().enumerate() {
                let at = predictor.predict(conditions, target);
                let mut own = moves.rows_mut(3 * k, 3);
                if free.base {
                    own.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
                    own.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(&at.translation));
                }
                if free.tool {
                    own.fixed_view_mut::<3, 3>(0, width - 3).copy_from(&at.rotation);
                }
            }
            square += moves.transpose() * &moves;
            across += moves.transpose() * part;
        }
        let inverse = square.pseudo_inverse(1e-9 * count).unwrap_or_else(|_| DMatrix::zeros(width, width));
        sum -= across.transpose() * inverse * across;
    }
    Ok((sum, count))
}

pub(super) fn inverse(information: &DMatrix<f64>) -> DMatrix<f64> {
    let n = information.nrows();
    Cholesky::new(information.clone()).map_or_else(|| DMatrix::identity(n, n), |factor| factor.inverse())
}

/// By how much a visit lowers tr(G P Gᵀ).
fn gain(p: &DMatrix<f64>, goal: &DMatrix<f64>, rows: &DMatrix<f64>) -> f64 {
    let bp = rows * p;
    let mut inner = &bp * rows.transpose();
    for k in 0..inner.nrows() {
        inner[(k, k)] += 1.0;
    }
    let through = &bp * goal * bp.transpose();
    Cholesky::new(inner).map_or(0.0, |factor| factor.solve(&through).trace())
}

/// Positions in the pool with the share of the expected squared error that each takes away, best first.
pub(super) fn choose(
    fitted: &FittedModel,
    pool: &[Conditions],
    goals: Option<&Dataset>,
    count: usize,
    seed: u64,
) -> Result<Vec<(usize, f64)>, IdentifyError> {
    let root = root(fitted)?;
    let sigma = fitted.noise.position_sd.max(1e-9);
    let rows: Vec<DMatrix<f64>> = all_shown(fitted, pool, &root)?.into_iter().map(|b| b / sigma).collect();
    let (goal, _) = wanted(fitted, goals, &root, (seed, Free::default()))?;
    let greedy = greedy(&rows, &goal, count);
    Ok(exchanged(&rows, &goal, greedy, PASSES))
}

/// The candidate that lowers tr(G P Gᵀ) most beside this information, of those that are not taken, and by how much.
pub(super) fn best(
    (rows, goal): (&[DMatrix<f64>], &DMatrix<f64>),
    information: &DMatrix<f64>,
    taken: &[(usize, f64)],
) -> Option<(usize, f64)> {
    let p = inverse(information);
    let gains: Vec<f64> = rows
        .par_iter()
        .enumerate()
        .map(|(k, b)| if taken.iter().any(|t| t.0 == k) { f64::NEG_INFINITY } else { gain(&p, goal, b) })
        .collect();
    let most = (0..gains.len()).max_by(|&a, &b| gains[a].total_cmp(&gains[b]).then(b.cmp(&a)));
    most.map(|k| (k, gains[k])).filter(|(_, gain)| *gain > f64::NEG_INFINITY)
}

/// One candidate after the other, each with the share of tr(G Gᵀ) that it takes away beside those before.
pub(super) fn greedy(rows: &[DMatrix<f64>], goal: &DMatrix<f64>, count: usize) -> Vec<(usize, f64)> {
    let whole = goal.trace().max(f64::MIN_POSITIVE);
    let mut information = DMatrix::identity(goal.nrows(), goal.nrows());
    let mut chosen: Vec<(usize, f64)> = Vec::new();
    for _ in 0..count {
        let Some((k, gain)) = best((rows, goal), &information, &chosen) else { break };
        information += rows[k].transpose() * &rows[k];
        chosen.push((k, gain / whole));
    }
    chosen
}

/// Each of them exchanged for the best there is beside the others, until nothing moves, in so many passes at most; best first.
pub(super) fn exchanged(
    rows: &[DMatrix<f64>],
    goal: &DMatrix<f64>,
    mut chosen: Vec<(usize, f64)>,
    passes: usize,
) -> Vec<(usize, f64)> {
    let whole = goal.trace().max(f64::MIN_POSITIVE);
    let mut information = DMatrix::identity(goal.nrows(), goal.nrows());
    chosen.iter().for_each(|&(k, _)| information += rows[k].transpose() * &rows[k]);
    for _ in 0..passes {
        let mut moved = false;
        for at in 0..chosen.len() {
            let (old, _) = chosen[at];
            let without = &information - rows[old].transpose() * &rows[old];
            let others: Vec<(usize, f64)> =
                chosen.iter().enumerate().filter(|(k, _)| *k != at).map(|(_, &c)| c).collect();
            let Some((new, gain)) = best((rows, goal), &without, &others) else { continue };
            moved |= new != old;
            information = without + rows[new].transpose() * &rows[new];
            chosen[at] = (new, gain / whole);
        }
        if !moved {
            break;
        }
    }
    chosen.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    chosen
}

/// Expected error now and with these visits, and O1–O5 likewise.
#[allow(clippy::type_complexity)]
pub(super) fn judged(
    fitted: &FittedModel,
    visits: &[Conditions],
    goals: Option<&Dataset>,
    seed: u64,
) -> Result<((f64, f64), [(f64, f64); 5]), IdentifyError> {
    let root = root(fitted)?;
    let sigma = fitted.noise.position_sd.max(1e-9);
    let (goal, count) = wanted(fitted, goals, &root, (seed, Free::default()))?;
    let mut information = DMatrix::identity(root.ncols(), root.ncols());
    for rows in all_shown(fitted, visits, &root)? {
        information += rows.transpose() * &rows / (sigma * sigma);
    }
    Ok(figures(information, (&goal, count)))
}

/// Expected error before any of this information and with it, and O1–O5 likewise.
#[allow(clippy::type_complexity)]
pub(super) fn figures(
    information: DMatrix<f64>,
    (goal, count): (&DMatrix<f64>, f64),
) -> ((f64, f64), [(f64, f64); 5]) {
    let left = (inverse(&information) * goal).trace();
    let accuracy = ((goal.trace() / count).sqrt(), (left.max(0.0) / count).sqrt());
    // Nothing is open that a visit could show.
    if information.is_empty() {
        return (accuracy, [(1.0, 1.0); 5]);
    }
    let values: Vec<f64> =
        information.symmetric_eigen().eigenvalues.iter().map(|v| v.max(0.0).sqrt()).collect();
    let (first, last) =
        values.iter().fold((0.0f64, f64::INFINITY), |(most, least), &v| (most.max(v), least.min(v)));
    let n = values.len() as f64;
    let mean = (values.iter().map(|v| v.max(f64::MIN_POSITIVE).ln()).sum::<f64>() / n).exp();
    let harmonic = 1.0 / values.iter().map(|v| 1.0 / v.max(f64::MIN_POSITIVE)).sum::<f64>();
    (
        accuracy,
        [(1.0, mean), (1.0, last / first), (1.0, last), (1.0, last * last / first), (1.0 / n, harmonic)],
    )
}
