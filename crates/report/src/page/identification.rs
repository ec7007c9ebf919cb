//! The page of an identification.

use super::discovery::specification;
use super::rows::{Rows, complement, merged};
use super::{Page, Report};
use crate::figure::{Bar, bars, escape, unit_words};
use crate::{IdentificationSummary, RunRecord, ShapeSummary, SpecificationSummary, significant};
use truepose_errormodel::Dataset;
use truepose_identify::{Identification, IdentifyError, Residuals, Stage};

const TITLES: [&str; 2] = ["base, tool, targets alone", "declared model"];

impl IdentificationSummary {
    /// With poses of `data` that the judged fit did not see, against a limit of the 3-D position error (m).
    pub fn against(mut self, limit: f64, found: &Identification, data: &Dataset) -> Self {
        let (rows, errors) = match (&found.test_set, &found.declared.held_out) {
            (Some(test), _) => (test.rows.clone(), &test.declared),
            (None, Some(folds)) => ((0..data.len()).collect(), &folds.residuals),
            // Residuals of a fit on the same rows prove nothing about others.
            (None, None) => return self,
        };
        self.specification =
            Some(SpecificationSummary::new(limit, &crate::worst_of_poses(data, &rows, errors)));
        self
    }
}

/// Forms the page; `data` and `labels` are as they were read.
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
    page.section("Verdict");
    verdict(&mut page, summary);
    let rows = rows(found, data, labels);
    page.section("Errors in space");
    page.note(match found.declared.held_out {
        Some(_) => "Every error is of a model that did not see its row.",
        None => "Errors on the rows of the fit: nothing was held out.",
    });
    page.space(&rows, TITLES, summary.specification.map(|s| s.limit_mm));
    page.joint_space(&rows, TITLES);
    page.section("Residuals");
    page.by_axis(&rows, TITLES);
    page.title("Against what the robot did");
    page.against_inputs(&rows, TITLES);
    page.title("Against the normal law");
    page.quantiles(&rows, summary.noise.position_sd_mm.hypot(summary.noise.visit_sd_mm));
    page.title("Worst visits");
    page.worst(&rows, 8);
    page.section("What the data determines");
    shapes(&mut page, &summary.shapes);
    page.identifiability(&found.fit, data)?;
    page.section("Settings, files");
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let settings = [
        row("solver", summary.solver.clone()),
        row("held out by", summary.held_out_by.clone().unwrap_or_else(|| "nothing".into())),
        row(
            "width of the prior, expected sizes",
            summary.prior.map_or_else(|| "none".into(), |p| significant(p, 3)),
        ),
        row(
            "rounds",
            format!("{}{}", summary.rounds, if summary.converged { "" } else { ", NOT CONVERGED" }),
        ),
        row(
            "rows, visits, configurations",
            format!("{}, {}, {}", summary.rows, summary.visits, summary.configurations),
        ),
    ];
    page.table("Settings", &["setting", "value"], &settings, true);
    page.repeat(run);
    Ok(page.finish())
}

/// What was looked for within a range, where anything was: as in the terminal.
fn shapes(page: &mut Page, shapes: &[ShapeSummary]) {
    if shapes.is_empty() {
        return;
    }
    let cut = shapes.iter().any(|shape| !shape.cut_words().is_empty());
    let mut head = vec!["parameter", "value", "95 % interval", "unit", "belongs to"];
    head.extend(cut.then_some("the interval"));
    let row = |shape: &ShapeSummary| {
        let [value, interval] = shape.numbers();
        let mut row =
            vec![shape.name.clone(), value, interval, unit_words(&shape.unit), shape.effect_words()];
        row.extend(cut.then(|| match shape.cut_words() {
            "" => "the data ends it".to_owned(),
            words => words.to_owned(),
        }));
        row
    };
    page.table(
        "Found within their ranges, with 95 % intervals",
        &head,
        &shapes.iter().map(row).collect::<Vec<_>>(),
        true,
    );
}

fn verdict(page: &mut Page, summary: &IdentificationSummary) {
    let judged = |stage: &crate::StageSummary| stage.locked.or(stage.held_out).unwrap_or(stage.train);
    let seen = match summary.stages.last() {
        Some(last) if last.locked.is_some() => "on configurations that were locked away first",
        Some(last) if last.held_out.is_some() => "on configurations that the fit did not see",
        _ => "on the rows of the fit itself (nothing was held out)",
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
    if let [.., before, after] = &summary.stages[..] {
        let (before, after) = (judged(before), judged(after));
        let word = if summary.converged { "" } else { "NOT CONVERGED, no figure is final. " };
        page.raw(&format!(
            "<p class=\"verdict\">{}</p>",
            escape(&format!(
                "{word}The declared model brings the position error from {} to {} mm (3-D RMS), {seen}; 95 % of rows are below {} mm, the largest is {} mm.",
                mm(before.rms_mm),
                mm(after.rms_mm),
                mm(after.p95_mm),
                mm(after.max_mm)
            ))
        ));
    }
    specification(page, summary.specification.as_ref());
    page.text(&format!("What limits it: {}.", summary.limit));
    let svg = bars("RMS of the 3-D position error by model", &list, None);
    page.figure("models", &svg, &format!("RMS of the 3-D position error, {seen}."));
    let all: Vec<String> = summary.warnings.clone();
    if !all.is_empty() {
        page.list(&all);
    }
}

/// Rows in the order of the data; each with the error of a model that did not see it, where there is one.
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
    let held: Vec<bool> = order.iter().map(|o| o.1).collect();
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
