//! A robot description as TOML, in m and rad, with digits that read back to the same numbers.

use std::fmt::Write;
use truepose_kinematics::{Chain, Gravity, GravityFrame, JointId, JointKind, Placed, Placement, Pose};

/// The robot as a TOML description.
pub fn robot_toml(chain: &Chain) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = write(chain, &mut out);
    out
}

fn write(chain: &Chain, out: &mut String) -> std::fmt::Result {
    writeln!(out, "name = {}", quoted(chain.name()))?;
    let gravity = chain.gravity();
    if *gravity != Gravity::default() {
        writeln!(out, "gravity = {}", array(gravity.vector.as_slice()))?;
        if gravity.frame == GravityFrame::Base {
            writeln!(out, "gravity_frame = \"base\"")?;
        }
    }
    writeln!(out, "\n[units]\nlength = \"m\"\nangle = \"rad\"")?;
    placed("base", chain.base(), out)?;
    for (index, joint) in chain.joints().iter().enumerate() {
        let kind = match joint.kind {
            JointKind::Revolute => "revolute",
            JointKind::Prismatic => "prismatic",
            JointKind::Fixed => "fixed",
        };
        writeln!(out, "\n[[joints]]\nname = {}\ntype = \"{kind}\"", quoted(&joint.name))?;
        let before = chain.before(JointId(index + 1));
        if before.0 != index {
            writeln!(out, "parent = {}", quoted(chain.frame_word(before)))?;
        }
        if let Some((lower, upper)) =
            chain.joint_named(&joint.name).and_then(|id| chain.controller_limits(id))
            && joint.moves()
        {
            writeln!(out, "limits = {}", array(&[lower, upper]))?;
        }
        match &joint.placement {
            Placement::Dh { theta, d, a, alpha } => {
                writeln!(out, "dh = {{ theta = {theta:?}, d = {d:?}, a = {a:?}, alpha = {alpha:?} }}")?;
            }
            Placement::Mdh { alpha, a, theta, d } => {
                writeln!(out, "mdh = {{ alpha = {alpha:?}, a = {a:?}, theta = {theta:?}, d = {d:?} }}")?;
            }
            Placement::Origin { pose, axis } => {
                let (xyz, rpy) = xyz_rpy(pose);
                writeln!(out, "origin = {{ xyz = {xyz}, rpy = {rpy}, axis = {} }}", array(axis.as_slice()))?;
            }
        }
        if let Some(mimic) = chain.mimics().iter().find(|mimic| mimic.joint.0 == index + 1) {
            let driver = quoted(&chain.joint(mimic.driver).name);
            let (ratio, offset) = (mimic.ratio, mimic.offset);
            writeln!(out, "mimic = {{ joint = {driver}, ratio = {ratio:?}, offset = {offset:?} }}")?;
        }
        if let Some(link) = &joint.link {
            writeln!(out, "mass = {:?}\ncom = {}", link.mass, array(link.com.as_slice()))?;
        }
    }
    for coupling in chain.couplings() {
        let name = |joint| quoted(&chain.joint(joint).name);
        let (joint, driver) = (name(coupling.joint), name(coupling.driver));
        writeln!(out, "\n[[couplings]]\njoint = {joint}\ndriver = {driver}\nfactor = {:?}", coupling.factor)?;
    }
    let several = chain.tools().len() > 1 || chain.tool_frame().0 != chain.tools()[0].frame.0 + 1;
    match several {
        false => placed("tool", chain.tool(), out)?,
        true => chain.tools().iter().try_for_each(|tool| {
            let (name, joint) = (quoted(&tool.name), quoted(chain.frame_word(tool.frame)));
            writeln!(out, "\n[[tools]]\nname = {name}\njoint = {joint}")?;
            let (xyz, rpy) = xyz_rpy(&tool.placed.pose);
            writeln!(out, "xyz = {xyz}\nrpy = {rpy}")?;
            if tool.placed.known { Ok(()) } else { writeln!(out, "known = false") }
        })?,
    }
    for target in chain.targets() {
        writeln!(
            out,
            "\n[[targets]]\nname = {}\nxyz = {}",
            quoted(&target.name),
            array(target.position.as_slice())
        )?;
        if !target.known {
            writeln!(out, "known = false")?;
        }
        if several {
            writeln!(out, "tool = {}", quoted(&chain.tools()[target.tool.0].name))?;
        }
    }
    Ok(())
}

fn placed(table: &str, placed: &Placed, out: &mut String) -> std::fmt::Result {
    if *placed == Placed::default() {
        return Ok(());
    }
    let (xyz, rpy) = xyz_rpy(&placed.pose);
    writeln!(out, "\n[{table}]\nxyz = {xyz}\nrpy = {rpy}")?;
    if placed.known { Ok(()) } else { writeln!(out, "known = false") }
}

fn xyz_rpy(pose: &Pose) -> (String, String) {
    (array(pose.translation.as_slice()), array(&pose.rpy()))
}

fn array(numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(|v| format!("{v:?}")).collect();
    format!("[{}]", numbers.join(", "))
}

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RobotOptions, read_robot};
    use truepose_kinematics::{Coupling, JointId, ToolId, samples};

    #[test]
    fn every_sample_robot_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.toml");
        let coupling = Coupling { joint: JointId(3), driver: JointId(2), factor: 0.3 };
        let coupled = samples::ur10().with_couplings(vec![coupling]).unwrap();
        for chain in samples::all().into_iter().chain([coupled, samples::dual()]) {
            std::fs::write(&path, robot_toml(&chain)).unwrap();
            let (again, _) = read_robot(&path, &RobotOptions::default()).unwrap();
            assert_eq!(again.name(), chain.name());
            assert_eq!(again.targets(), chain.targets());
            assert_eq!(again.is_serial(), chain.is_serial());
            assert_eq!(again.gravity(), chain.gravity());
            assert_eq!(again.couplings(), chain.couplings());
            for (a, b) in again.joints().iter().zip(chain.joints()) {
                assert_eq!((&a.name, a.kind, a.limits, a.link), (&b.name, b.kind, b.limits, b.link));
            }
            let q: Vec<f64> = (0..chain.movable().len()).map(|k| 0.1 + 0.2 * k as f64).collect();
            let last = ToolId(chain.tools().len() - 1);
            let (here, there) = (again.forward_to(last, &q), chain.forward_to(last, &q));
            // A rotation passes through its angles, which costs a few units in the last place.
            assert!((here.translation - there.translation).norm() < 1e-14);
            assert!((here.rotation - there.rotation).amax() < 1e-14);
        }
    }

    #[test]
    fn odd_names_are_quoted() {
        assert_eq!(quoted("a \"b\""), toml::Value::from("a \"b\"").to_string());
        let parsed: toml::Table = toml::from_str(&format!("x = {}", quoted("a\n\"b\\"))).unwrap();
        assert_eq!(parsed["x"].as_str(), Some("a\n\"b\\"));
    }
}
