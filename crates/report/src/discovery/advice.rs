//! What to measure so that an effect which the data cannot test becomes testable.

use crate::count;
use truepose_discover::{Diagnosis, Family, Setting, Untestable};
use truepose_errormodel::Visits;
use truepose_kinematics::{JointKind, Load};

/// Times as many poses up to which more of the same kind are advised. Convention: beyond it, other poses are less work.
const MORE: f64 = 5.0;

/// Part of a joint's range below which it moved little.
const LITTLE: f64 = 0.5;

/// One sentence.
pub(super) fn advice(of: &Untestable, found: &Diagnosis) -> String {
    let poses = Visits::of(&found.data).len();
    if let Some(times) = of.more_poses.filter(|times| *times <= MORE) {
        let total = (times * poses as f64).ceil() as usize;
        return format!("About {} of the same kind would do.", count(total.max(poses + 1), "pose"));
    }
    if let Some(values) = values(of, found) {
        return values;
    }
    if let Some(wider) = wider(of, found) {
        return wider;
    }
    let loaded =
        [Family::JointCompliance, Family::LinkCompliance, Family::BaseCompliance, Family::LoadNonlinearity];
    if loaded.contains(&of.family) && !several_loads(found) {
        let loads =
            if of.family == Family::LoadNonlinearity { "three or more payloads" } else { "two payloads" };
        return format!("Measure with {loads}.");
    }
    "It needs poses in which it acts otherwise than the effects of the model.".into()
}

/// The joint of the place stood at too few values for a function of its own.
fn values(of: &Untestable, found: &Diagnosis) -> Option<String> {
    let chain = found.fit.fitted.chain();
    let name = of.place.joint.as_deref().filter(|_| of.family == Family::Transmission)?;
    let joint = *chain.movable().iter().find(|joint| chain.joint(**joint).name == name)?;
    let levels = Setting::new(chain, &found.data).levels(joint);
    (!levels.are_enough()).then(|| {
        format!(
            "{name} stood at {} only: between them a periodic error or a curve may be anything. Measure at {} or more, unequally \
             spaced.",
            count(levels.count, "value"),
            levels.wanted()
        )
    })
}

/// The joint of the place moved over little of its range.
fn wider(of: &Untestable, found: &Diagnosis) -> Option<String> {
    let chain = found.fit.fitted.chain();
    let name = of.place.joint.as_deref()?;
    let (k, joint) =
        chain.movable().iter().enumerate().find(|(_, joint)| chain.joint(**joint).name == name)?;
    let joint = chain.joint(*joint);
    let ends = found.data.joints[k]
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &q| [a.min(q), b.max(q)]);
    let moved = ends[1] - ends[0];
    let slides = joint.kind == JointKind::Prismatic;
    let whole =
        joint.limits.map(|(lower, upper)| upper - lower).or((!slides).then_some(std::f64::consts::TAU))?;
    let text = |value: f64| match slides {
        true => format!("{} mm", crate::significant(1e3 * value, 3)),
        false => format!("{}°", crate::significant(value.to_degrees(), 3)),
    };
    (moved >= 0.0 && moved < LITTLE * whole)
        .then(|| format!("Move {name} over more than {} (it can move over {}).", text(moved), text(whole)))
}

fn several_loads(found: &Diagnosis) -> bool {
    let first = found.data.load.first();
    found.data.load.iter().any(|load| matches!(load, Load::Wrench(_)) || Some(load) != first)
}
