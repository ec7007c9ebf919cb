//! Poses to look at a robot with: those that show changes of its errors best.
//!
//! ```text
//! max Σ_i (1/n_i) Σ_k ln I_ik        I_ik = (X_iᵀ Q X_i)_kk: information on coefficient k of suspect i
//! ```
//!
//! One pose after the other among the configurations of the fit, then exchanged as long as the sum grows: the robot has been there, so that it
//! can go there. Every target of the fit is taken to be measured at each. The sum of logarithms makes all suspects visible, rather than one of
//! them very well (D-optimal design for each suspect: Fedorov 1972). Numbers of different poses err independently, so that their information
//! adds up:
//!
//! ```text
//! A = Σ_poses H_jᵀV_j⁻¹H_j        HᵀQH = A − A L (1 + LᵀAL)⁻¹ LᵀA,  L Lᵀ = C
//! ```

use super::alike;
use super::score::{ABSORBED, ScoreTest};
use super::suspects::{Suspect, suspects};
use super::{Detectable, level};
use crate::UpkeepError;
use crate::prediction::{Prediction, root};
use crate::tails::Tails;
use nalgebra::DMatrix;
use truepose_errormodel::{Dataset, FittedModel};
use truepose_kinematics::Conditions;

/// Configurations that are compared, evenly taken.
const CONFIGURATIONS: usize = 80;
/// Information that is taken for none, in units of one coefficient.
const NONE: f64 = 1e-12;
/// Rounds of exchanges; the third one seldom finds any.
const ROUNDS: usize = 4;

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
    let choice = Choice::of(fitted, &candidates, &of_pose, &pool)?;
    let chosen = choice.best(count.min(of_pose.len()));
    let rows: Vec<usize> = chosen.iter().flat_map(|&pose| of_pose[pose].iter().copied()).collect();
    let mut rows = Prediction::of(fitted, &[], &pool.select(&rows))?;
    let tails = Tails::of(fitted)?;
    tails.iter().for_each(|tails| tails.bound(&mut rows));
    let test = ScoreTest::of(fitted, &rows, tails)?;
    let groups = alike::groups(&test.information(&rows), &candidates);
    // As a look with these poses tests them.
    let level = level(alpha, 1) / (2.0 * groups.len().max(1) as f64);
    let (mut detectable, mut invisible) = (Vec::new(), Vec::new());
    for group in &groups {
        match test.detectable(fitted, &rows, &candidates[group[0]], level) {
            Some(found) => detectable.push(found),
            None => invisible.extend(group.iter().map(|&k| candidates[k].word.clone())),
        }
    }
    detectable.sort_by(|a, b| b.moves.total_cmp(&a.moves));
    let poses = chosen.iter().map(|&pose| pool.conditions(of_pose[pose][0])).collect();
    Ok(CheckPoses { poses, detectable, invisible })
}

/// The information of every pose that can be chosen.
struct Choice<'a> {
    suspects: &'a [Suspect],
    /// A of each pose.
    each: Vec<DMatrix<f64>>,
    /// L.
    root: DMatrix<f64>,
}

impl<'a> Choice<'a> {
    fn of(
        fitted: &FittedModel,
        suspects: &'a [Suspect],
        poses: &[Vec<usize>],
        pool: &Dataset,
    ) -> Result<Self, UpkeepError> {
        let each = poses.iter().map(|rows| {
            let rows = Prediction::of(fitted, &[], &pool.select(rows))?;
            Ok(rows.arm.tr_mul(&rows.arm))
        });
        let each = each.collect::<Result<_, UpkeepError>>()?;
        Ok(Choice { suspects, each, root: root(fitted.covariance()) })
    }

    /// So many poses: one after the other, then exchanged.
    fn best(&self, count: usize) -> Vec<usize> {
        let n = self.root.nrows();
        let (mut whole, mut chosen, mut worth) = (DMatrix::zeros(n, n), Vec::new(), f64::NEG_INFINITY);
        for _ in 0..count {
            let Some((pose, then)) = self.next(&whole, &chosen) else { break };
            whole += &self.each[pose];
            chosen.push(pose);
            worth = then;
        }
        for _ in 0..ROUNDS {
            let before = worth;
            for place in 0..chosen.len() {
                let without = &whole - &self.each[chosen[place]];
                if let Some((pose, then)) = self.next(&without, &chosen).filter(|(_, then)| *then > worth) {
                    whole = without + &self.each[pose];
                    (chosen[place], worth) = (pose, then);
                }
            }
            if worth <= before {
                break;
            }
        }
        chosen
    }

    /// The pose that is worth most beside these, and what all are worth with it.
    fn next(&self, whole: &DMatrix<f64>, chosen: &[usize]) -> Option<(usize, f64)> {
        let open = (0..self.each.len()).filter(|pose| !chosen.contains(pose));
        open.map(|pose| (pose, self.worth(&(whole + &self.each[pose])))).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// What poses of this A are worth.
    fn worth(&self, whole: &DMatrix<f64>) -> f64 {
        let along = whole * &self.root;
        let inner = self.root.tr_mul(&along) + DMatrix::identity(self.root.ncols(), self.root.ncols());
        let Some(inner) = inner.cholesky() else { return f64::NEG_INFINITY };
        // diag(A L (1 + LᵀAL)⁻¹ LᵀA) are the squares of the columns of G⁻¹LᵀA, G Gᵀ = 1 + LᵀAL.
        let Some(taken) = inner.l().solve_lower_triangular(&along.transpose()) else {
            return f64::NEG_INFINITY;
        };
        let shown = |k: usize| {
            let left = whole[(k, k)] - taken.column(k).norm_squared();
            if left > ABSORBED * whole[(k, k)] { left.max(NONE).ln() } else { NONE.ln() }
        };
        let of = |suspect: &Suspect| {
            suspect.columns.iter().map(|&k| shown(k)).sum::<f64>() / suspect.columns.len().max(1) as f64
        };
        self.suspects.iter().map(of).sum()
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
