//! Noise of a linearised problem: of rows, of poses, and of the joints, which repeat in joint space.
//!
//! ```text
//! V_v = diag(s_i² + τ²) + ρ² within a component of position + G_v Σ_q G_vᵀ,     Σ_q = diag(σ²)
//! ```
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | τ, ρ, ω | [`NoiseModel`] | 1 | m, m, rad |
//! | G_v | [`Levers`]: what a joint's deviation does to every observation of the pose | observations × joints | m or rad per rad or m |
//! | σ | [`JointNoise`]: each joint from one pose measurement to the next | 1 | rad, m |
//!
//! Where a robot repeats in joint space its scatter depends on posture, turns the tool, and is correlated among targets and components of a
//! pose. Source: Brethé, *Granular stochastic modeling of robot micrometric precision* (2011).

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use truepose_identify::NoiseModel;

/// Standard deviations of the joints from one pose measurement to the next; zero: none.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct JointNoise {
    /// Of each turning joint, rad.
    pub turning: f64,
    /// Of each slide, m.
    pub sliding: f64,
}

impl JointNoise {
    /// Whether there is any.
    pub fn is_some(self) -> bool {
        self.turning > 0.0 || self.sliding > 0.0
    }
}

/// Noise of rows and poses, and of the joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    pub rows: NoiseModel,
    pub joints: JointNoise,
}

impl From<NoiseModel> for Noise {
    fn from(rows: NoiseModel) -> Self {
        Noise { rows, joints: JointNoise::default() }
    }
}

/// What a unit deviation of each joint does to every observation.
#[derive(Debug, Clone)]
pub(crate) struct Levers {
    /// m or rad per rad or m; observations × movable joints that act somewhere.
    pub columns: DMatrix<f64>,
    /// Which of them are slides.
    pub slides: Vec<bool>,
}

impl Levers {
    /// From what each movable joint's motion does at the sites of the error Jacobian (site, share), and the Jacobian's row of every observation.
    pub fn new<'s>(
        motions: &[(Vec<(usize, f64)>, bool)],
        observations: usize,
        sites: impl Fn(usize) -> &'s [f64],
    ) -> Self {
        let along =
            |at: usize, k: usize| motions[k].0.iter().map(|&(site, part)| part * sites(at)[site]).sum();
        Levers {
            columns: DMatrix::from_fn(observations, motions.len(), along),
            slides: motions.iter().map(|(_, slides)| *slides).collect(),
        }
    }

    /// Columns of turning joints, or of slides.
    pub fn of(&self, slides: bool) -> DMatrix<f64> {
        let own: Vec<usize> = (0..self.slides.len()).filter(|&k| self.slides[k] == slides).collect();
        self.columns.select_columns(&own)
    }

    /// Columns times the standard deviations of their joints.
    pub fn scaled(&self, joints: JointNoise) -> DMatrix<f64> {
        let mut columns = self.columns.clone();
        for (mut column, slides) in columns.column_iter_mut().zip(&self.slides) {
            column *= if *slides { joints.sliding } else { joints.turning };
        }
        columns
    }
}
