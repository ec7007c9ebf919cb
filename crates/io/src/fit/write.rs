//! Writing a fit file.

use super::schema_v1::FitV1;
use crate::{IoError, write_whole};
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;
use truepose_errormodel::FittedModel;

/// Writes a fit file, whole or not at all.
///
/// # Errors
/// When the file cannot be written, or the model holds a number that is not finite.
pub fn write_fit(path: impl AsRef<Path>, fit: &FittedModel) -> Result<(), IoError> {
    let path = path.as_ref();
    write_whole(path, fit_json(path, fit)?.as_bytes())
}

/// A fitted model as the text of a fit file of this name.
///
/// # Errors
/// When the model holds a number that is not finite.
pub fn fit_json(path: impl AsRef<Path>, fit: &FittedModel) -> Result<String, IoError> {
    text(fit).map_err(|message| IoError::Write { file: path.as_ref().into(), message })
}

/// The text of a fit file.
///
/// # Errors
/// Names the number that is not finite.
pub(super) fn text(fit: &FittedModel) -> Result<String, String> {
    check_finite(fit)?;
    let file = serde_json::to_value(FitV1::from(fit)).map_err(|error| error.to_string())?;
    let Value::Object(sections) = file else {
        return Err("the fit is not a JSON object".into());
    };
    // One line for a number's worth of things: sections, effects, coefficients, rows of the covariance.
    let mut text = String::from("{");
    for (k, (key, section)) in sections.iter().enumerate() {
        let comma = if k > 0 { "," } else { "" };
        let _ = write!(text, "{comma}\n\"{key}\": ");
        match section {
            Value::Array(items) if !items.is_empty() => {
                for (k, item) in items.iter().enumerate() {
                    let _ = write!(text, "{}\n  {item}", if k > 0 { "," } else { "[" });
                }
                text.push(']');
            }
            section => {
                let _ = write!(text, "{section}");
            }
        }
    }
    text.push_str("\n}\n");
    Ok(text)
}

/// JSON has no word for what is not finite; it would silently become `null`.
fn check_finite(fit: &FittedModel) -> Result<(), String> {
    for (column, value) in fit.model().columns().iter().zip(fit.coefficients()) {
        if !value.is_finite() {
            return Err(format!(
                "coefficient `{}` is {value}; a fit file holds finite numbers only",
                column.name
            ));
        }
    }
    if let Some(value) = fit.covariance().iter().find(|v| !v.is_finite()) {
        return Err(format!("the covariance holds {value}; a fit file holds finite numbers only"));
    }
    let domain = &fit.domain;
    let ranges = domain.joints.iter().chain(&domain.payload).chain(&domain.time).chain(&domain.channels);
    let mut others = ranges.flat_map(|r| [r.lower, r.upper]).chain([
        fit.noise.position_sd,
        fit.noise.orientation_sd,
        fit.repeatability_sd,
    ]);
    if let Some(value) = others.find(|v| !v.is_finite()) {
        return Err(format!("the domain or the noise holds {value}; a fit file holds finite numbers only"));
    }
    let rows = domain.sample.rows();
    let columns = rows.joints.iter().chain(&rows.approach).chain(&rows.channels).flatten().chain(&rows.time);
    let turned = rows.orientation.iter().flatten().flatten();
    let measured = rows.position.iter().flatten().filter(|v| !v.is_nan());
    if let Some(value) = columns.chain(turned).chain(measured).find(|v| !v.is_finite()) {
        return Err(format!("the sample holds {value}; a fit file holds finite numbers only"));
    }
    if let Some(load) = fit.loads.iter().find(|l| !(l.declared.is_finite() && l.carried.is_finite())) {
        return Err(format!("the payload {} kg is corrected to {} kg", load.declared, load.carried));
    }
    match fit.model().effects().iter().find(|effect| effect.parameters().is_null()) {
        Some(effect) => {
            Err(format!("effect `{}` has parameters that cannot be written to a file", effect.kind()))
        }
        None => Ok(()),
    }
}
