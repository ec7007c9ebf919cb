//! What a search found, with its data.

use crate::error::input;
use crate::fit::{Fit, Source};
use crate::page;
use crate::run::Raised;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;
use truepose_discover::Diagnosis;
use truepose_errormodel::{Dataset, FittedModel};
use truepose_report::{DiscoverySummary, NestedSummary, discovery_report};
use truepose_workflow::parameters;

/// A discovery with its data.
#[pyclass(frozen, module = "truepose._core")]
pub struct Discovery {
    pub found: Arc<Diagnosis>,
    pub data: Arc<Dataset>,
    pub labels: Vec<i64>,
    pub summary: DiscoverySummary,
    /// The enlarged fit as it is used: it knows its sessions, and landmarks are no part of it.
    pub used: Arc<FittedModel>,
    pub remarks: Vec<String>,
    pub objects: Vec<Py<PyAny>>,
    pub raised: Raised,
}

#[pymethods]
impl Discovery {
    /// `discovery.json`.
    fn summary(&self) -> PyResult<String> {
        serde_json::to_string(&self.summary).map_err(input)
    }

    fn text(&self) -> String {
        self.summary.to_string()
    }

    /// What a user should know of sessions and landmarks.
    fn remarks(&self) -> Vec<String> {
        self.remarks.clone()
    }

    /// The enlarged fit.
    fn fit(&self, py: Python<'_>) -> PyResult<Fit> {
        Ok(Fit {
            fitted: self.used.clone(),
            source: Source::Discovered(Box::new((self.found.fit.clone(), self.found.data.clone()))),
            objects: self.objects.iter().map(|object| object.clone_ref(py)).collect(),
            raised: self.raised.clone(),
            accepted: false,
        })
    }

    /// Fits of competing hypotheses: number of the finding (from 0), words, fit.
    fn rivals(&self, py: Python<'_>) -> Vec<(usize, String, Fit)> {
        let one = |rival: &truepose_discover::CompetingFit| {
            let fit = Fit {
                fitted: Arc::new(usable(&rival.fit.fitted)),
                source: Source::Discovered(Box::new((rival.fit.clone(), self.found.data.clone()))),
                objects: self.objects.iter().map(|object| object.clone_ref(py)).collect(),
                raised: self.raised.clone(),
                accepted: false,
            };
            (rival.finding, rival.candidate.words(), fit)
        };
        self.found.competitors.iter().map(one).collect()
    }

    /// Figures of the report: name and SVG.
    fn figures(&self) -> PyResult<Vec<(String, String)>> {
        Ok(self.report()?.figures)
    }

    /// Writes the report into a folder.
    fn write_report(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        let mut summary = self.summary.clone();
        summary.parameters = Some(parameters(&self.used));
        py.detach(|| {
            page::write(&folder, "discovery.json", &summary, |run| {
                discovery_report(&summary, &self.found, &self.data, &self.labels, run).map_err(input)
            })
        })
    }
}

impl Discovery {
    /// The same with a nested cross-validation.
    pub fn validated(&self, py: Python<'_>, nested: NestedSummary) -> Discovery {
        Discovery {
            found: self.found.clone(),
            data: self.data.clone(),
            labels: self.labels.clone(),
            summary: DiscoverySummary { nested: Some(nested), ..self.summary.clone() },
            used: self.used.clone(),
            remarks: self.remarks.clone(),
            objects: self.objects.iter().map(|object| object.clone_ref(py)).collect(),
            raised: self.raised.clone(),
        }
    }

    fn report(&self) -> PyResult<truepose_report::Report> {
        let run = page::record("discovery.json", &[]);
        discovery_report(&self.summary, &self.found, &self.data, &self.labels, &run).map_err(input)
    }
}

/// A fit for poses of which nothing tells where in the order of the record they stand; as it is where that cannot be said of it.
pub fn usable(fitted: &FittedModel) -> FittedModel {
    fitted.without_order().unwrap_or_else(|_| fitted.clone())
}
