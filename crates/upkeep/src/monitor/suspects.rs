//! What may have changed: constant errors one by one, other effects as a whole, coefficients of an effect one by one.

use truepose_errormodel::FittedModel;
use truepose_kinematics::{Axis, Chain, JointKind, JointMotion, Site};

/// A set of coefficients that may have changed together.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Suspect {
    /// As the program calls it: `rz of j3`, `transmission j1`.
    pub word: String,
    /// Family of the effect.
    pub family: String,
    /// Columns of the model.
    pub columns: Vec<usize>,
    /// Whether it is the zero of a joint.
    pub is_zero: bool,
}

/// All suspects of a fit. Constant errors of an installation that is found anew are none.
pub(super) fn suspects(fitted: &FittedModel, placed: &[Site]) -> Vec<Suspect> {
    let model = fitted.model();
    let mut all: Vec<Suspect> = Vec::new();
    for (k, effect) in model.effects().iter().enumerate() {
        let columns = model.columns_of(k);
        if model.is_constant(k) {
            for column in columns {
                let site = model.columns()[column].site;
                if !site.is_some_and(|site| placed.contains(&site)) {
                    let name = &model.columns()[column].name;
                    // What turns or slides as a joint does is a wrong zero of that joint.
                    let joint = site.and_then(|site| moves_with(fitted.chain(), site));
                    let is_zero = joint.is_some();
                    let word =
                        joint.map_or_else(|| name.clone(), |joint| format!("zero of {joint} ({name})"));
                    all.push(Suspect { word, family: effect.kind().into(), columns: vec![column], is_zero });
                }
            }
        } else if !columns.is_empty() {
            // The part of the names that all coefficients share: `transmission j1`.
            let names: Vec<&str> = columns.clone().map(|c| model.columns()[c].name.as_str()).collect();
            all.push(Suspect {
                word: shared(&names),
                family: effect.kind().into(),
                columns: columns.collect(),
                is_zero: false,
            });
        }
    }
    all
}

/// The joint whose own motion an error at this site is, by name.
fn moves_with(chain: &Chain, site: Site) -> Option<&str> {
    let Site::Frame(frame, axis) = site else { return None };
    let along = |motion: &JointMotion| {
        let turning = motion.kind == JointKind::Revolute;
        let direction = Axis::ALL.iter().position(|a| *a == axis).unwrap_or(0) % 3;
        motion.frame == frame && turning == axis.is_rotation() && motion.axis[direction].abs() > 1.0 - 1e-9
    };
    let mut joints = chain.movable().iter().rev();
    let joint = joints.find(|&&joint| chain.joint_motion(joint).is_some_and(|motion| along(&motion)))?;
    Some(&chain.joint(*joint).name)
}

/// The words that all names begin with.
fn shared(names: &[&str]) -> String {
    let Some(first) = names.first() else { return String::new() };
    let words: Vec<&str> = first.split(' ').collect();
    let same = |count: &usize| {
        let start = words[..*count].join(" ");
        names.iter().all(|name| *name == start || name.starts_with(&format!("{start} ")))
    };
    let count = (1..=words.len()).rev().find(same).unwrap_or(0);
    if count == 0 { (*first).to_owned() } else { words[..count].join(" ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_of_an_effect_have_their_beginning_as_its_word() {
        assert_eq!(shared(&["transmission a1 sin1", "transmission a1 cos1"]), "transmission a1");
        assert_eq!(shared(&["backlash a2"]), "backlash a2");
        assert_eq!(shared(&["joint_compliance j1", "joint_compliance j2"]), "joint_compliance");
    }
}
