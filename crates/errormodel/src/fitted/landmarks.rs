//! A fit without the landmarks that it was made with: the robot alone.

use super::both_sides::both_sides;
use super::domain::Domain;
use super::model::{Fallback, FittedModel};
use super::sample::Sample;
use crate::dataset::of_observation;
use crate::effects::{Landmarks, Observed};
use crate::{AnyEffect, Effect, ErrorModel, LANDMARK, ModelError};
use nalgebra::{DMatrix, Vector3};
use truepose_kinematics::{ChainError, TargetId};

impl FittedModel {
    /// By how much each landmark is displaced from where the data has it, m, measurement frame; none without landmarks.
    pub fn landmarks_displaced(&self) -> Option<Vec<Vector3<f64>>> {
        let model = self.model();
        let (at, effect) = model.find::<Landmarks>()?;
        let own = &self.coefficients()[model.columns_of(at)];
        Some((0..effect.points.len()).map(|point| effect.displaced(point, own)).collect())
    }

    /// The unknowns of each sensor, as the fit has moved them from where the data has them; none without sensors.
    pub fn sensors_moved(&self) -> Option<Vec<Vec<f64>>> {
        let model = self.model();
        let (at, effect) = model.find::<Observed>()?;
        let own = &self.coefficients()[model.columns_of(at)];
        Some((0..effect.sensors.len()).map(|sensor| own[effect.columns_of(sensor)].to_vec()).collect())
    }

    /// Standard deviations of the unknowns of each sensor, in their units; zero of those that the fit leaves where they are. None without sensors.
    pub fn sensors_uncertain(&self) -> Option<Vec<Vec<f64>>> {
        let model = self.model();
        let (at, effect) = model.find::<Observed>()?;
        let first = model.columns_of(at).start;
        let sd = |k: usize| self.covariance()[(first + k, first + k)].max(0.0).sqrt();
        Some((0..effect.sensors.len()).map(|sensor| effect.columns_of(sensor).map(sd).collect()).collect())
    }

    /// The robot alone: landmarks and sensors are no part of it, and no channel is read for them. The covariance of what stays is the marginal
    /// one; rows of the sample stand where their landmark is, those of a contact where the robot has its points.
    ///
    /// # Errors
    /// When the remaining effects do not fit the robot, which cannot be where they did.
    pub fn without_landmarks(&self) -> Result<Self, ModelError> {
        let model = self.model();
        let own = [Landmarks::FAMILY, Observed::FAMILY];
        let landmark = |k: usize| own.contains(&model.effects()[model.effect_of(k)].kind());
        let kept: Vec<usize> = (0..self.coefficients().len()).filter(|&k| !landmark(k)).collect();
        let hidden = |name: &str| name == LANDMARK || of_observation(name);
        if !model.effects().iter().any(|effect| own.contains(&effect.kind()))
            && !self.channels.iter().any(|channel| hidden(&channel.name))
            && !self.domain.sample.rows().any_met()
        {
            return Ok(self.clone());
        }
        let effects: Vec<Box<dyn AnyEffect>> =
            model.effects().iter().filter(|effect| !own.contains(&effect.kind())).cloned().collect();
        let all = self.covariance();
        let covariance = DMatrix::from_fn(kept.len(), kept.len(), |i, j| all[(kept[i], kept[j])]);
        let coefficients = kept.iter().map(|&k| self.coefficients()[k]).collect();
        let model = ErrorModel::new(self.chain().clone(), effects)?;
        let mut alone = FittedModel::new(model, coefficients, covariance)?.like(self);
        alone.sessions.clone_from(&self.sessions);
        while let Some(k) = alone.channels.iter().position(|channel| hidden(&channel.name)) {
            alone.channels.remove(k);
            if k < alone.domain.channels.len() {
                alone.domain.channels.remove(k);
            }
        }
        let mut rows = both_sides(&alone, self.domain.sample.rows())?;
        if let Some(displaced) = self.landmarks_displaced() {
            for row in 0..rows.len() {
                if let Some(by) = rows.landmark(row).and_then(|k| displaced.get(k)) {
                    rows.position[row] = (rows.measured_position(row) + by).into();
                }
            }
        }
        rows.set_landmarks(None);
        rows.forget_observations();
        alone.domain.sample = Sample::stored(rows, self.domain.sample.drawn_from());
        alone.fallback = match &self.fallback {
            Some(fallback) => {
                let declared = std::sync::Arc::new(fallback.declared.without_landmarks()?);
                Some(Fallback { declared, ..fallback.clone() })
            }
            None => None,
        };
        Ok(alone)
    }

    /// The same without targets that rows had of their own ([`truepose_kinematics::SEEN`]): no later pose has them.
    ///
    /// # Errors
    /// When an effect does not fit the robot without them.
    pub fn without_seen(&self) -> Result<Self, ModelError> {
        let described = self.chain().described_targets().to_vec();
        if described.len() == self.chain().targets().len() {
            return Ok(self.clone());
        }
        let kept = |target: Option<TargetId>| target.filter(|target| target.0 < described.len());
        let mut rows = self.domain.sample.rows().clone();
        rows.target.iter_mut().for_each(|target| *target = kept(*target));
        let sample = Sample::stored(rows, self.domain.sample.drawn_from());
        let mut targets: Vec<Option<TargetId>> =
            self.domain.targets.iter().map(|target| kept(*target)).collect();
        targets.sort_unstable();
        targets.dedup();
        let domain = Domain { targets, sample, ..self.domain.clone() };
        let refused = |error: ChainError| ModelError::Parameters {
            kind: Observed::FAMILY.into(),
            reason: error.to_string(),
        };
        let chain = self.chain().clone().with_targets(described).map_err(refused)?;
        Ok(self.on(chain)?.with_domain(domain))
    }
}
