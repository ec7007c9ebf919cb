//! What each finding means, and why a candidate was not added, in one sentence each.

use crate::parameter_text;
use truepose_discover::{Doubt, Family, Finding};

/// Why a candidate was not added.
pub(super) fn rejection(doubt: Doubt) -> &'static str {
    match doubt {
        Doubt::Chance => "not significant",
        Doubt::NotPredictive => "no improvement in cross-validation",
        Doubt::TooSmall => "improvement too small to matter",
        Doubt::Unstable => "not selected in every half-sample",
        Doubt::NothingNew => "the model contains it already",
        Doubt::NotConverged => "the fit with it does not converge",
        Doubt::WorseFit => "the fit with it has a larger training error",
        Doubt::WorseUnseen => "refitted with it, the model predicts unseen poses no better",
        Doubt::NotSignificant => "its coefficients are not significant in the refitted model",
        Doubt::NotPhysical => "its sign or size is not physical",
        _ => "rejected",
    }
}

/// What a finding is, and what to inspect.
pub(super) fn meaning(finding: &Finding) -> String {
    let place = &finding.candidate.place;
    let joint = match place.joint.as_deref() {
        None => "the robot",
        Some("base") => "the base",
        Some("tool") => "the tool",
        Some(joint) => joint,
    };
    match finding.candidate.family {
        Family::Outlier => "No repeatable effect explains these rows. Check the instrument's log.".into(),
        Family::Target => format!(
            "The position of target {} differs from the description. Measure it again.",
            place.target.as_deref().unwrap_or("")
        ),
        Family::Geometric => format!(
            "The frame of {joint} differs from the description. Inspect its seat and dowels, or correct the description."
        ),
        Family::JointCompliance => format!(
            "The deflection of {joint} is proportional to the load about its axis: stiffness of gear, bearing or drive."
        ),
        Family::BaseCompliance => "The base tilts or sinks under the load. Inspect its anchoring.".into(),
        Family::Backlash => format!(
            "The error of {joint} switches with its direction of approach. Inspect gear backlash, belt tension and preload."
        ),
        Family::Transmission => format!(
            "The transmission error of {joint} is periodic: eccentricity, gear mesh, strain wave gear or lead screw."
        ),
        Family::Coupling => format!(
            "The error of {joint} depends on the position of {}: belts, wrist gears or the calibration of coupled axes.",
            place.driver.as_deref().unwrap_or("another joint")
        ),
        Family::Guideway => format!(
            "The linear guideway of {joint} has errors of straightness or angle along its travel. Inspect its bolts, shims and \
             carriage."
        ),
        Family::Payload => payload(finding),
        Family::LinkCompliance => format!(
            "The link behind {joint} bends or twists under load. Inspect its flange bolts and bearings; otherwise it is the \
             stiffness of the link."
        ),
        Family::LoadNonlinearity => format!(
            "The deflection of {joint} is not proportional to its load: clearance in a bearing or gear, or a strain wave gear that \
             stiffens."
        ),
        Family::Shift => format!(
            "The error of {joint} jumped once: a collision, a changed part or a new installation. Check the log at that time."
        ),
        Family::Thermal => format!(
            "The error of {joint} follows {}: thermal expansion. Warm up, shield, or compensate with the sensor.",
            place.channel.as_deref().unwrap_or("a temperature")
        ),
        Family::Drift => format!(
            "The error of {joint} changes slowly with time: warm-up, settling, or drift of the instrument. Warm up longer, or \
             measure a fixed point at intervals."
        ),
        Family::Unmodelled
            if place.joint.is_some() && place.joint == place.covariate && place.component.is_none() =>
        {
            format!(
                "The axis of {joint} has an error motion as the joint turns. Inspect its bearings and their seats. No named family \
                 describes this error."
            )
        }
        Family::Unmodelled => format!(
            "An error at {joint} depends on {}. No named family describes this error.",
            [place.covariate.as_deref(), place.covariate2.as_deref()]
                .into_iter()
                .flatten()
                .collect::<Vec<_>>()
                .join(" and ")
        ),
    }
}

/// A wrong payload, with the estimate of its mass where it is known.
fn payload(finding: &Finding) -> String {
    let declared = finding.candidate.place.level.unwrap_or_default();
    match finding.parameters.iter().find(|parameter| parameter.name == "mass") {
        Some(mass) => {
            let (value, unit) = parameter_text(mass);
            format!("The payload declared as {declared} kg fits as {value} {unit}. Check the declared mass.")
        }
        None => format!("The payload declared as {declared} kg does not fit. Check the declared mass."),
    }
}
