//! Check of one candidate without the assumption of normal errors: sign flips of whole poses.
//!
//! ```text
//! SS  = ‖Σ_u b_u‖²,     SS* = ‖Σ_u s_u b_u‖²,     p = (1 + #{SS* ≥ SS}) / (B + 1)
//! ```
//!
//! b_u are the scores TᵀX̃ᵀr̃ of pose u, s_u = ±1 at random. Where errors are symmetric, whatever their distribution, each set of signs is as
//! likely as any other. With few effective poses, `K = (Σ ‖b_u‖²)² / Σ ‖b_u‖⁴`, p cannot be small: 2^(1−K) at least. Then the normal
//! distribution of the errors decides alone.
//! Source: Freedman and Lane (1983); exchangeable blocks: Winkler et al. (2014).

use crate::problem::projection::Projection;
use nalgebra::DMatrix;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The check of one candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SignFlips {
    /// p-value of the candidate as a single test.
    pub p_value: f64,
    /// K: poses on which its explained sum of squares rests.
    pub effective_poses: f64,
}

/// Flips the signs of whole poses: `columns` are a candidate's raw columns (m × k), `pose` the pose of each observation.
pub(crate) fn sign_flips(
    projection: &Projection,
    columns: &DMatrix<f64>,
    pose: impl Iterator<Item = usize>,
    seed: u64,
) -> Option<SignFlips> {
    const FLIPS: usize = 999;
    let scores = projection.scores_by(columns, pose)?;
    let squares: Vec<f64> = scores.row_iter().map(|b| b.norm_squared()).collect();
    let (sum, fourth) = squares.iter().fold((0.0, 0.0), |(s, f), b| (s + b, f + b * b));
    let whole = scores.row_sum().norm_squared();
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x5167_f11b);
    let by_pose = scores.transpose();
    let mut as_large = 0;
    for _ in 0..FLIPS {
        let mut flipped = vec![0.0; scores.ncols()];
        for pose in by_pose.as_slice().chunks_exact(flipped.len()) {
            let sign = if random.next_u32() & 1 == 0 { 1.0 } else { -1.0 };
            flipped.iter_mut().zip(pose).for_each(|(sum, score)| *sum += score * sign);
        }
        let square: f64 = flipped.iter().map(|sum| sum * sum).sum();
        as_large += usize::from(square >= whole * (1.0 - 1e-12));
    }
    Some(SignFlips {
        p_value: (1 + as_large) as f64 / (FLIPS + 1) as f64,
        effective_poses: if fourth > 0.0 { sum * sum / fourth } else { 0.0 },
    })
}
