//! `transfer` and `monitor`: a fit elsewhere, and later.

use crate::data::Data;
use crate::error::input;
use crate::fit::{Fit, Source};
use crate::run::supervised;
use pyo3::prelude::*;
use std::sync::Arc;
use truepose_report::{MonitorSummary, TransferSummary};
use truepose_upkeep::{
    Installation, MonitorOptions, TransferOptions, monitor as monitored, transfer as transferred,
};

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
    let (fitted, rows) = (fit.fitted.clone(), data.data.clone());
    let (made, json, text) = supervised(py, None, vec![fit.raised.clone()], move |_| {
        let options = TransferOptions { installation, update };
        let mut made = transferred(&fitted, &rows, options).map_err(input)?;
        let provenance = &mut made.fitted.provenance;
        provenance.insert("transferred".into(), true.into());
        provenance.insert("transfer_updated_the_arm".into(), update.into());
        provenance.insert("transfer_rows".into(), rows.len().into());
        let summary = TransferSummary::new(&made, &rows);
        Ok((made, serde_json::to_string(&summary).map_err(input)?, summary.to_string()))
    })?;
    Ok(Fit {
        fitted: Arc::new(made.fitted),
        source: Source::Other(json, text),
        objects: fit.objects.iter().map(|object| object.clone_ref(py)).collect(),
        raised: fit.raised.clone(),
    })
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
    let (fitted, rows) = (fit.fitted.clone(), data.data.clone());
    supervised(py, None, vec![fit.raised.clone()], move |_| {
        let options = MonitorOptions { alpha, looks, installation: Installation { base, tool, targets } };
        let seen = monitored(&fitted, &rows, options).map_err(input)?;
        let summary = MonitorSummary::new(fitted.chain().name(), &seen, looks + 1, alpha);
        Ok((seen.changed, serde_json::to_string(&summary).map_err(input)?, summary.to_string()))
    })
}
