//! Frames in which poses are given: the robot's base, the frame of the measurements, or a work object; and the tool centre point.
//!
//! ```text
//! given  P  in F, of the TCP X        desired tool of the measurements  F · P · X⁻¹ · tool E_tool
//! joints q  of a nominal programme    desired tool of the measurements  B E_0 · A(q) · tool E_tool
//! command q'                          corrected pose for the controller F⁻¹ · B E_0 · A(q') · X
//! ```
//!
//! A: the nominal joints alone, from base to flange; B E_0: the base as the fit has it.

use crate::error::WorkflowError;
use crate::parameters::recorded_frames;
use crate::place::{GivenPlace, Place};
use std::path::Path;
use truepose_compensate::{Installation, installation};
use truepose_errormodel::{Dataset, FittedModel};
use truepose_io::{CsvInfo, FrameParent, NamedFrame, Poses, Quantity, Unit, read_details};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, JointKind, Pose};

/// Where desired poses are.
#[derive(Debug, Clone)]
pub struct Placed {
    installation: Installation,
    /// F in the measurement frame.
    frame: Pose,
    /// X in the flange; none: the tool of the measurements, whose place in the nominal robot is that of its description.
    tcp: Option<Pose>,
}

impl Placed {
    /// Of a frame and a tool centre point; named ones are those of the robot file `frames`, else those that the fit has recorded.
    ///
    /// # Errors
    /// When a name is not known, or stands for something else.
    pub fn new(
        [frame, tcp]: [&[GivenPlace]; 2],
        frames: Option<&Path>,
        fitted: &FittedModel,
    ) -> Result<Self, WorkflowError> {
        let installation = installation(fitted)?;
        let frames = match frames {
            Some(file) => read_details(file)?.frames,
            None => recorded_frames(fitted),
        };
        let frame = match one("frame", frame)? {
            None => Pose::IDENTITY,
            Some(Place::At(pose)) => installation.base * *pose,
            Some(Place::Named(name)) => match name.as_str() {
                "measurement" => Pose::IDENTITY,
                "base" => installation.base,
                _ => {
                    let found = named("frame", name, &frames)?;
                    match found.inside {
                        FrameParent::Base => installation.base * found.pose,
                        FrameParent::Measurement => found.pose,
                        FrameParent::Flange => {
                            let words =
                                format!("`{name}` moves with the robot (in = \"flange\"); it can be a --tcp");
                            return Err(WorkflowError::option("frame", words));
                        }
                    }
                }
            },
        };
        let tcp = match one("tcp", tcp)? {
            None => None,
            Some(Place::At(pose)) => Some(*pose),
            Some(Place::Named(name)) if name == "flange" => Some(Pose::IDENTITY),
            Some(Place::Named(name)) => {
                let found = named("tcp", name, &frames)?;
                if found.inside != FrameParent::Flange {
                    let words = "does not move with the robot; a tool centre point has in = \"flange\"";
                    return Err(WorkflowError::option("tcp", format!("`{name}` {words}")));
                }
                Some(found.pose)
            }
        };
        Ok(Placed { installation, frame, tcp })
    }

    /// Whether desired poses are independent of the place of the measurements' tool.
    pub fn of_the_flange(&self) -> bool {
        self.tcp.is_some()
    }

    /// The tool centre point from the origin of the measurements' tool, in the axes of that tool, m; none where poses are those of that tool.
    pub fn lever(&self) -> Option<Vector3<f64>> {
        self.tcp.map(|tcp| (self.installation.tool.inverse() * tcp).translation)
    }

    /// Replaces poses in F by those of the measurements' tool in the measurement frame.
    ///
    /// # Errors
    /// When a pose of a TCP has no orientation, or is that of a target.
    pub fn place(&self, poses: &mut Poses, file: &str) -> Result<(), WorkflowError> {
        let behind = self.tcp.map_or(Pose::IDENTITY, |tcp| tcp.inverse() * self.installation.tool);
        for row in 0..poses.rows.len() {
            let position = poses.rows.measured_position(row);
            let rotation = poses.rows.measured_rotation(row);
            if self.tcp.is_some() && (rotation.is_none() || poses.rows.target[row].is_some()) {
                let line = poses.rows.line.get(row).map_or(String::new(), |line| format!("{line}: "));
                let what = if rotation.is_none() {
                    "the pose has no orientation"
                } else {
                    "the pose names a target"
                };
                return Err(WorkflowError::Input(format!(
                    "{file}:{line}{what}; with --tcp it has to be that of the tool centre point"
                )));
            }
            let given = Pose::new(rotation.unwrap_or(Pose::IDENTITY.rotation), position);
            let desired = self.frame * given * behind;
            // A position alone is moved as a point.
            put(&mut poses.rows, row, &desired, rotation.is_some());
        }
        Ok(())
    }

    /// The pose that a controller without the model has to be given for a command: of the TCP (else of the nominal tool or target), in F.
    pub fn corrected(&self, chain: &Chain, joints: &[f64], poses: &Poses, row: usize) -> Pose {
        let flange = flange(chain, joints);
        let tool = self.tcp.unwrap_or(chain.tool().pose);
        let mut pose = self.frame.inverse() * self.installation.base * flange * tool;
        if let Some(target) = poses.rows.target[row] {
            pose.translation = pose.apply(&chain.targets()[target.0].position);
        }
        pose
    }

    /// Rows of joints as desired poses: the flange where the nominal robot has it, in its own base.
    pub fn programme(&self, chain: &Chain, mut rows: Dataset, info: &CsvInfo) -> Poses {
        // Fewer than six joints cannot keep an orientation as well.
        let oriented = chain.movable().len() >= 6;
        for row in 0..rows.len() {
            let joints: Vec<f64> = rows.joints.iter().map(|column| column[row]).collect();
            let desired = self.installation.base * flange(chain, &joints) * self.installation.tool;
            rows.target[row] = None;
            put(&mut rows, row, &desired, oriented);
        }
        let unit = |joint: &truepose_kinematics::JointId| {
            let joint = chain.joint(*joint);
            let column = info.columns.iter().find(|column| column.name == joint.name);
            let quantity =
                if joint.kind == JointKind::Prismatic { Quantity::Length } else { Quantity::Angle };
            let named = column.and_then(|column| Unit::named(&column.unit));
            *named.filter(|unit| unit.quantity == quantity).unwrap_or_else(|| quantity.si())
        };
        let joint_units = chain.movable().iter().map(unit).collect();
        Poses { rows, seeded: true, joint_units, ids: info.ids.clone(), convention: None }
    }
}

/// The nominal flange in the robot's base.
fn flange(chain: &Chain, joints: &[f64]) -> Pose {
    chain.base().pose.inverse() * chain.forward(joints) * chain.tool().pose.inverse()
}

/// The one place of poses, which has no name.
fn one<'a>(option: &'static str, given: &'a [GivenPlace]) -> Result<Option<&'a Place>, WorkflowError> {
    match given {
        [] => Ok(None),
        [GivenPlace { name: None, place }] => Ok(Some(place)),
        [GivenPlace { name: Some(name), .. }] => {
            let words = format!("{name}=…: names are those of a --program; poses have one place");
            Err(WorkflowError::option(option, words))
        }
        _ => {
            let words = format!("poses have one place; it is given {} times", given.len());
            Err(WorkflowError::option(option, words))
        }
    }
}

fn put(rows: &mut Dataset, row: usize, pose: &Pose, oriented: bool) {
    rows.position[row] = pose.translation.into();
    rows.orientation[row] = oriented.then(|| pose.quaternion());
}

fn named<'a>(
    option: &'static str,
    name: &str,
    frames: &'a [NamedFrame],
) -> Result<&'a NamedFrame, WorkflowError> {
    frames.iter().find(|frame| frame.name == name).ok_or_else(|| {
        let known: Vec<&str> = frames.iter().map(|frame| frame.name.as_str()).collect();
        let known = if known.is_empty() {
            "the robot file of the fit declares none; add [[frames]] to it and fit again, or name a file with --frames".into()
        } else {
            format!("known: {}", known.join(", "))
        };
        WorkflowError::option(option, format!("there is no frame `{name}` ({known})"))
    })
}
