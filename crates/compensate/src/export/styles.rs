//! Joint origins as the kinematics files of ROS descriptions, in the link frames of the maker.
//!
//! ```text
//! frame of joint i = N_i D_i,  D_i = turn about and slide along the joint's own axis      origin'_i = D_{i−1}⁻¹ origin_i D_i
//! D_i = N_i⁻¹ R_i                                                                         tool' = D_n⁻¹ tool
//! ```
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | N_i | `frames` of the nominal robot at q = 0 | pose | m | robot's base |
//! | R_i | `frames` of the maker's file at q = 0; without one those of the description, or of [`link_frames`] where it has rows | pose | m | robot's base |
//!
//! No frame changes a pose of the robot: a joint commutes with turns about and slides along its axis. So the file keeps links, meshes and
//! masses of the description where they are. Origins are poses of one axis in the frame of the one before: parallel axes are no special
//! case, and there are no common normals far away.

use super::link_frames::{Line, link_frames, shortest};
use super::origins::JointOrigins;
use super::ros::{entry, quoted};
use crate::CompensateError;
use nalgebra::{Unit, Vector3};
use std::fmt::Write;
use truepose_kinematics::{Chain, JointId, JointKind, Placement, Pose};

use super::geometry::split;

/// Axes of the nominal robot and of the maker's file are one within this, m and rad: makers write angles with four decimals (1.5708), and
/// the errors of up to seven joints add up at a metre.
const SAME_AXIS: f64 = 2e-4;
/// Within this, m and rad, the description is the maker's arm with the constants of a calibration.
const CALIBRATED: f64 = 1e-2;

/// Whose structure a kinematics file has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RosStyle {
    /// Universal Robots: `kinematics:` `shoulder:` … and `hash:`.
    Ur,
    /// Franka: `joint1:` `kinematic:` ….
    Franka,
    /// Flexiv: `kinematics:` `joint1:` …, axes z y z y z y z.
    Flexiv,
    /// UFACTORY: `kinematics:` `joint1:` ….
    XArm,
}

const UR: [&str; 6] = ["shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"];

impl RosStyle {
    /// All of them.
    pub const ALL: [RosStyle; 4] = [RosStyle::Ur, RosStyle::Franka, RosStyle::Flexiv, RosStyle::XArm];

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            RosStyle::Ur => "ur",
            RosStyle::Franka => "franka",
            RosStyle::Flexiv => "flexiv",
            RosStyle::XArm => "xarm",
        }
    }

    /// The axis of a joint, from 1, in its own frame.
    fn axis(self, number: usize) -> Unit<Vector3<f64>> {
        match self {
            RosStyle::Flexiv if number.is_multiple_of(2) => Vector3::y_axis(),
            _ => Vector3::z_axis(),
        }
    }

    fn key(self, number: usize) -> String {
        match self {
            RosStyle::Ur => UR.get(number - 1).map_or_else(String::new, |key| (*key).into()),
            _ => format!("joint{number}"),
        }
    }

    /// The key of the fixed joint behind the last one.
    fn flange(self) -> Option<&'static str> {
        match self {
            RosStyle::Franka => Some("joint8"),
            RosStyle::Flexiv => Some("link7_to_flange"),
            _ => None,
        }
    }
}

/// The origins of a file: one for each movable joint, and the flange.
#[derive(Debug, Clone, PartialEq)]
pub struct StyledOrigins {
    style: RosStyle,
    /// Measurement frame to the robot's base.
    pub base: Pose,
    /// Origins of the movable joints.
    pub joints: Vec<Pose>,
    /// The flange in the last joint's frame, where the maker's file has one.
    pub flange: Option<Pose>,
    /// Last joint's frame to the tool of the measurements.
    pub tool: Pose,
    /// Whether the link frames are those of the maker's file.
    pub as_maker: bool,
    /// What there is to know of the link frames.
    pub remarks: Vec<String>,
}

impl JointOrigins {
    /// The same robot in the structure of a maker's file; `reference` is that file as a robot, whose link frames are taken.
    ///
    /// # Errors
    /// When the robot has not the style's joints, or is not the one of the reference.
    pub fn styled(
        &self,
        style: RosStyle,
        nominal: &Chain,
        reference: Option<&Chain>,
    ) -> Result<StyledOrigins, CompensateError> {
        let movable = nominal.movable();
        let fits = match style {
            RosStyle::Ur => movable.len() == 6,
            RosStyle::Franka | RosStyle::Flexiv => movable.len() == 7,
            RosStyle::XArm => (5..=7).contains(&movable.len()),
        };
        let turns = movable.iter().all(|&joint| nominal.joint(joint).kind == JointKind::Revolute);
        if !fits || !turns || self.joints.len() != nominal.joints().len() {
            let words = format!("the robot has not the joints of the style {}", style.word());
            return Err(CompensateError::Style { reason: words });
        }
        if !nominal.mimics().is_empty() {
            let words = "a joint follows another one, which the file has no place for".into();
            return Err(CompensateError::Style { reason: words });
        }
        if !nominal.couplings().is_empty() {
            let words = "its joints are coupled, which the file has no place for".into();
            return Err(CompensateError::Style { reason: words });
        }
        let (ours, end) = frames(nominal);
        let by_rows = |&joint: &JointId| !matches!(nominal.joint(joint).placement, Placement::Origin { .. });
        let theirs = match reference {
            Some(reference) => Some(frames(reference).0),
            None if movable.iter().any(by_rows) => {
                let line = |(frame, &joint): (&Pose, &JointId)| Line {
                    point: frame.translation,
                    direction: Unit::new_normalize(frame.rotation * split(nominal, joint).2.into_inner()),
                };
                let lines: Vec<Line> = ours.iter().zip(movable).map(line).collect();
                let axes: Vec<_> = (1..=movable.len()).map(|number| style.axis(number)).collect();
                let flange = style.flange().is_none().then_some(&end.translation);
                Some(link_frames(&lines, &axes, flange))
            }
            None => None,
        };
        if theirs.as_ref().is_some_and(|theirs| theirs.len() != ours.len()) {
            return Err(CompensateError::Style { reason: "the maker's file has other joints".into() });
        }
        let mut joints = Vec::with_capacity(movable.len());
        let mut remarks = Vec::new();
        let mut before = Pose::IDENTITY;
        let mut last = Pose::IDENTITY;
        for (k, &joint) in movable.iter().enumerate() {
            let from = if k == 0 { 0 } else { movable[k - 1].0 };
            // Fixed joints on the way become part of the origin.
            let origin = self.joints[from..joint.0].iter().fold(Pose::IDENTITY, |all, one| all * one.pose);
            let axis = self.joints[joint.0 - 1].axis;
            let wanted = style.axis(k + 1);
            let moved = match &theirs {
                Some(theirs) => {
                    along(&(ours[k].inverse() * theirs[k]), &axis, &wanted, (k + 1, &mut remarks))?
                }
                None if axis == wanted => Pose::IDENTITY,
                None => Pose::new(*shortest(&wanted, &axis).to_rotation_matrix().matrix(), Vector3::zeros()),
            };
            joints.push(before.inverse() * origin * moved);
            before = moved;
            last = moved;
        }
        let behind = movable.last().map_or(0, |joint| joint.0);
        let fixed = self.joints[behind..].iter().fold(Pose::IDENTITY, |all, one| all * one.pose);
        let has_fixed = behind < self.joints.len();
        let of_file = reference.and_then(|reference| {
            let last = reference.joints().last().filter(|joint| joint.kind == JointKind::Fixed)?;
            Some(last.transform(0.0))
        });
        let own = has_fixed.then(|| last.inverse() * fixed);
        let flange = style.flange().and(own.or(of_file));
        let tool = last.inverse() * fixed * self.tools[0];
        let as_maker = reference.is_some();
        if !as_maker {
            let of = if theirs.is_some() {
                "they are where axes come nearest to each other, as makers place them, and not those of the maker's file;"
            } else {
                "along the joints' axes they are those of the robot description, not of the maker's file;"
            };
            remarks.push(format!("link frames: {of}"));
            let rest = "poses are the same, but meshes and masses of the maker's links are displaced (export with --like)";
            remarks.push(rest.into());
        }
        Ok(StyledOrigins { style, base: self.base, joints, flange, tool, as_maker, remarks })
    }
}

/// Frames of the movable joints at q = 0 in the robot's base, in front of what stands behind the motion; and the end of the last joint.
fn frames(chain: &Chain) -> (Vec<Pose>, Pose) {
    let mut at = Pose::IDENTITY;
    let mut found = Vec::new();
    for (k, joint) in chain.joints().iter().enumerate() {
        let (pre, post, _) = match joint.placement {
            Placement::Origin { pose, axis } => (pose, Pose::IDENTITY, axis),
            _ => split(chain, JointId(k + 1)),
        };
        at = at * pre;
        if joint.kind != JointKind::Fixed {
            found.push(at);
        }
        at = at * post;
    }
    (found, at)
}

/// The nearest turn about and slide along the axis.
fn along(
    found: &Pose,
    axis: &Unit<Vector3<f64>>,
    wanted: &Unit<Vector3<f64>>,
    (number, remarks): (usize, &mut Vec<String>),
) -> Result<Pose, CompensateError> {
    let turned = found.rotation * wanted.into_inner();
    let slide = axis.into_inner() * axis.dot(&found.translation);
    let (off, tilt) = ((found.translation - slide).norm(), turned.cross(axis).norm());
    let words = || {
        let (off, tilt) = (1e3 * off, 1e3 * tilt);
        format!(
            "the axis of joint {number} is not that of the maker's file ({off:.3} mm and {tilt:.3} mrad from it)"
        )
    };
    if off > CALIBRATED || tilt > CALIBRATED || turned.dot(axis) < 0.0 {
        let reason = format!("{}: base, zero or dimensions of the robot description are others", words());
        return Err(CompensateError::Style { reason });
    }
    if off > SAME_AXIS || tilt > SAME_AXIS {
        remarks.push(format!("{}: the robot description has the constants of a calibration", words()));
    }
    let back = shortest(&turned, axis);
    Ok(Pose::new(back.to_rotation_matrix().matrix() * found.rotation, slide))
}

impl StyledOrigins {
    /// The file, in m and rad, with digits that read back to the same numbers; `statement` goes into comments at the front. `hash` is the
    /// controller's, for Universal Robots; without it the file has one of its own.
    pub fn to_yaml(&self, hash: Option<&str>, statement: &[String]) -> String {
        let mut out = String::new();
        // Writing to a String cannot fail.
        let _ = self.write(hash, statement, &mut out);
        out
    }

    fn write(&self, hash: Option<&str>, statement: &[String], out: &mut String) -> std::fmt::Result {
        for line in statement {
            writeln!(out, "# {line}")?;
        }
        for line in &self.remarks {
            writeln!(out, "# {line}")?;
        }
        writeln!(out, "# x y z in m; roll, pitch, yaw about the fixed axes x, y, z in rad")?;
        let franka = self.style == RosStyle::Franka;
        let flange = self.style.flange().zip(self.flange.as_ref());
        let keys = self.joints.iter().enumerate().map(|(k, pose)| (self.style.key(k + 1), pose));
        let keys = keys.chain(flange.map(|(key, pose)| (key.to_owned(), pose)));
        if !franka {
            writeln!(out, "kinematics:")?;
        }
        for (key, pose) in keys {
            if franka {
                writeln!(out, "{key}:\n  kinematic:")?;
            } else {
                writeln!(out, "  {}:", quoted(&key))?;
            }
            entry("    ", pose, out)?;
        }
        if self.style == RosStyle::Ur {
            match hash {
                Some(hash) => writeln!(out, "  hash: {hash}")?,
                None => {
                    writeln!(
                        out,
                        "  # Not the controller's hash: the driver reports that the calibration does not match the robot's, because"
                    )?;
                    writeln!(
                        out,
                        "  # the controller still has the maker's. --hash states the controller's knowingly."
                    )?;
                    writeln!(out, "  hash: truepose_{:016x}", self.digest())?;
                }
            }
        }
        writeln!(out, "truepose:")?;
        writeln!(out, "  style: {}", self.style.word())?;
        for (key, pose) in [("base", self.base), ("tool", self.behind_flange())] {
            writeln!(out, "  {key}:")?;
            entry("    ", &pose, out)?;
        }
        Ok(())
    }

    /// The tool behind the last frame of the file.
    fn behind_flange(&self) -> Pose {
        match (self.style.flange(), &self.flange) {
            (Some(_), Some(flange)) => flange.inverse() * self.tool,
            _ => self.tool,
        }
    }

    /// Of the numbers in the file: FNV-1a, 64 bits.
    fn digest(&self) -> u64 {
        let numbers = self.joints.iter().flat_map(|pose| {
            let place: [f64; 3] = pose.translation.into();
            place.into_iter().chain(pose.rpy())
        });
        let bytes = numbers.flat_map(|value| value.to_bits().to_le_bytes());
        bytes.fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
    }
}
