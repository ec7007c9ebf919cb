//! The robot with its constant errors worked into its geometry.
//!
//! ```text
//! A_i = pre_i M(q_i) post_i
//! origin of joint i+1 = post_i E_i pre_{i+1},    base' = B E_0,    tool' = post_n E_n tool E_tool,    target' = p + ε_p
//! ```
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | pre, post | constants around a joint's motion | pose | m | frame i−1, frame i |
//! | origin | `Placement::Origin` | pose | m | of the joint in the frame of the one before |
//!
//! Joints that were described by origin and axis keep their axis and the frame behind them, as a URDF has them; joints
//! of a DH or MDH row become origin and axis z.

use super::comparison::of_chain;
use super::options::ExportOptions;
use super::project::project;
use super::reference::Reference;
use super::remaining::{Exported, judged, not_constant};
use crate::CompensateError;
use nalgebra::{Unit, Vector3};
use truepose_errormodel::{Emission, FittedModel, GeneralizedErrors, error_matrix};
use truepose_kinematics::{
    Chain, Conditions, FrameId, Joint, JointId, JointKind, Placed, Placement, Pose, PostureBuffer, Target,
    TargetId, ToolId,
};

/// The nominal robot with corrected joint origins, base, tool and targets: the constant errors that come nearest to the whole model at
/// the configurations of the fit. Names, limits, masses and gravity stay.
///
/// # Errors
/// When the conditions do not fit the model, or the corrected robot would be worse than the nominal one.
pub fn corrected_chain(
    fitted: &FittedModel,
    options: &ExportOptions,
) -> Result<Exported<Chain>, CompensateError> {
    Ok(corrected(fitted, &Reference::of(fitted, options)?)?.0)
}

/// [`corrected_chain`] at these configurations, with the constants that are in it.
pub(super) fn corrected(
    fitted: &FittedModel,
    reference: &Reference,
) -> Result<(Exported<Chain>, GeneralizedErrors), CompensateError> {
    let left_out = not_constant(fitted);
    let mut constants = constant_errors(fitted)?;
    if !left_out.is_empty() {
        constants = project(fitted.chain(), reference, &constants, None)?.constants;
    }
    let chain = with_errors(fitted.chain(), &constants)?;
    let (remaining_error, comparison) = judged(fitted, reference, |row| of_chain(&chain, row))?;
    Ok((Exported { value: chain, left_out, remaining_error, comparison }, constants))
}

/// The sum of all effects that are constant generalized errors and nothing else.
pub(super) fn constant_errors(fitted: &FittedModel) -> Result<GeneralizedErrors, CompensateError> {
    let model = fitted.model();
    let chain = fitted.chain();
    let conditions = Conditions::at(chain, &vec![0.0; chain.movable().len()]);
    let mut buffer = PostureBuffer::new(chain);
    let posture = buffer.update(chain, &conditions);
    let mut errors = GeneralizedErrors::zero(chain);
    let mut emission = Emission::new();
    for (k, effect) in model.effects().iter().enumerate() {
        let columns = model.columns_of(k);
        if model.columns()[columns.clone()].iter().all(|c| c.site.is_some()) {
            emission.clear();
            effect.eval(&posture, &mut emission);
            for entry in emission.entries() {
                errors.add(entry.site, entry.value * fitted.coefficients()[columns.start + entry.column]);
            }
        }
    }
    Ok(errors)
}

/// A robot whose geometry has these errors in it.
pub(super) fn with_errors(chain: &Chain, errors: &GeneralizedErrors) -> Result<Chain, CompensateError> {
    let e = |frame: usize| error_matrix(&errors.frame(FrameId(frame)));
    let mut joints: Vec<Joint> = Vec::new();
    // Behind the motion of each frame: what the joints and tools on it begin with.
    let mut behind = vec![Pose::IDENTITY];
    for (index, joint) in chain.joints().iter().enumerate() {
        let (pre, post, axis) = split(chain, JointId(index + 1));
        let pose = behind[chain.before(JointId(index + 1)).0] * pre;
        let mut corrected = joint.clone();
        corrected.placement = Placement::Origin { pose, axis };
        if let Some(link) = &mut corrected.link {
            // Its centre stays where it was in the frame behind the joint, which for a DH row has moved to its front.
            link.com = post.apply(&link.com);
        }
        joints.push(corrected);
        behind.push(post * e(index + 1));
    }
    let base = Placed { pose: chain.base().pose * e(0), known: chain.base().known };
    let tools: Vec<Placed> = chain
        .tools()
        .iter()
        .enumerate()
        .map(|(k, tool)| {
            let error = e(chain.frame_of_tool(ToolId(k)).0);
            Placed { pose: behind[tool.frame.0] * tool.placed.pose * error, ..tool.placed }
        })
        .collect();
    let targets = chain.targets().iter().enumerate().map(|(k, target)| Target {
        position: target.position + errors.target(TargetId(k)),
        ..target.clone()
    });
    Ok(Chain::new(chain.name(), joints)?
        .coupled_as(chain)?
        .branched_as(chain)?
        .with_base(base)?
        .with_placed_tools(&tools)?
        .with_gravity(*chain.gravity())?
        .with_targets(targets.collect())?)
}

/// `pre`, `post` and axis of a joint, so that A(q) = pre · M(axis, q) · post.
pub(super) fn split(chain: &Chain, id: JointId) -> (Pose, Pose, Unit<Vector3<f64>>) {
    let joint = chain.joint(id);
    let at_zero = joint.transform(0.0);
    match joint.placement {
        Placement::Origin { pose, axis } => (pose, Pose::IDENTITY, axis),
        Placement::Dh { .. } if joint.kind != JointKind::Fixed => {
            (Pose::IDENTITY, at_zero, Vector3::z_axis())
        }
        _ => (at_zero, Pose::IDENTITY, Vector3::z_axis()),
    }
}
