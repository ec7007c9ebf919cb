//! What a program states besides its points.

use super::rows::{Part, short};
use super::taught;
use truepose_controllers::CorrectOptions;
use truepose_errormodel::FittedModel;

/// A line for each.
pub(super) fn statements(
    fitted: &FittedModel,
    parts: &[Part<'_>],
    options: &CorrectOptions,
    payload: Option<f64>,
) -> Vec<String> {
    let mut all = Vec::new();
    all.extend(taught::note(&taught::open(parts, options)));
    all.extend(loads(fitted, parts, payload));
    all
}

/// Loads that the program states, where the fit has an effect of the load and none is given.
fn loads(fitted: &FittedModel, parts: &[Part<'_>], payload: Option<f64>) -> Option<String> {
    let known = fitted.domain.payload.as_ref()?;
    if payload.is_some() {
        return None;
    }
    let stated: Vec<String> = parts
        .iter()
        .flat_map(|part| {
            part.program
                .notes()
                .iter()
                .filter(|note| note.load && note.file == 0)
                .map(|note| (part.file, note))
        })
        .take(3)
        .map(|(file, note)| format!("{}, line {}: {}", short(file), note.line, note.words))
        .collect();
    if stated.is_empty() && known.upper - known.lower <= 0.0 {
        return None;
    }
    let words = match stated.is_empty() {
        true => "the program states none".into(),
        false => stated.join("; "),
    };
    Some(format!(
        "the fit has loads from {} kg to {} kg, and the program is compensated without a load, as none is stated (--payload, --com): {words}",
        known.lower, known.upper
    ))
}
