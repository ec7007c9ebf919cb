//! One hand brought to a pose in the axes of another one.
//!
//! ```text
//! find q_own with  T_other(q)⁻¹ T(q) = X_d        T(q_k+1) = T_other(q_k) X_d
//! ```
//!
//! Joints that carry the other hand stay, a torso that carries both among them. It moves nevertheless, by what the weight of this arm bends: the command is
//! sought again where the other hand then is, until it rests.

use super::Compensator;
use crate::CompensateError;
use crate::arm::Reached;
use crate::command::{Command, MOST, Status, Target};
use crate::options::CompensatorOptions;
use crate::real::RealArm;
use truepose_errormodel::{FittedModel, Schema};
use truepose_kinematics::{Chain, Conditions, FrameId, Pose, ToolId};

/// Commands that are sought at most: what a command changes of the bending shrinks from one to the next.
const ROUNDS: usize = 12;

/// The other hand of these options.
pub(super) fn other<'m>(
    fitted: &'m FittedModel,
    schema: &Schema,
    options: &CompensatorOptions,
) -> Result<Option<RealArm<'m>>, CompensateError> {
    let Some(tool) = options.relative_to else { return Ok(None) };
    if tool.0 >= fitted.chain().tools().len() || tool == options.tool {
        let (value, need) = (tool.0 as f64, "the number of another tool of the robot");
        return Err(CompensateError::Option { option: "relative_to", value, need });
    }
    Ok(Some(RealArm::bind(fitted, schema, tool)?))
}

/// Joints that a command does not move: those that do not carry the tool, those that carry the other hand, and those that are held.
pub(super) fn stays(chain: &Chain, options: &CompensatorOptions) -> [bool; MOST] {
    let mut stays = [false; MOST];
    let carries = |k: usize, tool: ToolId| {
        let own = |k: usize| chain.carries(FrameId(chain.movable()[k].0), tool);
        own(k) || chain.followers().iter().any(|follower| follower.driver == k && own(follower.joint))
    };
    for (k, stays) in stays.iter_mut().enumerate().take(chain.movable().len()) {
        *stays = !carries(k, options.tool)
            || options.relative_to.is_some_and(|other| carries(k, other))
            || options.hold.contains(&k);
    }
    stays
}

/// # Errors
/// When a joint that is held is none of the robot's, or moves with others: the controller then has no value of its own for it.
pub(super) fn can_hold(chain: &Chain, hold: &[usize]) -> Result<(), CompensateError> {
    for &k in hold {
        let refused = |need| Err(CompensateError::Option { option: "hold", value: k as f64, need });
        let Some(&joint) = chain.movable().get(k) else {
            return refused("the place of a joint among those that move");
        };
        let tied =
            |coupling: &truepose_kinematics::Coupling| [coupling.joint, coupling.driver].contains(&joint);
        if !chain.is_commanded(k) || chain.couplings().iter().any(tied) {
            return refused("a joint that moves alone, not one that is coupled or follows");
        }
    }
    Ok(())
}

impl Compensator<'_> {
    /// The command with which this hand is at a pose in the axes of the other one. Errors are those in these axes.
    pub(super) fn relative(
        &mut self,
        target: &Target,
        conditions: &Conditions,
        seed: Option<&[f64]>,
    ) -> Command {
        let Some(given) = seed.filter(|_| self.enter(target, conditions, seed).is_some()) else {
            return self.refused(seed);
        };
        let mut joints = [0.0; MOST];
        joints[..given.len()].copy_from_slice(given);
        let mut at = self.other_at(&joints[..given.len()], conditions);
        let mut rounds = 0;
        let mut command = self.refused(seed);
        for _ in 0..ROUNDS {
            let wanted = Target {
                position: at.apply(&target.position),
                orientation: target.orientation.map(|turn| at.rotation * turn),
                ..*target
            };
            command = self.absolute(&wanted, conditions, Some(&joints[..given.len()]));
            rounds += command.rounds;
            command.rounds = rounds;
            let next = self.other_at(&command.joints, conditions);
            let moved = (next.apply(&target.position) - wanted.position).norm();
            let turned = (next.rotation - at.rotation).norm();
            if command.status != Status::Ok {
                return command;
            }
            if moved <= self.options.position_tolerance && turned <= self.options.orientation_tolerance {
                command.position_error += moved;
                return command;
            }
            joints[..given.len()].copy_from_slice(&command.joints);
            at = next;
        }
        command.status = Status::NotConverged;
        command
    }

    /// Where the other hand really is, with this one's load.
    fn other_at(&mut self, joints: &[f64], conditions: &Conditions) -> Pose {
        let mut at = Reached::nowhere();
        self.take_over(conditions);
        self.conditions.joints.copy_from_slice(joints);
        if let Some(other) = &mut self.other {
            other.reach(&self.conditions, &mut at);
        }
        at.tool
    }
}
