//! What becomes of a point whose joints are known.

use super::correction::{Correction, Outcome};
use super::corrector::Corrector;
use super::lean::{Lean, Seen};
use super::outside::outside;
use super::placed::{Placed, Stays};
use super::singular::singular;
use crate::program::{Branch, Point, Value};
use crate::reference::Carried;
use truepose_compensate::{Status, Target, correction_helps, radius_95};
use truepose_errormodel::Judged;
use truepose_kinematics::nalgebra::Matrix3;
use truepose_kinematics::{Chain, Conditions, Load, Payload, Pose, PostureBuffer, rotation_log};

impl<'m> Corrector<'m> {
    /// Fills the correction in.
    pub(super) fn judged(
        &mut self,
        point: &Point,
        joints: &[f64],
        mut placed: Option<Placed>,
        correction: &mut Correction,
    ) -> Result<(), Stays> {
        self.conditions.load = self.load(&point.carried);
        let on = placed.as_mut().and_then(|placed| self.carried(placed, joints));
        let placed = placed.as_ref();
        let flange = match placed {
            Some(placed) => placed.flange(),
            None => self.flange(joints),
        };
        let meant = placed.map_or(flange, Placed::meant);
        let desired = self.installation.base * meant * self.installation.tool;
        correction.desired = Some(desired.translation.into());
        self.conditions.joints = joints.to_vec();
        let lean = self.lean(point, &desired, on.as_ref());
        let here = self.coverage.judge(&self.conditions, None);
        outside(self.fitted, &self.channels, &self.conditions, &here.beyond)?;
        let error = here.pose.translation - desired.translation;
        let open = self.open(&here, lean.as_ref());
        if !correction_helps(&error, &open) {
            correction.outcome = Outcome::NotSignificant;
            correction.reason = "the correction is smaller than its uncertainty".into();
            let reach = radius_95(&(open + self.noise));
            correction.within_95 = Some(reach + error.norm());
            return Ok(());
        }
        // At a singularity of the wrist a small correction turns joints far.
        let robot = self.external.of_robot(joints);
        let arm: &'m Chain = self.arms.all()[self.at].0.chain();
        let mut buffer = PostureBuffer::new(arm);
        let outcome = if self.inverse()?.stretched(&robot) { Outcome::Singular } else { Outcome::Refused };
        let singularity = |reason| Stays { outcome, reason };
        // Where a joint has no effect of its own, no search finds anything.
        singular(arm, &mut buffer, &robot, &robot).map_err(singularity)?;
        let found = self.commanded(joints, &desired)?;
        let command = self.external.of_robot(&found);
        singular(arm, &mut buffer, &robot, &command).map_err(singularity)?;
        self.conditions.joints.clone_from(&found);
        let there = self.coverage.judge(&self.conditions, None);
        outside(self.fitted, &self.channels, &self.conditions, &there.beyond)?;
        correction.within_95 = Some(radius_95(&(self.open(&there, lean.as_ref()) + self.noise)));
        let branch = placed.map_or(&Branch::Continuous, |placed| &placed.branch);
        if !self.inverse()?.same(&robot, &command, branch) {
            let words = "the correction changes the arm's configuration: the point is at a singularity";
            return Err(singularity(words.into()));
        }
        let new = self.flange(&found);
        let moved = match placed {
            // Of the tool centre point, in the axes of the base.
            Some(placed) => {
                let before = flange * placed.behind;
                let after = new * placed.behind;
                (after.translation - before.translation, before.rotation.transpose() * after.rotation)
            }
            None => {
                let (before, after) = (flange * self.installation.tool, new * self.installation.tool);
                (after.translation - before.translation, before.rotation.transpose() * after.rotation)
            }
        };
        correction.displacement = Some(moved.0.into());
        correction.rotation = Some(rotation_log(&moved.1).norm());
        correction.corrected = Some(self.controller(&found));
        if moved.0.norm() > self.options.limit {
            return Err(format!(
                "the correction of {:.3} mm is above the limit of {:.3} mm",
                1e3 * moved.0.norm(),
                1e3 * self.options.limit
            )
            .into());
        }
        correction.replacement = Some(self.replacement(point, &found, &new, placed)?);
        correction.outcome = Outcome::Corrected;
        Ok(())
    }

    /// Where the frame on a positioner really is, and how that depends on the fit; none: it is on none.
    fn carried(&mut self, placed: &mut Placed, joints: &[f64]) -> Option<Seen> {
        let (tool, frame) = placed.on?;
        let conditions =
            Conditions { tool, joints: joints.to_vec(), load: Load::None, ..self.conditions.clone() };
        let pose = self.coverage.judge(&conditions, None).pose;
        placed.real[0] = self.installation.base.inverse() * pose * frame;
        Some(Seen { pose, rows: self.predictor.sensitivity(&conditions, None) })
    }

    /// How the desired position leans on the fit: relative to a positioner, or to what was taught.
    fn lean(&mut self, point: &Point, desired: &Pose, on: Option<&Seen>) -> Option<Lean> {
        let Value::Pose { frame, tool, .. } = &point.value else { return None };
        let flange = desired.rotation
            * self.installation.tool.rotation.transpose()
            * self.options.controller_flange.rotation;
        let names = (self.frames.name(frame), self.frames.name(tool));
        let taught = self.learned.lean(names, &desired.translation, &flange);
        let Some(on) = on else { return taught };
        let work = on.point(&desired.translation, self.fitted.noise.position_sd);
        let mut lean = taught.unwrap_or_else(|| Lean::none(work.rows.ncols()));
        lean.add(&Matrix3::identity(), &work);
        Some(lean)
    }

    /// What the coefficients leave open of the distance from the desired position, m².
    fn open(&mut self, at: &Judged, lean: Option<&Lean>) -> Matrix3<f64> {
        match lean {
            None => at.covariance,
            Some(lean) => lean.covariance(self.fitted, &self.predictor.sensitivity(&self.conditions, None)),
        }
    }

    /// What the robot carries at a point.
    fn load(&self, carried: &Carried) -> Load {
        match carried {
            Carried::Mass { mass, com, .. } if self.options.program_loads => {
                let in_tool = self.installation.tool.inverse() * self.options.controller_flange;
                Load::Payload(Payload { mass: *mass, com: in_tool.apply(com) })
            }
            _ => self.options.load,
        }
    }

    /// Joints that bring the real robot there; external axes stay.
    fn commanded(&mut self, joints: &[f64], desired: &Pose) -> Result<Vec<f64>, String> {
        let mut target = Target::at(desired.translation);
        target.orientation = (self.external.robot.len() >= 6).then_some(desired.rotation);
        let command = self.real.command(&target, &self.conditions, Some(joints));
        match command.status {
            Status::Ok => Ok(command.joints.to_vec()),
            Status::Limit => Err("only joint values beyond their limits would reach it".into()),
            Status::Unreachable => Err("the real robot does not reach it".into()),
            Status::NotConverged => Err("no joint values were found that reach it".into()),
        }
    }
}
