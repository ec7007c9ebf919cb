//! What to measure so that an effect which the data cannot test becomes testable.

use crate::count;
use truepose_discover::{Diagnosis, Family, Setting, Untestable};
use truepose_errormodel::Visits;
use truepose_kinematics::{JointId, JointKind, Load};

/// Times as many poses up to which more of the same kind are advised. Convention: beyond it, other poses are less work.
const MORE: f64 = 5.0;

/// Times as large a load, and times as wide a range of a channel, up to which more of it is advised. Convention.
const LARGER: f64 = 10.0;
const WIDER: f64 = 100.0;

/// Share that the model does not imitate, below which other poses are what is missing. Convention.
const IMITATED: f64 = 0.5;

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
    if let Some(further) = varied(of, found).or_else(|| heavier(of, found)).or_else(|| farther(of, found)) {
        return further;
    }
    let Some(detectable) = of.detectable else {
        return "It does nothing on these poses: its joint, load or channel stands still.".into();
    };
    let seen = format!("It would show from {} mm RMS on", crate::significant(1e3 * detectable, 2));
    let absorbed = (100.0 * (1.0 - of.share)).clamp(0.0, 100.0);
    match of.share < IMITATED {
        true => format!("{seen}: the model imitates {absorbed:.0} % of it on these poses. {}", apart(of)),
        false => format!(
            "{seen}: on these poses it does little. Measure where its joint, load or channel is larger."
        ),
    }
}

/// What tells it from what the model has.
fn apart(of: &Untestable) -> &'static str {
    let of_order =
        |name: &String| ["travel_", "since_", "work_", "pause_"].iter().any(|word| name.starts_with(word));
    match of.family {
        Family::Instrument => {
            "Measure from a second place of the instrument, or over other distances from it."
        }
        _ if of.place.channel.as_ref().is_some_and(of_order) => "Measure the poses in another order as well.",
        _ => "Measure joints and loads in other combinations.",
    }
}

/// A channel that it follows varied too little.
fn varied(of: &Untestable, found: &Diagnosis) -> Option<String> {
    let name = of.place.channel.as_deref()?;
    let k = found.data.schema.channels.iter().position(|channel| channel.name == name)?;
    let values = &found.data.channels[k];
    let ends = values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &v| [a.min(v), b.max(v)]);
    let range = ends[1] - ends[0];
    let times = times(of, WIDER).filter(|_| range > 0.0)?;
    let unit = &found.data.schema.channels[k].unit;
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    let text = |value: f64| format!("{}{unit}", crate::significant(value, 2));
    Some(format!(
        "{name} varied by {}: an effect of usual size would show over {}.",
        text(range),
        text(times * range)
    ))
}

/// What was carried bends too little.
fn heavier(of: &Untestable, found: &Diagnosis) -> Option<String> {
    let loaded =
        [Family::JointCompliance, Family::LinkCompliance, Family::BaseCompliance, Family::LoadNonlinearity];
    let mass = |load: &Load| match load {
        Load::Payload(payload) => payload.mass,
        _ => 0.0,
    };
    let largest = found.data.load.iter().map(mass).fold(0.0, f64::max);
    let times = times(of, LARGER).filter(|_| loaded.contains(&of.family) && largest > 0.0)?;
    let mass = crate::significant(times * largest, 2);
    Some(format!(
        "Under {} kg an effect of usual size is too small: about {mass} kg would show it.",
        crate::significant(largest, 3)
    ))
}

/// How many times as large what drives it has to be, where that is what is missing: information grows with its square.
fn times(of: &Untestable, most: f64) -> Option<f64> {
    of.more_poses.map(f64::sqrt).filter(|&times| times <= most && of.share >= IMITATED)
}

/// The joint of the place turns near the targets.
fn farther(of: &Untestable, found: &Diagnosis) -> Option<String> {
    let chain = found.fit.fitted.chain();
    let name = of.place.joint.as_deref().filter(|_| of.share >= IMITATED)?;
    let turns =
        |joint: &JointId| chain.joint(*joint).name == name && chain.joint(*joint).kind == JointKind::Revolute;
    let own = [Family::Backlash, Family::Coupling, Family::Transmission];
    (own.contains(&of.family) && chain.movable().iter().any(turns)).then(|| {
        format!("It moves what is measured by little: measure a target farther from the axis of {name}.")
    })
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
