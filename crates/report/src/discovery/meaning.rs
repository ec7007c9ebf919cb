//! What each finding means, and why a candidate was not added, in one sentence each.

use crate::parameter_text;
use truepose_discover::{Change, Doubt, Finding};
use truepose_errormodel::Signal;

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

/// What a finding is, and what to inspect. `by_order`: the data has no time, and the order of its rows stands for it.
pub(super) fn meaning(finding: &Finding, by_order: bool) -> String {
    let candidate = &finding.candidate;
    let mut said = match candidate.change {
        Change::CorrectLoad { .. } => payload(finding),
        _ => candidate.meaning(),
    };
    if let Some(side) = candidate.first_side() {
        let from = if side > 0.0 { "below" } else { "above" };
        said += &format!(" Before its first move it is taken to have come from {from}: the data tell.");
    }
    let moves = candidate.effects().iter().any(|effect| effect.needs().contains(&Signal::Time));
    if by_order && moves {
        said += " The data has no time: this is in the order of its rows, and the fit that is written holds the mean over the record. For the \
                 robot as it was at the end, give the rows a `time[s]` (their numbers will do), here and wherever the fit is used.";
    }
    said
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
