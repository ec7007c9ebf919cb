//! `transfer`, `monitor`, `fleet`: a fit elsewhere, later, and of its sisters.

use crate::data::Data;
use crate::error::input;
use crate::fit::{Fit, Source};
use crate::options::{solver, split};
use crate::plan::{Planned, planned};
use crate::robot::Robot;
use crate::run::supervised;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use truepose_report::{FleetSummary, MonitorSummary, TransferSummary};
use truepose_upkeep::{
    Installation, MonitorOptions, TransferOptions, check_poses, fleet as fleet_of, monitor as monitored,
    transfer as transferred,
};
use truepose_workflow::{identify_sister as sister, record_transferred};

/// The arm as identified, in another installation.
#[pyfunction]
#[pyo3(signature = (fit, data, tool, targets, update))]
pub fn transfer(
    py: Python<'_>,
    fit: &Fit,
    data: &Data,
    tool: bool,
    targets: bool,
    update: bool,
) -> PyResult<Fit> {
    let installation = Installation { base: true, tool, targets };
    data.plain()?;
    let (fitted, rows) = (fit.usable(py)?.first()?, data.data.clone());
    let (made, json, text) = supervised(py, None, vec![fit.raised.clone()], move |_| {
        let options = TransferOptions { installation, update };
        let mut made = transferred(&fitted, &rows, options).map_err(input)?;
        let summary = TransferSummary::new(&made, &rows);
        record_transferred(&mut made.fitted, &summary, update, rows.len());
        Ok((made, serde_json::to_string(&summary).map_err(input)?, summary.to_string()))
    })?;
    Ok(fit.with(py, made.fitted, Source::Other(json, text)))
}

/// Whether a robot has changed; the summary as JSON and as text.
#[pyfunction]
#[pyo3(signature = (fit, data, alpha, looks, base, tool, targets))]
#[allow(clippy::too_many_arguments)]
pub fn monitor(
    py: Python<'_>,
    fit: &Fit,
    data: &Data,
    alpha: f64,
    looks: usize,
    base: bool,
    tool: bool,
    targets: bool,
) -> PyResult<(bool, String, String)> {
    data.plain()?;
    let (fitted, rows) =
        (if base { fit.usable(py)?.first()? } else { fit.usable(py)?.one()? }, data.data.clone());
    supervised(py, None, vec![fit.raised.clone()], move |_| {
        let options = MonitorOptions { alpha, looks, installation: Installation { base, tool, targets } };
        let seen = monitored(&fitted, &rows, options).map_err(input)?;
        let summary = MonitorSummary::new(fitted.chain().name(), &seen, looks + 1, alpha);
        Ok((seen.changed, serde_json::to_string(&summary).map_err(input)?, summary.to_string()))
    })
}

/// What fits of robots of one type have in common, as prior for the next one.
#[pyfunction]
pub fn fleet(py: Python<'_>, fits: Vec<PyRef<'_, Fit>>) -> PyResult<Fit> {
    let all = fits.iter().map(|fit| Ok((*fit.usable(py)?.first()?).clone())).collect::<PyResult<Vec<_>>>()?;
    let mut made = py.detach(|| fleet_of(&all)).map_err(input)?;
    made.prior.provenance.insert("fleet_of".into(), made.robots.into());
    let summary = FleetSummary::new(&made);
    let source = Source::Other(serde_json::to_string(&summary).map_err(input)?, summary.to_string());
    let first = fits.first().ok_or_else(|| input("a fleet needs fits"))?;
    Ok(first.with(py, made.prior, source))
}

/// A robot from few poses with its sisters as prior.
#[pyfunction]
#[pyo3(signature = (robot, data, prior, solver_text, folds, split_kind, seed))]
#[allow(clippy::too_many_arguments)]
pub fn identify_sister(
    py: Python<'_>,
    robot: &Robot,
    data: &Data,
    prior: &Fit,
    solver_text: &str,
    folds: usize,
    split_kind: &str,
    seed: u64,
) -> PyResult<Fit> {
    data.plain()?;
    let (chain, rows, fleet) = (robot.chain.clone(), data.data.clone(), prior.fitted.clone());
    let (solver, _) = solver(solver_text)?;
    let Some(split) = split(&rows, folds.max(2), split_kind, seed)? else {
        return Err(input(format!("{}: one configuration is too few", data.name())));
    };
    let (fitted, json, text) = supervised(py, None, vec![prior.raised.clone()], move |_| {
        let (fitted, summary) = sister(&fleet, &chain, &rows, &split, &*solver).map_err(input)?;
        Ok((fitted, serde_json::to_string(&summary).map_err(input)?, summary.to_string()))
    })?;
    Ok(prior.with(py, fitted, Source::Other(json, text)))
}

/// Poses of a fit that show changes best: their joint values, payload and approach, and what they find, as JSON.
#[pyfunction]
#[pyo3(signature = (fit, count, alpha))]
pub fn monitoring<'py>(
    py: Python<'py>,
    fit: &Fit,
    count: usize,
    alpha: f64,
) -> PyResult<(Bound<'py, PyDict>, String)> {
    let fitted = fit.usable(py)?.first()?;
    let made = supervised(py, None, vec![fit.raised.clone()], {
        let fitted = fitted.clone();
        move |_| check_poses(&fitted, count, alpha).map_err(input)
    })?;
    let chosen: Vec<Planned<'_>> = made
        .poses
        .iter()
        .map(|pose| Planned {
            joints: &pose.joints,
            load: pose.load,
            approach: &pose.approach,
            why: "check",
            worth: 0.0,
        })
        .collect();
    let all = planned(py, fitted.chain(), &chosen)?;
    let one = |found: &truepose_upkeep::Detectable| {
        serde_json::json!({
            "what": found.what, "change": found.change, "unit": found.unit, "moves_mm": 1e3 * found.moves,
        })
    };
    let json = serde_json::json!({
        "poses": made.poses.len(),
        "detectable": made.detectable.iter().map(one).collect::<Vec<_>>(),
        "invisible": made.invisible,
    });
    Ok((all, json.to_string()))
}
