//! A fit without the landmarks that it was made with: the robot alone.

use super::model::{Fallback, FittedModel};
use super::sample::Sample;
use crate::effects::Landmarks;
use crate::{AnyEffect, Effect, ErrorModel, LANDMARK, ModelError};
use nalgebra::{DMatrix, Vector3};
use std::any::Any;

impl FittedModel {
    /// By how much each landmark is displaced from where the data has it, m, measurement frame; none without landmarks.
    pub fn landmarks_displaced(&self) -> Option<Vec<Vector3<f64>>> {
        let model = self.model();
        let (at, effect) = model.effects().iter().enumerate().find_map(|(k, effect)| {
            (&**effect as &dyn Any).downcast_ref::<Landmarks>().map(|effect| (k, effect))
        })?;
        let own = &self.coefficients()[model.columns_of(at)];
        Some((0..effect.points.len()).map(|point| effect.displaced(point, own)).collect())
    }

    /// The robot alone: landmarks are no part of it, and no channel is read for them. The covariance of what stays is the marginal one; rows
    /// of the sample stand where their landmark is.
    ///
    /// # Errors
    /// When the remaining effects do not fit the robot, which cannot be where they did.
    pub fn without_landmarks(&self) -> Result<Self, ModelError> {
        let model = self.model();
        let landmark = |k: usize| model.effects()[model.effect_of(k)].kind() == Landmarks::FAMILY;
        let kept: Vec<usize> = (0..self.coefficients().len()).filter(|&k| !landmark(k)).collect();
        if kept.len() == self.coefficients().len() {
            return Ok(self.clone());
        }
        let effects: Vec<Box<dyn AnyEffect>> =
            model.effects().iter().filter(|effect| effect.kind() != Landmarks::FAMILY).cloned().collect();
        let all = self.covariance();
        let covariance = DMatrix::from_fn(kept.len(), kept.len(), |i, j| all[(kept[i], kept[j])]);
        let coefficients = kept.iter().map(|&k| self.coefficients()[k]).collect();
        let model = ErrorModel::new(self.chain().clone(), effects)?;
        let mut alone = FittedModel::new(model, coefficients, covariance)?.like(self);
        alone.sessions.clone_from(&self.sessions);
        if let Some(k) = alone.channels.iter().position(|channel| channel.name == LANDMARK) {
            alone.channels.remove(k);
            if k < alone.domain.channels.len() {
                alone.domain.channels.remove(k);
            }
        }
        if let Some(displaced) = self.landmarks_displaced() {
            let mut rows = self.domain.sample.rows().clone();
            for row in 0..rows.len() {
                if let Some(by) = rows.landmark(row).and_then(|k| displaced.get(k)) {
                    rows.position[row] = (rows.measured_position(row) + by).into();
                }
            }
            rows.set_landmarks(None);
            alone.domain.sample = Sample::stored(rows, self.domain.sample.drawn_from());
        }
        alone.fallback = match &self.fallback {
            Some(fallback) => {
                let declared = std::sync::Arc::new(fallback.declared.without_landmarks()?);
                Some(Fallback { declared, ..fallback.clone() })
            }
            None => None,
        };
        Ok(alone)
    }
}
