//! Tables of component errors as CSV, with the letters of ISO 230-1 where they apply.
//!
//! ```text
//! E c J      c: direction of the error (X Y Z, or A B C for turns about them),   J: the axis that moves
//! EXX positioning of X,  EYX straightness in Y,  EAX roll,  EBX, ECX pitch and yaw;   C for a turn about Z
//! ```
//!
//! A joint has a letter when it moves along or about an axis of the base at the reference, to 0.1 rad, and a component when
//! its direction lies so too; a minus in front says that it points the other way. Everything else has its frame and component.
//!
//! | column | meaning |
//! | --- | --- |
//! | `joint`, `at` | the joint that moves, and its value; empty: constant errors, at the reference |
//! | `frame`, `component` | where the error is: behind joint `frame`, in that frame's axes |
//! | `error` | change from the reference, m or rad; constants in full |
//! | `iso` | its name in ISO 230-1, where it has one |

use super::cell::cell;
use super::error_tables::ErrorTables;
use nalgebra::Vector3;
use std::fmt::Write;
use truepose_kinematics::{Chain, FrameId, JointId, JointKind, Pose, Site};

/// Cosine of 0.1 rad.
const ALONG: f64 = 0.995;

impl ErrorTables {
    /// The tables as CSV, in m and rad, with digits that read back to the same numbers; `statement` goes into
    /// comments at the front.
    pub fn to_csv(&self, chain: &Chain, statement: &[String]) -> String {
        let mut out = String::new();
        // Writing to a String cannot fail.
        let _ = self.write(chain, statement, &mut out);
        out
    }

    fn write(&self, chain: &Chain, statement: &[String], out: &mut String) -> std::fmt::Result {
        for line in statement {
            writeln!(out, "# {line}")?;
        }
        writeln!(out, "# errors of each joint add up; between the values of a joint they are linear")?;
        for (&joint, value) in chain.movable().iter().zip(&self.reference) {
            let described = chain.joint(joint);
            writeln!(out, "# reference: {} = {value:?} {}", described.name, described.unit())?;
        }
        writeln!(out, "joint,at,joint unit,frame,component,error,unit,iso")?;
        for &(site, error) in &self.constant {
            let (frame, component, unit) = place(chain, site);
            writeln!(out, ",,,{frame},{component},{error:?},{unit},")?;
        }
        let turned = self.frames(chain);
        for table in &self.tables {
            let joint = chain.joint(table.joint);
            let name_cell = cell(&joint.name);
            let letter = letter_of(chain, table.joint, &turned);
            for (&site, column) in table.sites.iter().zip(&table.columns) {
                let (frame, component, unit) = place(chain, site);
                let iso = letter.map_or(String::new(), |letter| name(letter, site, &turned));
                for (at, error) in table.at.iter().zip(column) {
                    writeln!(
                        out,
                        "{},{at:?},{},{frame},{component},{error:?},{unit},{iso}",
                        name_cell,
                        joint.unit()
                    )?;
                }
            }
        }
        Ok(())
    }

    /// Every frame at the reference, in the base's axes.
    fn frames(&self, chain: &Chain) -> Vec<Pose> {
        let mut frames = vec![Pose::IDENTITY];
        let mut here = Pose::IDENTITY;
        for (index, joint) in chain.joints().iter().enumerate() {
            let k = chain.coordinate(JointId(index + 1));
            here = here * joint.transform(k.and_then(|k| self.reference.get(k)).copied().unwrap_or(0.0));
            frames.push(here);
        }
        frames.push(here * chain.tool().pose);
        frames
    }
}

/// The word of a frame, of a component, and its unit.
fn place(chain: &Chain, site: Site) -> (String, &'static str, &'static str) {
    let axis = site.axis();
    let unit = if axis.is_rotation() { "rad" } else { "m" };
    let frame = match site {
        Site::Frame(FrameId(0), _) => "base".into(),
        Site::Frame(frame, _) if frame == chain.tool_frame() => "tool".into(),
        Site::Frame(frame, _) => cell(&chain.joint(JointId(frame.0)).name),
        Site::Target(target, _) => format!("target {}", chain.targets()[target.0].name),
    };
    (frame, axis.word(), unit)
}

/// Which axis of the base a direction lies along, and on which side.
fn along(direction: &Vector3<f64>) -> Option<(usize, f64)> {
    (0..3).find(|&k| direction[k].abs() > ALONG).map(|k| (k, direction[k].signum()))
}

fn letter_of(chain: &Chain, joint: JointId, frames: &[Pose]) -> Option<char> {
    let motion = chain.joint_motion(joint)?;
    let (k, _) = along(&(frames.get(motion.frame.0)?.rotation * motion.axis))?;
    Some(if motion.kind == JointKind::Prismatic { ['X', 'Y', 'Z'][k] } else { ['A', 'B', 'C'][k] })
}

fn name(letter: char, site: Site, frames: &[Pose]) -> String {
    let Site::Frame(frame, axis) = site else { return String::new() };
    let Some(pose) = frames.get(frame.0) else { return String::new() };
    match along(&pose.rotation.column(axis.direction()).into()) {
        None => String::new(),
        Some((k, side)) => {
            let component = if axis.is_rotation() { ['A', 'B', 'C'][k] } else { ['X', 'Y', 'Z'][k] };
            format!("{}E{component}{letter}", if side < 0.0 { "-" } else { "" })
        }
    }
}
