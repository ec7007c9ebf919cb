//! A fit of several installations, in one of them.
//!
//! ```text
//! p_k = X_k⁻¹ p_0,     X_k = B_0 B_k⁻¹        B_k: base of session k, measurement frame k ← frame 0
//! ```
//!
//! All rows of a fit are in the measurement frame of its first session; a fit in session k has the base B_k = X_k⁻¹ B_0 and predicts in the
//! frame k.

use super::model::{Fallback, FittedModel};
use super::sample::Sample;
use crate::effects::Session;
use crate::{AnyEffect, Effect, ErrorModel, ModelError, SESSION};
use truepose_kinematics::{Placed, Pose, Target, TargetId};

/// The name of a session's own target.
pub fn own_target(target: &str, session: &str) -> String {
    format!("{target}@{session}")
}

impl FittedModel {
    /// The fit in one of its sessions, by the session's number: it reads no session any more and predicts in that session's frame. A fit of
    /// one installation is as it was.
    ///
    /// # Errors
    /// When it has no session of this number.
    pub fn in_session(&self, number: usize) -> Result<Self, ModelError> {
        if self.sessions.is_empty() {
            return Ok(self.clone());
        }
        let Some(installed) = self.sessions.get(number) else {
            return Err(ModelError::Shape { what: "sessions", have: self.sessions.len(), need: number + 1 });
        };
        let chain = self.chain().clone();
        let known = chain.base().known;
        let pose = (installed.frame.inverse() * chain.base().pose).renormalised();
        let chain = chain
            .with_base(Placed { pose, known })
            .and_then(|chain| {
                let targets = self.targets_in_session(number);
                chain.with_targets(targets)
            })
            .map_err(|error| ModelError::Parameters {
                kind: Session::FAMILY.into(),
                reason: error.to_string(),
            })?;
        let chosen = |effect: &dyn AnyEffect| -> Box<dyn AnyEffect> {
            match effect.concrete::<Session>() {
                Some(session) => {
                    effect.replaced(Box::new(Session { chosen: Some(number), ..session.clone() }))
                }
                None => effect.boxed(),
            }
        };
        let model =
            ErrorModel::new(chain, self.model().effects().iter().map(|effect| chosen(&**effect)).collect())?;
        // Installations of other sessions say nothing here.
        let (mut coefficients, mut covariance) = (self.coefficients().to_vec(), self.covariance().clone());
        let columns = model.columns();
        let elsewhere = |&k: &usize| {
            model.effects()[model.effect_of(k)].kind() == Session::FAMILY && columns[k].site.is_none()
        };
        for k in (0..coefficients.len()).filter(elsewhere) {
            coefficients[k] = 0.0;
            covariance.row_mut(k).fill(0.0);
            covariance.column_mut(k).fill(0.0);
        }
        let mut one = FittedModel::new(model, coefficients, covariance)?.like(self);
        let sample = self.domain.sample.in_session(number, &installed.frame.inverse());
        if let Some(k) = one.channels.iter().position(|channel| channel.name == SESSION) {
            one.channels.remove(k);
            if k < one.domain.channels.len() {
                one.domain.channels.remove(k);
            }
        }
        one.domain.sample = sample;
        one.fallback = match &self.fallback {
            Some(fallback) => {
                let mut declared = (*fallback.declared).clone();
                declared.sessions.clone_from(&self.sessions);
                let declared = std::sync::Arc::new(declared.in_session(number)?);
                Some(Fallback { declared, ..fallback.clone() })
            }
            None => None,
        };
        Ok(one)
    }

    /// The targets by the names that they have in a session: its own ones are called as those of the first session are.
    fn targets_in_session(&self, number: usize) -> Vec<Target> {
        let mut targets = self.chain().targets().to_vec();
        for target in (0..targets.len()).map(TargetId) {
            let own = self.target_in_session(target, number);
            if own != target {
                let name = targets[target.0].name.clone();
                targets[target.0].name = own_target(&name, &self.sessions[0].name);
                targets[own.0].name = name;
            }
        }
        targets
    }

    /// The target that a session's rows of this target show: the session's own one, where it has one.
    pub fn target_in_session(&self, target: TargetId, number: usize) -> TargetId {
        let targets = self.chain().targets();
        let (Some(named), Some(session)) = (targets.get(target.0), self.sessions.get(number)) else {
            return target;
        };
        let own = own_target(&named.name, &session.name);
        targets.iter().position(|t| t.name == own).map_or(target, TargetId)
    }
}

impl Sample {
    /// The rows of one session, from the measurement frame of the first into its own.
    fn in_session(&self, number: usize, frame: &Pose) -> Sample {
        let rows = self.rows();
        let kept: Vec<usize> = (0..rows.len()).filter(|&row| rows.session(row) == number).collect();
        let mut rows = rows.select(&kept);
        rows.record = None;
        rows.set_sessions(None);
        rows.carry(frame);
        Sample::stored(rows, self.drawn_from())
    }
}
