//! Variance components of the noise: θ_i, and V_i by pose.

use crate::problem::linearisation::Linearisation;
use crate::problem::noise::Noise;
use nalgebra::DMatrix;

/// A variance component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Component {
    Rows,
    Poses,
    Turns,
    Turning,
    Sliding,
}

impl Component {
    pub const ALL: [Component; 5] =
        [Component::Rows, Component::Poses, Component::Turns, Component::Turning, Component::Sliding];
    /// Those of the joints.
    pub const JOINTS: [Component; 2] = [Component::Turning, Component::Sliding];

    pub fn is_of_joints(self) -> bool {
        Component::JOINTS.contains(&self)
    }

    /// θ, m² or rad².
    pub fn of(self, noise: Noise) -> f64 {
        let sd = match self {
            Component::Rows => noise.rows.position_sd,
            Component::Poses => noise.rows.visit_sd,
            Component::Turns => noise.rows.orientation_sd,
            Component::Turning => noise.joints.turning,
            Component::Sliding => noise.joints.sliding,
        };
        sd * sd
    }

    pub fn set(self, noise: &mut Noise, variance: f64) {
        *match self {
            Component::Rows => &mut noise.rows.position_sd,
            Component::Poses => &mut noise.rows.visit_sd,
            Component::Turns => &mut noise.rows.orientation_sd,
            Component::Turning => &mut noise.joints.turning,
            Component::Sliding => &mut noise.joints.sliding,
        } = variance.max(0.0).sqrt();
    }
}

/// V_i: the observations that it has to themselves, or a factor with columns of each pose.
#[derive(Debug)]
pub(crate) enum Part {
    Own(Vec<bool>),
    Shared(DMatrix<f64>),
}

/// All V_i of a linearised problem.
#[derive(Debug)]
pub(crate) struct Parts {
    pub each: Vec<(Component, Part)>,
    /// First observation of each pose, and the end.
    poses: Vec<usize>,
}

impl Parts {
    pub fn of(problem: &Linearisation<'_>) -> Self {
        let observations = &problem.observations;
        let mut poses = vec![0];
        for pose in observations.chunk_by(|a, b| a.visit == b.visit) {
            poses.push(poses[poses.len() - 1] + pose.len());
        }
        let mut each = Vec::new();
        let own = |position: bool| -> Vec<bool> {
            observations.iter().map(|o| (o.component < 3) == position).collect()
        };
        if own(true).contains(&true) {
            each.push((Component::Rows, Part::Own(own(true))));
            // Of poses with one row each, what they share is what they have.
            let several = poses.windows(2).any(|pose| {
                let rows = observations[pose[0]..pose[1]].iter().filter(|o| o.component < 3).map(|o| o.row);
                rows.clone().any(|row| rows.clone().any(|other| other != row))
            });
            if several {
                let shared = DMatrix::from_fn(problem.len(), 3, |at, k| {
                    match problem.data.ray(observations[at].row) {
                        Some(w) if observations[at].component == 0 => w[k],
                        _ => f64::from(u8::from(observations[at].component == k)),
                    }
                });
                each.push((Component::Poses, Part::Shared(shared)));
            }
        }
        if own(false).contains(&true) {
            each.push((Component::Turns, Part::Own(own(false))));
        }
        for (component, slides) in [(Component::Turning, false), (Component::Sliding, true)] {
            let levers = problem.levers().of(slides);
            if levers.ncols() > 0 && levers.amax() > 0.0 {
                each.push((component, Part::Shared(levers)));
            }
        }
        Parts { each, poses }
    }

    /// tr Uᵀ V_i U of columns U, m × k.
    pub fn trace(&self, part: &Part, columns: &DMatrix<f64>) -> f64 {
        match part {
            Part::Own(own) => {
                let of_column = |column: &[f64]| -> f64 {
                    column.iter().zip(own).filter(|(_, own)| **own).map(|(v, _)| v * v).sum()
                };
                columns.as_slice().chunks_exact(own.len().max(1)).map(of_column).sum()
            }
            Part::Shared(factor) => {
                let of_pose = |pose: &[usize]| {
                    let (first, size) = (pose[0], pose[1] - pose[0]);
                    columns.rows(first, size).tr_mul(&factor.rows(first, size)).norm_squared()
                };
                self.poses.windows(2).map(of_pose).sum()
            }
        }
    }

    /// V_i w of each component, m × components.
    pub fn through(&self, weighed: &DMatrix<f64>) -> DMatrix<f64> {
        let m = weighed.nrows();
        let mut through = DMatrix::zeros(m, self.each.len());
        for (i, (_, part)) in self.each.iter().enumerate() {
            match part {
                Part::Own(own) => {
                    (0..m).filter(|&at| own[at]).for_each(|at| through[(at, i)] = weighed[(at, 0)]);
                }
                Part::Shared(factor) => {
                    for pose in self.poses.windows(2) {
                        let (first, size) = (pose[0], pose[1] - pose[0]);
                        let raw = factor.rows(first, size);
                        let along = raw.tr_mul(&weighed.rows(first, size));
                        through.view_mut((first, i), (size, 1)).copy_from(&(raw * along));
                    }
                }
            }
        }
        through
    }
}
