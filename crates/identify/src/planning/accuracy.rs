//! Visits after which the robot is most accurate where it matters.

use super::pool;
use crate::IdentifyError;
use nalgebra::{Cholesky, DMatrix};
use rayon::prelude::*;
use truepose_errormodel::{Dataset, FittedModel, Predictor, Schema};
use truepose_kinematics::{Conditions, TargetId};

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

/// Gᵀ G of the poses that matter, and how many there are.
fn wanted(
    fitted: &FittedModel,
    goals: Option<&Dataset>,
    root: &DMatrix<f64>,
    seed: u64,
) -> Result<(DMatrix<f64>, f64), IdentifyError> {
    let visits: Vec<Conditions> = match goals {
        Some(goals) => (0..goals.len()).map(|row| goals.conditions(row)).collect(),
        None => pool::everywhere(fitted, GOALS, seed),
    };
    let parts = all_shown(fitted, &visits, root)?;
    let count = (parts.len() * targets(fitted).len()).max(1) as f64;
    let mut sum = DMatrix::zeros(root.ncols(), root.ncols());
    for part in &parts {
        sum += part.transpose() * part;
    }
    Ok((sum, count))
}

fn inverse(information: &DMatrix<f64>) -> DMatrix<f64> {
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
    let (goal, _) = wanted(fitted, goals, &root, seed)?;
    let whole = goal.trace().max(f64::MIN_POSITIVE);
    let r = root.ncols();
    let mut information = DMatrix::identity(r, r);
    let best = |information: &DMatrix<f64>, taken: &[(usize, f64)]| -> Option<(usize, f64)> {
        let p = inverse(information);
        let gains: Vec<f64> = rows
            .par_iter()
            .enumerate()
            .map(|(k, b)| if taken.iter().any(|t| t.0 == k) { f64::NEG_INFINITY } else { gain(&p, &goal, b) })
            .collect();
        (0..gains.len()).max_by(|&a, &b| gains[a].total_cmp(&gains[b]).then(b.cmp(&a))).map(|k| (k, gains[k]))
    };
    let mut chosen: Vec<(usize, f64)> = Vec::new();
    for _ in 0..count {
        let Some((k, gain)) = best(&information, &chosen) else { break };
        information += rows[k].transpose() * &rows[k];
        chosen.push((k, gain / whole));
    }
    for _ in 0..PASSES {
        let mut moved = false;
        for at in 0..chosen.len() {
            let (old, _) = chosen[at];
            let without = &information - rows[old].transpose() * &rows[old];
            let others: Vec<(usize, f64)> =
                chosen.iter().enumerate().filter(|(k, _)| *k != at).map(|(_, &c)| c).collect();
            let Some((new, gain)) = best(&without, &others) else { continue };
            moved |= new != old;
            information = without + rows[new].transpose() * &rows[new];
            chosen[at] = (new, gain / whole);
        }
        if !moved {
            break;
        }
    }
    chosen.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    Ok(chosen)
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
    let (goal, count) = wanted(fitted, goals, &root, seed)?;
    let mut information = DMatrix::identity(root.ncols(), root.ncols());
    for rows in all_shown(fitted, visits, &root)? {
        information += rows.transpose() * &rows / (sigma * sigma);
    }
    let left = (inverse(&information) * &goal).trace();
    let accuracy = ((goal.trace() / count).sqrt(), (left.max(0.0) / count).sqrt());
    let values: Vec<f64> =
        information.symmetric_eigen().eigenvalues.iter().map(|v| v.max(0.0).sqrt()).collect();
    let (first, last) =
        values.iter().fold((0.0f64, f64::INFINITY), |(most, least), &v| (most.max(v), least.min(v)));
    let n = values.len() as f64;
    let mean = (values.iter().map(|v| v.max(f64::MIN_POSITIVE).ln()).sum::<f64>() / n).exp();
    let harmonic = 1.0 / values.iter().map(|v| 1.0 / v.max(f64::MIN_POSITIVE)).sum::<f64>();
    Ok((
        accuracy,
        [(1.0, mean), (1.0, last / first), (1.0, last), (1.0, last * last / first), (1.0 / n, harmonic)],
    ))
}
