//! The page of an identification.

use super::rows::{Rows, complement, merged};
use super::sheet::SheetStage;
use super::{Page, Report};
use crate::figure::{Bar, bars, unit_text};
use crate::{
    Correction, IdentificationSummary, NonlinearParameterSummary, RunRecord, SpecificationLines, count,
    significant,
};
use truepose_errormodel::Dataset;
use truepose_identify::{FitOptions, Identification, IdentifyError, Residuals, Stage, uncorrected};

const TITLES: [&str; 2] = ["base, tool, targets alone", "declared model"];

impl IdentificationSummary {
    /// The same, with held-out poses of `data` compared with a limit of the 3-D position error (m); the verdict is of what will be done.
    ///
    /// # Errors
    /// When the robot as it is does not fit the data.
    pub fn with_specification(
        mut self,
        (limit, correction): (f64, Correction),
        found: &Identification,
        data: &Dataset,
    ) -> Result<Self, IdentifyError> {
        let (rows, errors) = match (&found.test_set, &found.declared.held_out) {
            (Some(test), _) => (test.rows.clone(), &test.declared),
            (None, Some(folds)) => ((0..data.len()).collect(), &folds.residuals),
            // Residuals on the rows of the fit do not estimate the error on other rows.
            (None, None) => return Ok(self),
        };
        let worst =
            |errors: &Residuals| crate::poses::largest_error_and_uncertainty_by_pose(data, &rows, errors);
        let effects = found.fit.fitted.model().effects();
        let other = uncorrected(&found.placement, effects, (data, &rows), &FitOptions::default())?;
        let constants = other.constants.as_ref().unwrap_or(errors);
        let cases = [&other.as_is, constants, errors].map(worst);
        self.specification = Some(SpecificationLines::new(limit, correction, &cases, other.described));
        Ok(self)
    }
}

/// Builds the page; `data` and `labels` are as they were read.
///
/// # Errors
/// When the observability of the fit cannot be worked out.
pub fn identification_report(
    summary: &IdentificationSummary,
    found: &Identification,
    data: &Dataset,
    labels: &[i64],
    run: &RunRecord,
) -> Result<Report, IdentifyError> {
    let mut page = Page::new(&format!("{}: identification", summary.robot));
    let poses = format!("{} ({})", summary.visits, count(summary.rows, "row"));
    page.head(run, &[("pose measurements", poses)]);
    page.section("Verdict");
    summary.data_check.sentences().iter().for_each(|sentence| page.text(sentence));
    page.document(&summary.judgement());
    figures(&mut page, summary);
    page.end_of_sheet();
    let rows = rows(found, data, labels);
    page.section("Position errors");
    page.note(match found.declared.held_out {
        Some(_) => "Each error is the prediction error of a model that was fitted without this row.",
        None => "Errors on the rows of the fit: no rows were held out.",
    });
    for part in [summary.frames(), summary.observations(), summary.noise()] {
        page.document(&part);
    }
    page.space(&rows, TITLES, summary.specification.as_ref().map(|s| s.judged.limit_mm));
    page.robot(&found.placement.chain, data, &rows, TITLES);
    page.joint_space(&rows, TITLES);
    page.section("Residuals");
    page.by_axis(&rows, TITLES);
    page.title("Residuals against inputs");
    page.against_inputs(&rows, TITLES);
    page.title("Comparison with the normal distribution");
    page.quantiles(&rows, summary.noise.position_sd_mm.hypot(summary.noise.visit_sd_mm));
    page.title("Pose measurements with the largest errors");
    page.largest_errors(&rows, 8);
    page.section("Identifiability");
    nonlinear_parameters(&mut page, &summary.nonlinear_parameters);
    page.identifiability(&found.fit, data)?;
    if let Some(parameters) = &summary.parameters {
        page.section("Parameters of the robot");
        page.document(&parameters.document());
    }
    if let Some(budget) = &summary.budget {
        page.section("Uncertainty budget");
        page.document(&budget.document());
    }
    page.section("Settings, files");
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let settings = [
        row("solver", summary.solver.clone()),
        row("held out by", summary.held_out_by.clone().unwrap_or_else(|| "nothing".into())),
        row(
            "scale factor of the prior standard deviations",
            summary.prior.map_or_else(|| "none".into(), |p| significant(p, 3)),
        ),
        row(
            "iterations",
            format!("{}{}", summary.rounds, if summary.converged { "" } else { ", NOT CONVERGED" }),
        ),
        row(
            "rows, pose measurements, configurations",
            format!("{}, {}, {}", summary.rows, summary.visits, summary.configurations),
        ),
    ];
    page.table("Settings", &["setting", "value"], &settings, true);
    page.reproduction(run);
    Ok(page.finish())
}

/// Nonlinear parameters that were estimated within a range, if any: as in the terminal.
fn nonlinear_parameters(page: &mut Page, list: &[NonlinearParameterSummary]) {
    if list.is_empty() {
        return;
    }
    let truncated = list.iter().any(|parameter| !parameter.truncation().is_empty());
    let mut head = vec!["parameter", "value", "95 % interval", "unit", "effect"];
    head.extend(truncated.then_some("limits of the interval"));
    let row = |parameter: &NonlinearParameterSummary| {
        let [value, interval] = parameter.value_and_interval();
        let mut row = vec![
            parameter.name.clone(),
            value,
            interval,
            unit_text(&parameter.unit),
            parameter.effect_name(),
        ];
        row.extend(truncated.then(|| match parameter.truncation() {
            "" => "from the data".to_owned(),
            limits => limits.to_owned(),
        }));
        row
    };
    page.table(
        "Nonlinear parameters with 95 % confidence intervals",
        &head,
        &list.iter().map(row).collect::<Vec<_>>(),
        true,
    );
}

/// The errors of the stages, drawn and in a table.
fn figures(page: &mut Page, summary: &IdentificationSummary) {
    let judged = |stage: &crate::StageSummary| stage.test_set.or(stage.held_out).unwrap_or(stage.train);
    let seen = match summary.stages.last() {
        Some(last) if last.test_set.is_some() => "on the held-out test set",
        Some(last) if last.held_out.is_some() && summary.landmarks.is_some() => "on left-out landmarks",
        Some(last) if last.held_out.is_some() => "on held-out configurations",
        _ => "on the rows of the fit (no rows were held out)",
    };
    let mm = |v: f64| significant(v, 3);
    let list: Vec<Bar> = summary
        .stages
        .iter()
        .enumerate()
        .map(|(k, stage)| Bar {
            name: stage.name.clone(),
            range: [0.0, judged(stage).rms_mm],
            class: if k + 1 == summary.stages.len() { "bar-after" } else { "bar-before" },
            label: format!("{} mm", mm(judged(stage).rms_mm)),
        })
        .collect();
    let svg = bars("RMS of the 3-D position error by model", &list, None);
    page.figure("models", &svg, &format!("RMS of the 3-D position error, {seen}."));
    let names = ["as found (nominal)", "best base, tool and targets", "calibrated"];
    let first = names.len().saturating_sub(summary.stages.len());
    let stages: Vec<SheetStage> = summary
        .stages
        .iter()
        .zip(&names[first..])
        .map(|(stage, name)| SheetStage {
            name: (*name).into(),
            fitted: Some(stage.train),
            verified: stage.test_set.or(stage.held_out),
        })
        .collect();
    page.stages(&stages, seen);
}

/// Rows in the order of the data; each with the error of a model that was fitted without it, where there is one.
fn rows(found: &Identification, data: &Dataset, labels: &[i64]) -> Rows {
    let seen = |stage: &Stage| -> Residuals {
        stage.held_out.as_ref().map_or_else(|| stage.train.clone(), |folds| folds.residuals.clone())
    };
    let (before, after) = (seen(&found.frames_only), seen(&found.declared));
    let none = Residuals::default();
    let (test, test_before, test_after) = match &found.test_set {
        Some(test) => (test.rows.as_slice(), &test.frames_only, &test.declared),
        None => (&[][..], &none, &none),
    };
    let train = complement(data, test);
    let mut order: Vec<(usize, bool, usize)> =
        train.iter().enumerate().map(|(k, &row)| (row, false, k)).collect();
    order.extend(test.iter().enumerate().map(|(k, &row)| (row, true, k)));
    order.sort_unstable();
    let chosen: Vec<usize> = order.iter().map(|o| o.0).collect();
    // In cross-validation every row has a fit without it.
    let folds = found.declared.held_out.is_some();
    let held: Vec<bool> = order.iter().map(|o| o.1 || folds).collect();
    Rows::new(
        &found.placement.chain,
        data,
        labels,
        &chosen,
        &held,
        &merged(&order, &before, test_before),
        &merged(&order, &after, test_after),
    )
}
