//! `iso9283`: accuracy and repeatability of repeated poses.

use crate::data::Data;
use crate::error::input;
use crate::fit::Fit;
use crate::page;
use crate::robot::Robot;
use crate::run::supervised;
use pyo3::prelude::*;
use std::path::PathBuf;
use truepose_acceptance::{Alignment, AssessmentOptions, assess};
use truepose_report::{AcceptanceSummary, Limit, acceptance_report};

/// Figures of ISO 9283, with their verdicts.
#[pyclass(frozen, module = "truepose._core")]
pub struct Acceptance(AcceptanceSummary);

#[pymethods]
impl Acceptance {
    /// `acceptance.json`.
    fn summary(&self) -> PyResult<String> {
        serde_json::to_string(&self.0).map_err(input)
    }

    fn text(&self) -> String {
        self.0.to_string()
    }

    /// Whether a figure does not conform to its limit.
    fn fails(&self) -> bool {
        self.0.fails()
    }

    /// Figures of the report: name and SVG.
    fn figures(&self) -> Vec<(String, String)> {
        acceptance_report(&self.0, &page::record("acceptance.json", &[])).figures
    }

    /// Writes the report into a folder.
    fn write_report(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        py.detach(|| {
            page::write(&folder, "acceptance.json", &self.0, |run| Ok(acceptance_report(&self.0, run)))
        })
    }
}

/// Of a robot as described, or of a fit with the displacement that its model predicts taken off.
#[pyfunction]
#[pyo3(signature = (robot, fit, data, align, instrument, path, spec))]
#[allow(clippy::too_many_arguments)]
pub fn iso9283(
    py: Python<'_>,
    robot: &Robot,
    fit: Option<&Fit>,
    data: &Data,
    align: Option<&str>,
    instrument: f64,
    path: bool,
    spec: Vec<(String, f64)>,
) -> PyResult<Acceptance> {
    data.plain()?;
    let alignment = match align {
        None => None,
        Some("described") => Some(Alignment::Described),
        Some("best-fit") => Some(Alignment::BestFit),
        Some(other) => return Err(input(format!("align: unknown `{other}` (known: described, best-fit)"))),
    };
    if !(instrument.is_finite() && instrument >= 0.0) {
        return Err(input(format!("instrument: {instrument} is no length; it has to be 0 or more, in m")));
    }
    let limits = spec.iter().map(limit).collect::<PyResult<Vec<_>>>()?;
    // Errors of instrument and log are none of the robot.
    let fitted = fit.map(|fit| Ok::<_, PyErr>((*fit.usable(py)?.one()?).clone().of_robot())).transpose()?;
    let (chain, rows, name) = (robot.chain.clone(), data.data.clone(), data.name());
    let raised = fit.map(|fit| fit.raised.clone()).into_iter().collect();
    supervised(py, None, raised, move |_| {
        let chain = fitted.as_ref().map_or(&*chain, |fitted| fitted.chain());
        let options = AssessmentOptions { alignment, common: instrument, path };
        let found = assess(chain, fitted.as_ref(), &rows, &options)
            .map_err(|error| input(format!("{name}: {error}")))?;
        Ok(Acceptance(AcceptanceSummary::new(chain.name(), rows.len(), &found, &limits)))
    })
}

/// A limit of a figure, m.
fn limit((name, length): &(String, f64)) -> PyResult<Limit> {
    let Some((known, _)) = Limit::KNOWN.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)) else {
        let known: Vec<&str> = Limit::KNOWN.iter().map(|(known, _)| *known).collect();
        return Err(input(format!("spec: `{name}` is no figure with a limit (known: {})", known.join(", "))));
    };
    if !(length.is_finite() && *length > 0.0) {
        return Err(input(format!("spec: {length} is no limit; a length above 0 is needed, in m")));
    }
    Ok(Limit { characteristic: (*known).into(), limit: *length })
}
