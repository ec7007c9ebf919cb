//! What each finding means, and why a candidate was not added, in one sentence each.

use crate::parameter_text;
use truepose_discover::{Change, Doubt, Finding};

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
    match finding.candidate.change {
        Change::CorrectLoad { .. } => payload(finding),
        _ => match finding.candidate.first_side() {
            Some(side) => format!(
                "{} Before its first move it is taken to have come from {}: the data tell.",
                finding.candidate.meaning(),
                if side > 0.0 { "below" } else { "above" }
            ),
            None => finding.candidate.meaning(),
        },
    }
}

/// A wrong payload, with the estimate of its mass where it is known.
fn payload(finding: &Finding) -> String {
    let declared = finding.candidate.place.level.unwrap_or_default();
    match finding.parameters.iter().find(|parameter| parameter.name == "mass") {
        Some(mass) => {
            let (value, unit) = parameter_text(mass);
            if let Change::CorrectLoad { during: Some([from, until]), .. } = finding.candidate.change {
                return format!(
                    "The payload declared as {declared} kg fits as {value} {unit} from {from:.0} to {until:.0} s. Check the log of loads at \
                     that time."
                );
            }
            format!("The payload declared as {declared} kg fits as {value} {unit}. Check the declared mass.")
        }
        None => finding.candidate.meaning(),
    }
}
