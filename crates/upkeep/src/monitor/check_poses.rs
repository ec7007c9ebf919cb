//! Poses to look at a robot with: those that show changes of its errors best.
//!
//! ```text
//! max Σ_i (1/n_i) Σ_k ln I_ik        I_ik = (X_iᵀ Q X_i)_kk: information on coefficient k of suspect i
//! ```
//!
//! Greedy, one pose after the other, among the configurations of the fit: the robot has been there, so that it can go there. Every target of
//! the fit is taken to be measured at each. The sum of logarithms makes all suspects visible, rather than one of them very well (D-optimal
//! design for each suspect: Fedorov 1972).

use super::score::ScoreTest;
use super::suspects::{Suspect, suspects};
use super::{Detectable, level};
use crate::UpkeepError;
use crate::prediction::Prediction;
use truepose_errormodel::{Dataset, FittedModel};
use truepose_kinematics::Conditions;

/// Configurations that are compared, evenly taken.
const CONFIGURATIONS: usize = 80;
/// Information that is taken for none, in units of one coefficient.
const NONE: f64 = 1e-12;

/// Poses for a look.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckPoses {
    /// Their conditions.
    pub poses: Vec<Conditions>,
    /// What change a first look with them finds, the least visible first.
    pub detectable: Vec<Detectable>,
    /// What they cannot show.
    pub invisible: Vec<String>,
}

/// Chooses `count` poses for looks at error rate `alpha`.
///
/// # Errors
/// [`UpkeepError::NoUncertainty`] where the fit holds no configurations, or no covariance.
pub fn check_poses(fitted: &FittedModel, count: usize, alpha: f64) -> Result<CheckPoses, UpkeepError> {
    let pool = pool(fitted)?;
    let of_pose: Vec<Vec<usize>> = truepose_errormodel::Visits::of(&pool).rows;
    let candidates = suspects(fitted, &[]);
    let judged = |poses: &[usize]| -> Result<(Prediction, ScoreTest), UpkeepError> {
        let rows: Vec<usize> = poses.iter().flat_map(|&pose| of_pose[pose].iter().copied()).collect();
        let rows = Prediction::of(fitted, &[], &pool.select(&rows))?;
        let test = ScoreTest::of(fitted, &rows)?;
        Ok((rows, test))
    };
    let mut chosen: Vec<usize> = Vec::new();
    for _ in 0..count.min(of_pose.len()) {
        let mut best: Option<(f64, usize)> = None;
        for pose in (0..of_pose.len()).filter(|pose| !chosen.contains(pose)) {
            let with: Vec<usize> = chosen.iter().copied().chain([pose]).collect();
            let (rows, test) = judged(&with)?;
            let worth: f64 = candidates.iter().map(|suspect| shown(&test, &rows, suspect)).sum();
            if best.is_none_or(|(most, _)| worth > most) {
                best = Some((worth, pose));
            }
        }
        let Some((_, pose)) = best else { break };
        chosen.push(pose);
    }
    let (rows, test) = judged(&chosen)?;
    let (mut detectable, mut invisible) = (Vec::new(), Vec::new());
    for suspect in &candidates {
        match test.detectable(fitted, &rows, suspect, level(alpha, 1)) {
            Some(found) => detectable.push(found),
            None => invisible.push(suspect.word.clone()),
        }
    }
    detectable.sort_by(|a, b| b.moves.total_cmp(&a.moves));
    let poses = chosen.iter().map(|&pose| pool.conditions(of_pose[pose][0])).collect();
    Ok(CheckPoses { poses, detectable, invisible })
}

/// What a suspect's coefficients are worth.
fn shown(test: &ScoreTest, rows: &Prediction, suspect: &Suspect) -> f64 {
    let count = suspect.columns.len().max(1) as f64;
    let information = |k: usize, of: &nalgebra::DMatrix<f64>| of[(k, k)].max(NONE).ln();
    match test.visible(rows, suspect) {
        Some((_, of)) => (0..of.ncols()).map(|k| information(k, &of)).sum::<f64>() / count,
        None => NONE.ln(),
    }
}

/// Configurations of the fit, all of its targets at each, measured where they are predicted.
fn pool(fitted: &FittedModel) -> Result<Dataset, UpkeepError> {
    let sample = fitted.domain.sample.rows();
    if sample.is_empty() {
        return Err(UpkeepError::NoUncertainty { what: "the configurations that it was made from" });
    }
    let targets = match fitted.domain.targets.as_slice() {
        [] => vec![None],
        targets => targets.to_vec(),
    };
    let step = sample.len().div_ceil(CONFIGURATIONS).max(1);
    let rows: Vec<usize> =
        (0..sample.len()).step_by(step).flat_map(|row| std::iter::repeat_n(row, targets.len())).collect();
    let mut pool = sample.select(&rows);
    let mut predictor = fitted.bind(&pool.schema)?;
    for row in 0..pool.len() {
        pool.target[row] = targets[row % targets.len()];
        pool.visit[row] = row / targets.len();
        let at = predictor.predict(&pool.conditions(row), pool.target[row]).translation;
        pool.position[row] = at.into();
        pool.orientation[row] = None;
    }
    pool.record = None;
    Ok(pool)
}
