//! The robot inside of a fit file, format 1: SI units, rotations as matrices, so that it comes back to the bit.

use serde::{Deserialize, Serialize};
use truepose_kinematics::nalgebra::{Matrix3, Unit, Vector3};
use truepose_kinematics::{
    Chain, ChainError, Coupling, Gravity, GravityFrame, Joint, JointId, JointKind, Link, Mimic, Placed,
    Placement, Pose, Target, Tool, ToolId,
};

/// Rows of a rotation matrix are orthonormal to this.
const ORTHONORMAL: f64 = 1e-9;

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct RobotV1 {
    name: String,
    gravity: GravityV1,
    base: PlacedV1,
    joints: Vec<JointV1>,
    tool: PlacedV1,
    targets: Vec<TargetV1>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    couplings: Vec<CouplingV1>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    mimics: Vec<MimicV1>,
    /// Of a robot that branches: the number of the joint in front of each joint; zero: the base.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    parents: Vec<usize>,
    /// All tools, where there are several, or the only one is not on the last joint.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    tools: Vec<ToolV1>,
}

/// A tool behind a joint, by its number; zero: on the base.
#[derive(Debug, Serialize, Deserialize)]
struct ToolV1 {
    name: String,
    joint: usize,
    #[serde(flatten)]
    placed: PlacedV1,
}

/// Joints by number, from 1.
#[derive(Debug, Serialize, Deserialize)]
struct CouplingV1 {
    joint: usize,
    driver: usize,
    factor: f64,
}

/// Joints by number, from 1.
#[derive(Debug, Serialize, Deserialize)]
struct MimicV1 {
    joint: usize,
    driver: usize,
    ratio: f64,
    offset: f64,
}

#[derive(Debug, Serialize, Deserialize)]
struct GravityV1 {
    vector: [f64; 3],
    frame: GravityFrameV1,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum GravityFrameV1 {
    Measurement,
    Base,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct PoseV1 {
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

#[derive(Debug, Serialize, Deserialize)]
struct PlacedV1 {
    pose: PoseV1,
    known: bool,
}

#[derive(Debug, Serialize, Deserialize)]
struct JointV1 {
    name: String,
    #[serde(rename = "type")]
    kind: KindV1,
    placement: PlacementV1,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    limits: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    link: Option<LinkV1>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum KindV1 {
    Revolute,
    Prismatic,
    Fixed,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum PlacementV1 {
    Dh { theta: f64, d: f64, a: f64, alpha: f64 },
    Mdh { alpha: f64, a: f64, theta: f64, d: f64 },
    Origin { pose: PoseV1, axis: [f64; 3] },
}

#[derive(Debug, Serialize, Deserialize)]
struct LinkV1 {
    mass: f64,
    com: [f64; 3],
}

#[derive(Debug, Serialize, Deserialize)]
struct TargetV1 {
    name: String,
    position: [f64; 3],
    known: bool,
    /// Number of its tool, from zero.
    #[serde(default, skip_serializing_if = "is_first")]
    tool: usize,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde calls it
fn is_first(tool: &usize) -> bool {
    *tool == 0
}

impl From<&Chain> for RobotV1 {
    fn from(chain: &Chain) -> Self {
        let frame = match chain.gravity().frame {
            GravityFrame::Measurement => GravityFrameV1::Measurement,
            GravityFrame::Base => GravityFrameV1::Base,
        };
        let target = |target: &Target| TargetV1 {
            name: target.name.clone(),
            position: target.position.into(),
            known: target.known,
            tool: target.tool.0,
        };
        let tool = |tool: &Tool| ToolV1 {
            name: tool.name.clone(),
            joint: tool.frame.0,
            placed: (&tool.placed).into(),
        };
        let (parents, tools) = match chain.is_serial() {
            true => (Vec::new(), Vec::new()),
            false => (
                (1..=chain.joints().len()).map(|k| chain.before(JointId(k)).0).collect(),
                chain.tools().iter().map(tool).collect(),
            ),
        };
        let coupling = |c: &Coupling| CouplingV1 { joint: c.joint.0, driver: c.driver.0, factor: c.factor };
        let mimic =
            |m: &Mimic| MimicV1 { joint: m.joint.0, driver: m.driver.0, ratio: m.ratio, offset: m.offset };
        RobotV1 {
            name: chain.name().into(),
            gravity: GravityV1 { vector: chain.gravity().vector.into(), frame },
            base: chain.base().into(),
            joints: (1..)
                .map(JointId)
                .zip(chain.joints())
                .map(|(id, joint)| JointV1::of(joint, chain.controller_limits(id)))
                .collect(),
            tool: chain.tool().into(),
            targets: chain.targets().iter().map(target).collect(),
            couplings: chain.couplings().iter().map(coupling).collect(),
            mimics: chain.mimics().iter().map(mimic).collect(),
            parents,
            tools,
        }
    }
}

impl JointV1 {
    /// Of a joint with these limits of the controller's values.
    fn of(joint: &Joint, limits: Option<(f64, f64)>) -> Self {
        let placement = match joint.placement {
            Placement::Dh { theta, d, a, alpha } => PlacementV1::Dh { theta, d, a, alpha },
            Placement::Mdh { alpha, a, theta, d } => PlacementV1::Mdh { alpha, a, theta, d },
            Placement::Origin { pose, axis } => {
                PlacementV1::Origin { pose: (&pose).into(), axis: axis.into_inner().into() }
            }
        };
        JointV1 {
            name: joint.name.clone(),
            kind: match joint.kind {
                JointKind::Revolute => KindV1::Revolute,
                JointKind::Prismatic => KindV1::Prismatic,
                JointKind::Fixed => KindV1::Fixed,
            },
            placement,
            limits: limits
                .filter(|(lower, upper)| lower.is_finite() && upper.is_finite())
                .map(|(lower, upper)| [lower, upper]),
            link: joint.link.map(|link| LinkV1 { mass: link.mass, com: link.com.into() }),
        }
    }
}

impl From<&Pose> for PoseV1 {
    fn from(pose: &Pose) -> Self {
        let row = |k: usize| [pose.rotation[(k, 0)], pose.rotation[(k, 1)], pose.rotation[(k, 2)]];
        PoseV1 { rotation: [row(0), row(1), row(2)], translation: pose.translation.into() }
    }
}

impl From<&Placed> for PlacedV1 {
    fn from(placed: &Placed) -> Self {
        PlacedV1 { pose: (&placed.pose).into(), known: placed.known }
    }
}

impl TryFrom<RobotV1> for Chain {
    type Error = ChainError;

    fn try_from(robot: RobotV1) -> Result<Self, ChainError> {
        let joints = robot.joints.into_iter().map(Joint::try_from).collect::<Result<_, _>>()?;
        let frame = match robot.gravity.frame {
            GravityFrameV1::Measurement => GravityFrame::Measurement,
            GravityFrameV1::Base => GravityFrame::Base,
        };
        let target = |target: TargetV1| Target {
            name: target.name,
            position: Vector3::from(target.position),
            known: target.known,
            tool: ToolId(target.tool),
        };
        let coupling =
            |c: CouplingV1| Coupling { joint: JointId(c.joint), driver: JointId(c.driver), factor: c.factor };
        let mimic = |m: MimicV1| Mimic {
            joint: JointId(m.joint),
            driver: JointId(m.driver),
            ratio: m.ratio,
            offset: m.offset,
        };
        Chain::new(robot.name, joints)?
            .with_couplings(robot.couplings.into_iter().map(coupling).collect())?
            .with_mimics(robot.mimics.into_iter().map(mimic).collect())?
            .with_base(placed(robot.base, "base")?)?
            .with_tool(placed(robot.tool, "tool")?)
            .and_then(|chain| branched(chain, &robot.parents, robot.tools))?
            .with_targets(robot.targets.into_iter().map(target).collect())?
            .with_gravity(Gravity { vector: Vector3::from(robot.gravity.vector), frame })
    }
}

impl TryFrom<JointV1> for Joint {
    type Error = ChainError;

    fn try_from(joint: JointV1) -> Result<Self, ChainError> {
        let kind = match joint.kind {
            KindV1::Revolute => JointKind::Revolute,
            KindV1::Prismatic => JointKind::Prismatic,
            KindV1::Fixed => JointKind::Fixed,
        };
        let placement = match joint.placement {
            PlacementV1::Dh { theta, d, a, alpha } => Placement::Dh { theta, d, a, alpha },
            PlacementV1::Mdh { alpha, a, theta, d } => Placement::Mdh { alpha, a, theta, d },
            PlacementV1::Origin { pose, axis } => Placement::Origin {
                pose: self::pose(pose, &joint.name)?,
                // Normalising once more would change its last bit; the chain checks its length.
                axis: Unit::new_unchecked(Vector3::from(axis)),
            },
        };
        Ok(Joint {
            name: joint.name,
            kind,
            placement,
            limits: joint.limits.map(|[lower, upper]| (lower, upper)),
            link: joint.link.map(|link| Link { mass: link.mass, com: Vector3::from(link.com) }),
        })
    }
}

/// With these joints in front of the joints and these tools, where there are any.
fn branched(chain: Chain, parents: &[usize], tools: Vec<ToolV1>) -> Result<Chain, ChainError> {
    if parents.is_empty() && tools.is_empty() {
        return Ok(chain);
    }
    let joint = |number: usize| (number > 0).then_some(JointId(number));
    let parents: Vec<Option<JointId>> = parents.iter().map(|&number| joint(number)).collect();
    let tool =
        |tool: ToolV1| Ok(Tool::on(tool.name.clone(), joint(tool.joint), placed(tool.placed, &tool.name)?));
    let tools = tools.into_iter().map(tool).collect::<Result<_, ChainError>>()?;
    chain.with_parents(&parents)?.with_tools(tools)
}

fn placed(placed: PlacedV1, name: &str) -> Result<Placed, ChainError> {
    Ok(Placed { pose: pose(placed.pose, name)?, known: placed.known })
}

pub(super) fn pose(pose: PoseV1, name: &str) -> Result<Pose, ChainError> {
    let r = pose.rotation;
    let rotation = Matrix3::from_fn(|row, column| r[row][column]);
    let error = (rotation * rotation.transpose() - Matrix3::identity()).amax();
    if error.is_nan() || error > ORTHONORMAL || rotation.determinant() < 0.0 {
        return Err(ChainError::NotFinite { what: "the rotation", name: name.into() });
    }
    Ok(Pose::new(rotation, Vector3::from(pose.translation)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn every_sample_robot_comes_back_to_the_bit() {
        let coupling = Coupling { joint: JointId(3), driver: JointId(2), factor: 0.3 };
        let coupled = samples::ur10().with_couplings(vec![coupling]).unwrap();
        let mimic = Mimic { joint: JointId(5), driver: JointId(2), ratio: -0.3, offset: 0.1 };
        let follows = samples::ur10().with_mimics(vec![mimic]).unwrap();
        for chain in samples::all().into_iter().chain([coupled, follows, samples::dual()]) {
            let text = serde_json::to_string(&RobotV1::from(&chain)).unwrap();
            let again = Chain::try_from(serde_json::from_str::<RobotV1>(&text).unwrap()).unwrap();
            assert_eq!(again, chain);
            assert_eq!(serde_json::to_string(&RobotV1::from(&again)).unwrap(), text);
        }
    }

    #[test]
    fn a_bent_rotation_is_refused() {
        let mut robot = RobotV1::from(&samples::heavy());
        robot.base.pose.rotation[0][0] += 1e-6;
        assert!(Chain::try_from(robot).is_err());
    }
}
