//! Commands beyond the data of a fit with findings: those of the declared model, as far as the prediction falls back to it.
//!
//! ```text
//! q(x) = q_0(x) + w (q_1(x) − q_0(x))
//! ```
//!
//! with the share w of the findings at the command with all of them; to first order in the errors the real robot as
//! [`truepose_errormodel::Predictor::predict`] has it is then at the desired pose.

use super::Compensator;
use crate::CompensateError;
use crate::command::{Command, Status, Target};
use crate::options::CompensatorOptions;
use truepose_errormodel::{FittedModel, Predictor, Schema};
use truepose_kinematics::{Conditions, Pose, TargetId};

/// The declared model, and the judge of where it counts.
#[derive(Debug, Clone)]
pub(super) struct Beyond<'m> {
    predictor: Predictor<'m>,
    declared: Box<Compensator<'m>>,
    conditions: Conditions,
}

impl<'m> Beyond<'m> {
    /// None where nothing was found in data.
    pub fn bind(
        fitted: &'m FittedModel,
        schema: &Schema,
        options: &CompensatorOptions,
    ) -> Result<Option<Self>, CompensateError> {
        let Some(fallback) = &fitted.fallback else { return Ok(None) };
        Ok(Some(Beyond {
            predictor: fitted.bind(schema)?,
            declared: Box::new(Compensator::bind(&fallback.declared, schema, options.clone())?),
            conditions: Conditions {
                tool: options.tool,
                joints: vec![0.0; fitted.chain().movable().len()],
                approach: vec![0.0; fitted.chain().movable().len()],
                channels: vec![0.0; schema.channels.len()],
                ..Conditions::default()
            },
        }))
    }

    /// Where the real robot's target is.
    pub fn predict(&mut self, conditions: &Conditions, target: Option<TargetId>) -> Pose {
        self.conditions.clone_from(conditions);
        self.conditions.tool = self.declared.options.tool;
        self.predictor.predict(&self.conditions, target)
    }

    /// The command with as much of the findings as the prediction has there.
    pub fn fallen_back(&mut self, found: Command, target: &Target, conditions: &Conditions) -> Command {
        if found.status != Status::Ok {
            return found;
        }
        self.conditions.clone_from(conditions);
        self.conditions.tool = self.declared.options.tool;
        self.conditions.joints.clear();
        self.conditions.joints.extend_from_slice(&found.joints);
        self.conditions.approach.clear();
        self.conditions.approach.extend_from_slice(&found.approach);
        let share = self.predictor.share_of_findings(&self.conditions, target.target);
        if share >= 1.0 {
            return found;
        }
        let declared = self.declared.command(target, conditions, Some(&found.joints));
        if declared.status != Status::Ok {
            return found;
        }
        let mut command = found;
        for (joint, other) in command.joints.iter_mut().zip(declared.joints.iter()) {
            *joint = other + share * (*joint - other);
        }
        command
    }
}
