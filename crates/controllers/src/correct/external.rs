//! External axes of a program that are joints of the robot: they stay at the values that the program has. What they leave is an arm: that of the tool
//! that the other joints carry, where the robot branches.

use super::options::CorrectOptions;
use super::without_errors;
use crate::ControllerError;
use crate::program::{Point, Program};
use std::collections::BTreeMap;
use truepose_errormodel::FittedModel;
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, FrameId, Joint, JointKind, Placement, Pose, ToolId, rotation_vector};

/// The joints of the robot that are external axes of the program.
#[derive(Debug, Clone)]
pub(super) struct External {
    /// Name in the program, and place among the moving joints.
    axes: Vec<(String, usize)>,
    /// Places of the others, in the order of the program.
    pub(super) robot: Vec<usize>,
    /// The tool that all of these carry.
    pub(super) hand: ToolId,
    /// Whether no external axis stands behind a joint of the arm: all places of a track or a gantry leave one arm, elsewhere.
    front: bool,
}

/// Values of the external axes, variables.
pub(super) type Values = Vec<f64>;

impl External {
    /// # Errors
    /// When a joint is not there, or is named twice.
    pub(super) fn new(chain: &Chain, options: &CorrectOptions) -> Result<External, ControllerError> {
        let mut axes: Vec<(String, usize)> = Vec::new();
        for (axis, joint) in &options.external {
            let place = chain.movable().iter().position(|&id| chain.joint(id).name == *joint);
            let Some(place) = place else {
                let words =
                    format!("the external axis {axis} is to be the joint `{joint}`, which the fit has not");
                return Err(ControllerError::Option(words));
            };
            if axes.iter().any(|(other, k)| other.eq_ignore_ascii_case(axis) || *k == place) {
                let words = format!("the external axis {axis} or the joint {joint} is named twice");
                return Err(ControllerError::Option(words));
            }
            if chain
                .couplings()
                .iter()
                .any(|coupling| [coupling.joint, coupling.driver].contains(&chain.movable()[place]))
            {
                let words =
                    format!("the joint {joint} is coupled with another one, and cannot be an external axis");
                return Err(ControllerError::Option(words));
            }
            axes.push((axis.clone(), place));
        }
        let robot: Vec<usize> =
            (0..chain.movable().len()).filter(|k| !axes.iter().any(|(_, place)| place == k)).collect();
        let carried = |tool: &ToolId| robot.iter().all(|&k| carries(chain, k, *tool));
        let hand = (0..chain.tools().len()).map(ToolId).find(carried).unwrap_or(ToolId::FIRST);
        let first = robot.first().copied().unwrap_or(0);
        let front = axes.iter().all(|(_, place)| *place < first || !carries(chain, *place, hand));
        Ok(External { axes, robot, hand, front })
    }

    /// Their places among the moving joints.
    pub(super) fn places(&self) -> Vec<usize> {
        self.axes.iter().map(|(_, place)| *place).collect()
    }

    /// The values that a point has.
    ///
    /// # Errors
    /// When it has none, or an axis at another value than zero that is no joint.
    pub(super) fn values(
        &self,
        chain: &Chain,
        point: &Point,
        options: &CorrectOptions,
        length: f64,
    ) -> Result<Values, String> {
        let is = |name: &str, axis: &str| name.eq_ignore_ascii_case(axis);
        let other = point
            .external
            .iter()
            .find(|(name, value)| *value != 0.0 && !self.axes.iter().any(|(axis, _)| is(name, axis)));
        if let Some((name, value)) = other.filter(|_| !options.ignore_external) {
            return Err(format!(
                "external axis {name} is at {value}: whether it moves the robot or its work is not known (--external {name}=JOINT where \
                 it is a joint of the fit, --ignore-external where it moves neither)"
            ));
        }
        let one = |(axis, place): &(String, usize)| {
            let found = point.external.iter().find(|(name, value)| is(name, axis) && value.is_finite());
            let Some((_, value)) = found else {
                return Err(format!("it has no value of the external axis {axis}"));
            };
            let turns = chain.joint(chain.movable()[*place]).kind == JointKind::Revolute;
            Ok(value * if turns { 1f64.to_radians() } else { length })
        };
        self.axes.iter().map(one).collect()
    }

    /// How far the arm is from where it is with its external axes at zero, in the base of the description.
    pub(super) fn shift(&self, chain: &Chain, values: &[f64]) -> Pose {
        if !self.front || self.axes.is_empty() {
            return Pose::IDENTITY;
        }
        let arm = vec![0.0; self.robot.len()];
        let at = |values: &[f64]| chain.forward_to(self.hand, &self.whole(&arm, values));
        let base = chain.base().pose.inverse();
        base * at(values) * at(&vec![0.0; values.len()]).inverse() * base.inverse()
    }

    /// The robot's joints of all.
    pub(super) fn of_robot(&self, joints: &[f64]) -> Vec<f64> {
        self.robot.iter().filter_map(|&k| joints.get(k)).copied().collect()
    }

    /// All joints of the robot's and the external axes' values.
    pub(super) fn whole(&self, robot: &[f64], values: &[f64]) -> Vec<f64> {
        let mut joints = vec![0.0; self.robot.len() + self.axes.len()];
        self.robot.iter().zip(robot).for_each(|(&k, value)| joints[k] = *value);
        self.axes.iter().zip(values).for_each(|((_, k), value)| joints[*k] = *value);
        joints
    }

    /// The arm with its external axes held at some values.
    fn held(&self, chain: &Chain, values: &[f64]) -> Option<Chain> {
        let mut joints = chain.joints().to_vec();
        for ((_, place), &value) in self.axes.iter().zip(values) {
            let joint =
                joints.iter_mut().find(|joint| joint.name == chain.joint(chain.movable()[*place]).name)?;
            let turns = joint.kind == JointKind::Revolute;
            match &mut joint.placement {
                Placement::Dh { theta, d, .. } | Placement::Mdh { theta, d, .. } => {
                    *(if turns { theta } else { d }) += value;
                }
                Placement::Origin { pose, axis } => {
                    let way = axis.into_inner() * value;
                    let motion = match turns {
                        true => Pose::new(rotation_vector(&way), Vector3::zeros()),
                        false => Pose::new(Pose::IDENTITY.rotation, way),
                    };
                    *pose = *pose * motion;
                }
            }
            joint.kind = JointKind::Fixed;
            joint.limits = None;
        }
        rebuilt(chain, self.hand, joints)
    }
}

/// Whether a moving joint carries a tool.
pub(super) fn carries(chain: &Chain, k: usize, tool: ToolId) -> bool {
    chain.carries(FrameId(chain.movable()[k].0), tool)
}

/// The arm of one tool with other joints, with base, tool and couplings of this one.
fn rebuilt(chain: &Chain, hand: ToolId, joints: Vec<Joint>) -> Option<Chain> {
    let count = joints.len();
    let own = joints.into_iter().enumerate().filter(|(k, _)| chain.carries(FrameId(k + 1), hand));
    let own: Vec<Joint> = own.map(|(_, joint)| joint).collect();
    // Couplings are by the numbers of the joints.
    if !chain.mimics().is_empty() || (own.len() < count && !chain.couplings().is_empty()) {
        return None;
    }
    let new = Chain::new(chain.name(), own).ok()?;
    let new = new.with_base(*chain.base()).ok()?.with_tool(chain.tools()[hand.0].placed).ok()?;
    new.with_couplings(chain.couplings().to_vec()).ok()
}

/// Arms without errors, with and without limits, for each place of external axes that stand behind joints of the arm.
#[derive(Debug)]
pub(super) struct Arms {
    all: Vec<(FittedModel, Option<FittedModel>)>,
    places: BTreeMap<Vec<u64>, usize>,
}

impl Arms {
    /// Of all points of the programs.
    pub(super) fn of(
        chain: &Chain,
        external: &External,
        programs: &[Program],
        options: &CorrectOptions,
    ) -> Result<Arms, ControllerError> {
        let mut arms = Arms { all: Vec::new(), places: BTreeMap::new() };
        if external.axes.is_empty() {
            arms.add(&[], chain.clone())?;
            return Ok(arms);
        }
        if external.front {
            if let Some(held) = external.held(chain, &vec![0.0; external.axes.len()]) {
                arms.add(&[], held)?;
            }
            return Ok(arms);
        }
        for (program, point) in programs.iter().flat_map(|p| p.points().iter().map(move |point| (p, point))) {
            let Ok(values) = external.values(chain, point, options, program.dialect().length()) else {
                continue;
            };
            if !arms.places.contains_key(&key(&values))
                && let Some(held) = external.held(chain, &values)
            {
                arms.add(&values, held)?;
            }
        }
        Ok(arms)
    }

    fn add(&mut self, values: &[f64], chain: Chain) -> Result<(), ControllerError> {
        let mut free = chain.joints().to_vec();
        free.iter_mut().for_each(|joint| joint.limits = None);
        let free = rebuilt(&chain, ToolId::FIRST, free).map(without_errors).transpose()?;
        self.places.insert(key(values), self.all.len());
        self.all.push((without_errors(chain)?, free));
        Ok(())
    }

    /// The place of the arm with the external axes there.
    pub(super) fn place(&self, external: &External, values: &[f64]) -> Option<usize> {
        let values = if external.front { &[] } else { values };
        self.places.get(&key(values)).copied()
    }

    /// All of them.
    pub(super) fn all(&self) -> &[(FittedModel, Option<FittedModel>)] {
        &self.all
    }
}

fn key(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}
