//! A fit: the model with its coefficients, and where it came from.

use crate::arrays::{matrix, rows, vector};
use crate::data::Data;
use crate::error::{input, of_io};
use crate::model::{of_python, prepare, registry};
use crate::page;
use crate::predicted::{Told, compensated, maker, predicted};
use crate::robot::Robot;
use crate::run::Raised;
use crate::table::Table;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ffi::CString;
use std::path::PathBuf;
use std::sync::Arc;
use truepose_compensate::ExportOptions;
use truepose_errormodel::{Dataset, FittedModel};
use truepose_identify::reduction::group_words;
use truepose_identify::{Fit as Fitted, Residuals, student_quantile};
use truepose_io::{fit_json, parse_fit, read_fit};
use truepose_report::identification_report;
use truepose_workflow::{ExportFormat, ExportRequest, Identified, export, in_session, marks, parameters};

/// Where a fit came from.
pub enum Source {
    /// A file.
    Loaded,
    Identified(Box<Identified>),
    /// The fit of a discovery with its data, or of a competing hypothesis.
    Discovered(Box<(Fitted, Dataset)>),
    /// Another verb, with its summary as JSON and as text.
    Other(String, String),
}

/// A fitted model.
#[pyclass(frozen, module = "truepose._core")]
pub struct Fit {
    pub fitted: Arc<FittedModel>,
    pub source: Source,
    pub objects: Vec<Py<PyAny>>,
    pub raised: Raised,
    /// Whether it is used although it does not fit.
    pub accepted: bool,
}

impl Fit {
    fn whole(&self) -> Option<&Fitted> {
        match &self.source {
            Source::Identified(made) => Some(&made.found.fit),
            Source::Discovered(found) => Some(&found.0),
            Source::Loaded | Source::Other(..) => None,
        }
    }

    /// This fit, with warnings about it; refused where it does not fit and is not accepted all the same.
    pub fn usable(&self, py: Python<'_>) -> PyResult<&Self> {
        let class = py.import("truepose")?.getattr("TrueposeWarning")?;
        let marks = marks(&self.fitted, self.accepted)
            .map_err(|words| input(format!("{words}, or insist with accept()")))?;
        for words in marks {
            let words = CString::new(words).map_err(input)?;
            PyErr::warn(py, &class, &words, 2)?;
        }
        Ok(self)
    }

    /// The fit in its only installation; refuses one of several.
    pub fn one(&self) -> PyResult<Arc<FittedModel>> {
        match self.fitted.sessions.len() {
            0 => Ok(self.fitted.clone()),
            1 => in_session((*self.fitted).clone(), None, true).map(Arc::new).map_err(input),
            _ => {
                let names: Vec<&str> = self.fitted.sessions.iter().map(|s| s.name.as_str()).collect();
                let names = names.join(", ");
                Err(input(format!(
                    "the fit has several sessions ({names}): choose one with in_session(name)"
                )))
            }
        }
    }

    /// The fit in its first installation, where any will do.
    pub fn first(&self) -> PyResult<Arc<FittedModel>> {
        match self.fitted.sessions.is_empty() {
            true => Ok(self.fitted.clone()),
            false => in_session((*self.fitted).clone(), None, true).map(Arc::new).map_err(input),
        }
    }

    /// Another fit with the effects of this one.
    pub fn with(&self, py: Python<'_>, fitted: FittedModel, source: Source) -> Self {
        let objects = self.objects.iter().map(|object| object.clone_ref(py)).collect();
        Fit {
            fitted: Arc::new(fitted),
            source,
            objects,
            raised: self.raised.clone(),
            accepted: self.accepted,
        }
    }

    /// What Python code raised meanwhile, else the result.
    fn checked<T>(&self, result: PyResult<T>) -> PyResult<T> {
        self.raised.take().map_or(result, Err)
    }

    fn loaded(fitted: FittedModel, raised: Raised, py: Python<'_>) -> Self {
        let objects =
            of_python(fitted.model().effects()).map(|effect| effect.object().clone_ref(py)).collect();
        Fit { fitted: Arc::new(fitted), source: Source::Loaded, objects, raised, accepted: false }
    }
}

fn failed<T>(raised: &Raised, result: Result<T, truepose_io::IoError>) -> PyResult<T> {
    result.map_err(|error| raised.take().unwrap_or_else(|| of_io(error)))
}

#[pymethods]
impl Fit {
    /// Reads a fit file; `effects` are classes of Python effects that it contains.
    #[staticmethod]
    fn from_file(py: Python<'_>, path: PathBuf, effects: Vec<Py<PyAny>>) -> PyResult<Self> {
        let raised = Raised::default();
        let registry = registry(py, effects, &raised)?;
        let fitted = failed(&raised, py.detach(|| read_fit(&path, &registry)))?;
        Ok(Fit::loaded(fitted, raised, py))
    }

    #[staticmethod]
    fn from_json(py: Python<'_>, text: &str, effects: Vec<Py<PyAny>>) -> PyResult<Self> {
        let raised = Raised::default();
        let registry = registry(py, effects, &raised)?;
        let fitted = failed(&raised, py.detach(|| parse_fit(text, &registry)))?;
        Ok(Fit::loaded(fitted, raised, py))
    }

    /// The text of the fit file.
    fn to_json(&self) -> PyResult<String> {
        fit_json("fit", &self.fitted).map_err(of_io)
    }

    /// Effects of Python in the model.
    #[getter]
    fn objects(&self, py: Python<'_>) -> Vec<Py<PyAny>> {
        self.objects.iter().map(|object| object.clone_ref(py)).collect()
    }

    /// Names of the installations that it knows; none where it is one.
    #[getter]
    fn sessions(&self) -> Vec<String> {
        self.fitted.sessions.iter().map(|session| session.name.clone()).collect()
    }

    /// The fit in one of them.
    fn in_session(&self, py: Python<'_>, name: &str) -> PyResult<Self> {
        let made = in_session((*self.fitted).clone(), Some(name), false).map_err(input)?;
        Ok(self.with(py, made, Source::Loaded))
    }

    /// The same fit, used although it does not fit.
    fn accept(&self, py: Python<'_>) -> Self {
        let fitted = (*self.fitted).clone();
        Fit { accepted: true, ..self.with(py, fitted, Source::Loaded) }
    }

    fn robot(&self) -> Robot {
        Robot::of(self.fitted.chain(), &self.fitted)
    }

    /// The summary of the verb that made it, as JSON; none of a loaded one.
    fn summary(&self) -> PyResult<Option<String>> {
        match &self.source {
            Source::Identified(made) => serde_json::to_string(&made.summary).map(Some).map_err(input),
            Source::Other(json, _) => Ok(Some(json.clone())),
            Source::Loaded | Source::Discovered(_) => Ok(None),
        }
    }

    fn text(&self) -> Option<String> {
        match &self.source {
            Source::Identified(made) => Some(made.summary.to_string()),
            Source::Other(_, text) => Some(text.clone()),
            Source::Loaded | Source::Discovered(_) => None,
        }
    }

    /// How it came about, as JSON.
    fn provenance(&self) -> PyResult<String> {
        serde_json::to_string(&self.fitted.provenance).map_err(input)
    }

    /// Of each coefficient: family of its effect, name, SI unit, value, standard deviation, half width of its 95 % interval (NaN where the
    /// degrees of freedom are not known).
    fn coefficients(&self) -> Vec<(&'static str, String, String, f64, f64, f64)> {
        let model = self.fitted.model();
        // Of a fit with landmarks the file has the robot alone.
        let half = self.whole().map(|fit| {
            let (half, all) = (fit.half_widths(), fit.fitted.model());
            let own =
                |k: &usize| ["landmarks", "observed"].contains(&all.effects()[all.effect_of(*k)].kind());
            (0..half.len()).filter(|k| !own(k)).map(|k| half[k]).collect::<Vec<f64>>()
        });
        let covariance = self.fitted.covariance();
        let one = |(k, (column, &value)): (usize, (&truepose_errormodel::Column, &f64))| {
            let family = model.effects()[model.effect_of(k)].kind();
            let deviation = covariance[(k, k)].max(0.0).sqrt();
            let half = half.as_ref().map_or(f64::NAN, |half| half[k]);
            (family, column.name.clone(), column.unit.clone(), value, deviation, half)
        };
        model.columns().iter().zip(self.fitted.coefficients()).enumerate().map(one).collect()
    }

    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        matrix(py, self.fitted.covariance())
    }

    /// Of each group of errors that the data determines: words, unit, value, half width of its 95 % interval; none of a loaded fit.
    fn groups(&self) -> Option<Vec<(String, String, f64, f64)>> {
        let fit = self.whole()?;
        let (model, coefficients) = (fit.fitted.model(), fit.fitted.coefficients());
        let half = fit.half_widths();
        let one = |group: &truepose_identify::reduction::Group| {
            let unit = model.columns()[group.column].unit.clone();
            let (words, sign) = group_words(model, group);
            (words, unit, sign * coefficients[group.column], half[group.column])
        };
        Some(fit.reduction.groups.iter().map(one).collect())
    }

    /// Factor from a standard deviation to the half width of a 95 % interval.
    fn coverage_factor(&self) -> Option<f64> {
        Some(student_quantile(0.975, self.whole()?.degrees_of_freedom()))
    }

    /// Standard deviation of one component of a new position, m, and the part that rows of a visit share.
    #[getter]
    fn noise(&self) -> (f64, f64) {
        (self.fitted.noise.position_sd, self.fitted.repeatability_sd)
    }

    /// Residuals of the rows of the fit: positions, m, and orientations, rad.
    fn residuals<'py>(&self, py: Python<'py>) -> Option<Both<'py>> {
        Some(both(py, &self.whole()?.residuals))
    }

    /// The same of cross-validation, and the fold of each row, with the RMS of each fold, m.
    #[allow(clippy::type_complexity)]
    fn held_out<'py>(
        &self,
        py: Python<'py>,
    ) -> Option<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Vec<f64>, [f64; 4])> {
        let Source::Identified(made) = &self.source else { return None };
        let known = made.found.declared.held_out.as_ref()?;
        let (position, orientation) = both(py, &known.residuals);
        let spread = known.residuals.positions();
        Some((
            position,
            orientation,
            known.fold_rms.clone(),
            [spread.mean, spread.rms, spread.p95, spread.max],
        ))
    }

    /// Residuals of other rows.
    fn residuals_of<'py>(&self, py: Python<'py>, data: &Data) -> PyResult<Both<'py>> {
        let (fitted, rows) = (self.one()?, data.data.clone());
        let effects = self.fitted.model().effects();
        let residuals = self.checked(py.detach(|| {
            prepare(effects, fitted.chain(), &rows)?;
            Residuals::of(&fitted, &rows).map_err(input)
        }))?;
        Ok(both(py, &residuals))
    }

    /// Predicts rows: columns of the file of predictions, without what it repeats of the input; and warnings.
    fn predict<'py>(&self, py: Python<'py>, data: &Data) -> Told<'py> {
        self.usable(py)?;
        if data.info.sessions.is_empty() {
            self.one()?;
        }
        let (fitted, input_rows) = (self.fitted.clone(), data.data.clone());
        let effects = self.fitted.model().effects();
        let predicted = self.checked(py.detach(|| {
            prepare(effects, fitted.chain(), &input_rows)?;
            predicted(&fitted, &input_rows, &data.info).map_err(input)
        }))?;
        let all = PyDict::new(py);
        let (list, warnings) = &predicted;
        all.set_item("position", rows(py, list.iter().map(|p| p.pose.translation.into())))?;
        let turned = |p: &truepose_io::Prediction| match p.oriented {
            true => p.pose.quaternion(),
            false => [f64::NAN; 4],
        };
        all.set_item("orientation", rows(py, list.iter().map(turned)))?;
        all.set_item("within_95", vector(py, list.iter().map(|p| p.within_95).collect()))?;
        all.set_item("extrapolates", vector(py, list.iter().map(|p| p.extrapolates).collect()))?;
        Ok((all, warnings.clone()))
    }

    /// Commands for desired poses, with these joints held; and warnings.
    fn compensate<'py>(&self, py: Python<'py>, poses: &Table, hold: Vec<String>) -> Told<'py> {
        let fitted = (*self.usable(py)?.one()?).clone().of_robot();
        let told = compensated(py, &fitted, poses, &hold);
        self.checked(told)
    }

    /// The fitted geometry as the text of a file, and what it leaves out.
    #[allow(clippy::too_many_arguments)]
    fn export(
        &self,
        py: Python<'_>,
        format: &str,
        style: Option<&str>,
        target: Option<&str>,
        urdf: Option<PathBuf>,
        hayati: bool,
        entries: usize,
    ) -> PyResult<(String, Vec<String>)> {
        let fitted = self.usable(py)?.first()?;
        let chain = fitted.chain();
        let target = target
            .map(|name| {
                chain.target_named(name).ok_or_else(|| input(format!("the robot has no target `{name}`")))
            })
            .transpose()?;
        if format == "parameters" {
            return Err(input("the parameters as described are a table; see `parameters`"));
        }
        let request = ExportRequest {
            format: ExportFormat::named(format).map_err(input)?,
            urdf: urdf.as_deref(),
            hayati,
            entries,
            style: style.map(maker).transpose()?,
            like: None,
            hash: None,
        };
        let options = ExportOptions { target, ..ExportOptions::default() };
        let fitted = (*fitted).clone().of_robot();
        let written = self.checked(py.detach(|| export(&request, &fitted, &options).map_err(input)))?;
        Ok((written.text, written.statement))
    }

    /// The parameters of the robot as it is described: nominal, calibrated, 95 % interval, as JSON.
    fn parameters(&self, py: Python<'_>) -> PyResult<String> {
        let made = self.checked(Ok(py.detach(|| parameters(&self.fitted))))?;
        serde_json::to_string(&made).map_err(input)
    }

    /// Figures of the report: name and SVG; none of a loaded fit.
    fn figures(&self) -> PyResult<Vec<(String, String)>> {
        let Source::Identified(made) = &self.source else { return Ok(Vec::new()) };
        let run = page::record("identification.json", &[]);
        let report = identification_report(
            &made.summary,
            &made.found,
            &made.campaign.data,
            &made.source.info.visit_labels,
            &run,
        );
        Ok(report.map_err(input)?.figures)
    }

    /// Writes the report into a folder.
    fn write_report(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        let Source::Identified(made) = &self.source else {
            return Err(input(
                "a report is made of an identification or a discovery, and not of a fit that was loaded",
            ));
        };
        let mut summary = made.summary.clone();
        summary.parameters = Some(parameters(&self.fitted));
        py.detach(|| {
            page::write(&folder, "identification.json", &summary, |run| {
                identification_report(
                    &summary,
                    &made.found,
                    &made.campaign.data,
                    &made.source.info.visit_labels,
                    run,
                )
                .map_err(input)
            })
        })
    }
}

/// Residuals of positions and of orientations, rows of three.
type Both<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

fn both<'py>(py: Python<'py>, of: &Residuals) -> Both<'py> {
    let turn = |turn: &Option<truepose_kinematics::nalgebra::Vector3<f64>>| {
        turn.map_or([f64::NAN; 3], <[f64; 3]>::from)
    };
    (rows(py, of.position.iter().map(|v| (*v).into())), rows(py, of.orientation.iter().map(turn)))
}
