//! Repeatability in joint space: whether the joints scatter from one pose measurement to the next, and by how much.
//!
//! The noise of poses is at first the same everywhere and along all axes. Of a robot that repeats in joint space it is not: it depends on posture,
//! turns the tool, and is shared by position, orientation and all targets of a pose. In a screen it is significant, and no candidate predicts
//! it. So, when no candidate is left, the restricted likelihood is compared with and without the scatter of the joints beside the other
//! components. An effect, which is the same at a configuration whenever the robot comes there, is tested first, and beside the scatter.
//!
//! ```text
//! D = −2 ln L_R(without) + 2 ln L_R(with)          ½ χ²_0 + ½ χ²_1 where one kind of joint is there, at most ½ χ²_1 + ½ χ²_2 of two
//! ```
//!
//! Joints of a kind have one variance: tens of poses do not distinguish single joints. Source of the distribution: Self and Liang (1987).

use crate::problem::linearisation::Linearisation;
use crate::problem::noise::{JointNoise, Noise};
use crate::problem::observation::Observation;
use crate::problem::restricted::{Restricted, plain};
use crate::problem::variance::Component;
use crate::statistics::chi_square::surprisal;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;
use truepose_errormodel::Visits;
use truepose_identify::NoiseModel;

/// Repeatability in joint space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct JointRepeatability {
    /// Standard deviations of the joints.
    pub joints: JointNoise,
    /// p of none.
    pub p_value: f64,
    /// 3-D RMS of what they move the targets by, over all rows, m.
    pub at_tool: f64,
    /// What rows and poses scatter by beside them.
    pub(crate) rows: NoiseModel,
}

/// The scatter of the joints where it is significant.
pub(crate) fn joint_repeatability(linearisation: &Linearisation<'_>) -> Option<JointRepeatability> {
    tested(linearisation).map(|tested| tested.0)
}

/// The scatter of the joints where it is significant, and −2 ln of the restricted likelihood with it.
fn tested(linearisation: &Linearisation<'_>) -> Option<(JointRepeatability, f64)> {
    /// z² of the score below which the likelihoods are not compared.
    const CLOSE: f64 = 4.0;
    let nothing = DMatrix::zeros(linearisation.len(), 0);
    let restricted = Restricted::new(linearisation, &nothing, 0.0);
    let plain = restricted.fitted(plain(linearisation.noise.rows), false)?;
    let (without, deviance) = (plain.noise(), plain.restricted);
    let derivatives = restricted.derivatives_at(without)?;
    let places: Vec<usize> = (0..derivatives.components.len())
        .filter(|&k| Component::JOINTS.contains(&derivatives.components[k]))
        .collect();
    if !places.iter().any(|&k| derivatives.towards(k).is_some_and(|squared| squared > CLOSE)) {
        return None;
    }
    let scattering = restricted.fitted(without, true)?;
    let (noise, with) = (scattering.noise(), scattering.restricted);
    if !noise.joints.is_some() {
        return None;
    }
    let gain = (deviance - with).max(0.0);
    let p = |freedom: usize| (-surprisal(gain, freedom)).exp();
    let p_value = if places.len() > 1 { 0.5 * (p(1) + p(2)) } else { 0.5 * p(1) };
    let found = JointRepeatability {
        joints: noise.joints,
        p_value,
        at_tool: at_tool(linearisation, noise.joints),
        rows: noise.rows,
    };
    (p_value <= linearisation.policy.joint_noise_level).then_some((found, with))
}

/// Tests of candidates beside a scatter of the joints.
pub(crate) struct BesideJoints<'l> {
    linearisation: &'l Linearisation<'l>,
    /// The noise without a candidate and −2 ln of the likelihood, once a candidate is tested; none where the scatter is not significant.
    without: OnceLock<Option<(Noise, f64)>>,
}

impl<'l> BesideJoints<'l> {
    /// At a linearised problem.
    pub fn of(linearisation: &'l Linearisation<'l>) -> Self {
        BesideJoints { linearisation, without: OnceLock::new() }
    }

    /// p of raw columns of a candidate (m × k, of so many directions) beside a scatter of the joints, family-wise: the ratio of the likelihoods of
    /// two models with a scatter each. None where it is not significant, or part of the noise already.
    pub fn p_value(&self, columns: &DMatrix<f64>, freedom: usize) -> Option<f64> {
        let problem = self.linearisation;
        if columns.ncols() == 0 || problem.noise.joints.is_some() {
            return None;
        }
        let without = || {
            let (found, deviance) = tested(problem)?;
            Some((found.noise(), deviance))
        };
        let (start, deviance) = self.without.get_or_init(without).as_ref()?;
        // The candidate is free, and the determinant that its directions add is that of both.
        let with = Restricted::new(problem, columns, 0.0).beside().fitted(*start, true)?;
        let single = (-surprisal(deviance - with.restricted, freedom)).exp();
        Some((single * problem.policy.dependence_tests).min(1.0))
    }
}

impl JointRepeatability {
    /// Of these standard deviations, with what they displace the targets by (3-D RMS, m) and the p of none; nothing scatters beside them.
    pub fn known(joints: JointNoise, at_tool: f64, p_value: f64) -> Self {
        JointRepeatability { joints, p_value, at_tool, rows: NoiseModel::none() }
    }

    /// All components.
    pub(crate) fn noise(&self) -> Noise {
        Noise { rows: self.rows, joints: self.joints }
    }

    /// The same with the scatter of a problem's noise.
    pub(crate) fn under(self, linearisation: &Linearisation<'_>) -> Self {
        let Noise { rows, joints } = linearisation.noise;
        JointRepeatability { joints, rows, at_tool: at_tool(linearisation, joints), ..self }
    }

    /// What residuals of the rows of a linearised problem have to be multiplied with so that all poses scatter alike, by the mean square of all.
    pub(crate) fn weights(&self, linearisation: &Linearisation<'_>) -> Vec<f64> {
        let deviations = linearisation.deviations(self.noise());
        let mut of_pose = vec![(0.0, 0.0); linearisation.visits];
        for (o, sd) in linearisation.observations.iter().zip(&deviations).filter(|(o, _)| o.component < 3) {
            let (sum, count) = of_pose[o.visit];
            of_pose[o.visit] = (sum + sd * sd, count + 1.0);
        }
        let (sum, count) = of_pose.iter().fold((0.0, 0.0), |(a, b), (sum, count)| (a + sum, b + count));
        let mean: f64 = sum / f64::max(count, 1.0);
        let mut weights = vec![1.0; linearisation.data.len()];
        for (rows, (sum, count)) in Visits::of(linearisation.data).rows.iter().zip(&of_pose) {
            if *sum > 0.0 {
                rows.iter().for_each(|&row| weights[row] = (mean * count / sum).sqrt());
            }
        }
        weights
    }
}

/// 3-D RMS of what the joints move the targets by, m.
fn at_tool(linearisation: &Linearisation<'_>, joints: JointNoise) -> f64 {
    let scaled = linearisation.levers().scaled(joints);
    let positions = linearisation.observations.iter().enumerate().filter(|(_, o)| o.component < 3);
    let (sum, count) = positions
        .fold((0.0, 0.0), |(sum, count), (at, _)| (sum + scaled.row(at).norm_squared(), count + 1.0));
    (3.0 * sum / f64::max(count, 1.0)).sqrt()
}

impl Linearisation<'_> {
    /// Expected 3-D RMS of one new row around a perfect model, m.
    pub fn floor(&self, noise: Noise) -> f64 {
        let rows = noise.rows.floor(self.typical_sd());
        if noise.joints.is_some() { rows.hypot(at_tool(self, noise.joints)) } else { rows }
    }

    /// Standard deviation of every observation by itself, m or rad.
    pub fn deviations(&self, noise: Noise) -> Vec<f64> {
        let of_rows = |o: &Observation| match o.component {
            0..3 => noise.rows.position(self.data.position_sd[o.row][o.component]).hypot(noise.rows.visit_sd),
            _ => noise.rows.orientation(self.data.orientation_sd[o.row][o.component - 3]),
        };
        let mut deviations: Vec<f64> = self.observations.iter().map(of_rows).collect();
        if noise.joints.is_some() {
            let moved = self.levers().scaled(noise.joints);
            deviations.iter_mut().zip(moved.row_iter()).for_each(|(sd, row)| *sd = sd.hypot(row.norm()));
        }
        deviations
    }

    /// The same under the noise of the largest restricted likelihood, with the scatter of the joints from this start.
    pub fn beside_joints(mut self, start: JointNoise) -> Self {
        let noise = {
            let nothing = DMatrix::zeros(self.len(), 0);
            let restricted = Restricted::new(&self, &nothing, 0.0);
            restricted.fitted(Noise { rows: self.noise.rows, joints: start }, true).map(|found| found.noise())
        };
        if let Some(noise) = noise {
            self.noise = noise;
        }
        self
    }
}
