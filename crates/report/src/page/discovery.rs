//! The page of a discovery: verdict, position errors, error budget, each finding, residuals, identifiability.

use super::rows::{Rows, complement, merged};
use super::sheet::SheetStage;
use super::{Page, Report};
use crate::discovery::effects::ONLY_JOINTLY;
use crate::discovery::text::WITHOUT_EXCLUDED;
use crate::discovery::{DiscoverySummary, FindingSummary};
use crate::figure::{Bar, escape, range, trace_figure, unit_text, waterfall};
use crate::wording::p_text;
use crate::{RunRecord, count, parameter_text, significant};
use truepose_discover::{Diagnosis, Family, HeldOut};
use truepose_errormodel::Dataset;
use truepose_identify::IdentifyError;

const TITLES: [&str; 2] = ["declared model", "enlarged model"];

/// Builds the page; `data` and `labels` are as they were read.
///
/// # Errors
/// When the observability of the fit cannot be worked out.
pub fn discovery_report(
    summary: &DiscoverySummary,
    found: &Diagnosis,
    data: &Dataset,
    labels: &[i64],
    run: &RunRecord,
) -> Result<Report, IdentifyError> {
    let mut page = Page::new(&format!("{}: what the declared model lacks", summary.robot));
    let poses = format!("{} ({})", summary.visits, count(summary.rows, "row"));
    page.head(run, &[("pose measurements", poses)]);
    page.section("Verdict");
    summary.data_check.sentences().iter().for_each(|sentence| page.text(sentence));
    if let Some(observers) = &summary.observers {
        page.text(observers.sentence().trim_end());
    }
    page.document(&summary.judgement());
    figures(&mut page, summary);
    page.end_of_sheet();
    page.document(&summary.evidence());
    let rows = rows(found, data, labels);
    page.section("Position errors");
    page.document(&summary.observations());
    page.space(&rows, TITLES, summary.specification.as_ref().map(|s| s.judged.limit_mm));
    page.robot(found.fit.fitted.chain(), data, &rows, TITLES);
    page.joint_space(&rows, TITLES);
    if !summary.effects.is_empty() {
        page.section("Error budget");
        error_budget(&mut page, summary);
        page.section("Findings");
    }
    for (number, effect) in (1..).zip(&summary.effects) {
        finding(&mut page, number, effect, found, summary.after.holdout_used().rms_mm);
    }
    page.section("Residuals");
    page.by_axis(&rows, TITLES);
    page.title("Residuals against inputs");
    page.against_inputs(&rows, TITLES);
    page.title("Comparison with the normal distribution");
    page.quantiles(&rows, 1e3 * component_sd(found));
    page.title("Pose measurements with the largest errors");
    page.largest_errors(&rows, 8);
    page.section("Identifiability");
    page.identifiability(&found.fit, &found.data)?;
    untestable(&mut page, summary);
    if let Some(parameters) = &summary.parameters {
        page.section("Parameters of the robot");
        page.document(&parameters.document());
    }
    page.section("Candidates not added, settings, files");
    not_added(&mut page, summary);
    settings(&mut page, summary);
    page.reproduction(run);
    Ok(page.finish())
}

/// Standard deviation of one component of a position as the fit takes it, what the instrument states included, m.
fn component_sd(found: &Diagnosis) -> f64 {
    let of = |sd: f64| found.fit.noise.floor(sd).powi(2);
    let (sum, count) =
        found.data.position_sd.iter().flatten().fold((0.0, 0.0), |(s, n), sd| (s + of(*sd), n + 1.0));
    (sum / f64::max(count, 1.0) / 3.0).sqrt()
}

/// Rows in the order of the data, held-out rows included.
fn rows(found: &Diagnosis, data: &Dataset, labels: &[i64]) -> Rows {
    let train = complement(data, &found.holdout_rows);
    let mut order: Vec<(usize, bool, usize)> =
        train.iter().enumerate().map(|(k, &row)| (row, false, k)).collect();
    order.extend(found.holdout_rows.iter().enumerate().map(|(k, &row)| (row, true, k)));
    order.sort_unstable();
    let chosen: Vec<usize> = order.iter().map(|o| o.0).collect();
    let held: Vec<bool> = order.iter().map(|o| o.1).collect();
    let before = merged(&order, &found.before.train, &found.before.holdout);
    let after = merged(&order, &found.after.train, &found.after.holdout);
    Rows::new(found.fit.fitted.chain(), data, labels, &chosen, &held, &before, &after)
}

/// The figures of the verdict, and the chain of stages.
fn figures(page: &mut Page, summary: &DiscoverySummary) {
    let (before, after) = (summary.before.holdout_used(), summary.after.holdout_used());
    let mm = |v: f64| significant(v, 3);
    page.raw("<div class=\"numbers4\">");
    let rows = summary.held_out_rows();
    let tail = [
        (mm(after.p95_mm), format!("mm: 95th percentile, {rows}")),
        (mm(after.max_mm), format!("mm: largest, {rows}")),
    ];
    let limit = match summary.noise_floor_mm {
        Some(limit) => (mm(limit), "mm: repeatability limit".to_owned()),
        None => ("unknown".into(), "repeatability limit: too few repeats".to_owned()),
    };
    let head = if summary.effects.is_empty() {
        [(mm(after.rms_mm), format!("mm RMS, {rows}")), limit]
    } else {
        [
            (mm(before.rms_mm), format!("mm RMS before, {rows}")),
            (mm(after.rms_mm), format!("mm RMS after, {rows}")),
        ]
    };
    for (value, words) in head.into_iter().chain(tail) {
        page.raw(&format!("<div><b>{}</b><span>{words}</span></div>", escape(&value)));
    }
    page.raw("</div>");
    page.note(match summary.held_out {
        HeldOut::NestedFolds => {
            "The poses are too few for a test set of their own. Each pose is predicted by a run of the whole search without its fold; one \
             decision uses these errors: findings are withdrawn if they predict unseen poses worse than the declared model."
        }
        _ => {
            "The held-out test set is drawn before anything is fitted. No fit uses it, and one decision does: findings are withdrawn if \
             the enlarged model predicts the test set worse than the declared model."
        }
    });
    let stage = |name: &str, fitted, verified| SheetStage { name: name.into(), fitted, verified };
    let mut stages = Vec::new();
    if let Some(found) = &summary.as_found {
        stages.extend(found.as_described.map(|s| stage("as found (nominal)", Some(s), None)));
        stages.push(stage("best base, tool and targets", Some(found.installation), None));
    }
    stages.push(stage("calibrated (declared model)", Some(summary.before.train), Some(before)));
    stages.push(stage("with the effects found", Some(summary.after.train), Some(after)));
    page.stages(&stages, rows);
}

fn error_budget(page: &mut Page, summary: &DiscoverySummary) {
    let mm = |v: f64| format!("{} mm", significant(v, 3));
    let bar = |name: &str, range, class, label| Bar { name: name.into(), range, class, label };
    let mut list = vec![bar(
        "declared model",
        [0.0, summary.before.holdout.rms_mm],
        "bar-before",
        mm(summary.before.holdout.rms_mm),
    )];
    for effect in summary.effects.iter().filter(|e| e.family != Family::Outlier.word()) {
        let change = effect.holdout_rms_mm;
        let label = format!("{} → {}", significant(change.before, 3), mm(change.after));
        list.push(bar(&effect.name(), [change.before, change.after], "bar-gain", label));
    }
    list.push(bar(
        "enlarged model",
        [0.0, summary.after.holdout.rms_mm],
        "bar-after",
        mm(summary.after.holdout.rms_mm),
    ));
    if let Some(without) = summary.after.holdout_without_outliers {
        list.push(bar(WITHOUT_EXCLUDED, [0.0, without.rms_mm], "bar-after", mm(without.rms_mm)));
    }
    let limit = summary.noise_floor_mm.map(|limit| (limit, format!("repeatability limit {}", mm(limit))));
    let title = format!("Error budget {}", summary.held_out_rows());
    let svg = waterfall(&title, &list, limit);
    page.figure(
        "waterfall",
        &svg,
        &format!(
            "RMS of the 3-D position error {}, in the order in which effects were added.{} Dashed: repeatability limit, where it is known.",
            summary.held_out_rows(),
            match summary.held_out {
                HeldOut::NestedFolds =>
                    " Steps of single findings are of refits with the findings as they are; the last bar is that of the whole search.",
                _ => "",
            }
        ),
    );
}

fn finding(page: &mut Page, number: usize, effect: &FindingSummary, found: &Diagnosis, after: f64) {
    page.title(&format!("{number}. {}", effect.name()));
    page.text(&effect.meaning);
    if effect.family == Family::Outlier.word() {
        page.text(&format!("No fit uses {}.", effect.places(60)));
        return;
    }
    // Over an input that never changes there is nothing to see.
    let varies = |trace: &&truepose_discover::Trace| {
        let drivers: Vec<f64> = trace.points.iter().map(|p| p.driver).collect();
        let [low, high] = range(&drivers);
        high - low > 1e-9 * low.abs().max(high.abs())
    };
    if let Some(trace) = found.findings.get(number - 1).and_then(|f| f.trace.as_ref()).filter(varies) {
        // Folding over one period needs harmonics of that period alone.
        let commensurate =
            |p: &f64| effect.periods.iter().all(|q| (p / q - (p / q).round()).abs() < 0.01 && p / q > 0.5);
        let drawn = trace_figure(trace, &effect.name(), effect.period.filter(commensurate));
        let legend = if trace.classes.is_empty() {
            "Marks with bars: bin means with 95 % confidence intervals.".to_owned()
        } else {
            let present = |class: usize| trace.points.iter().any(|p| p.class == class);
            let colours = ["orange", "violet", "blue"].iter().zip(&trace.classes).enumerate();
            let named: Vec<String> = colours
                .filter(|(k, _)| present(*k))
                .map(|(_, (colour, name))| format!("{colour}: {name}"))
                .collect();
            format!(
                "Colours: {}. Marks with bars: bin means with 95 % confidence intervals.",
                named.join("; ")
            )
        };
        let words = format!(
            "Residual with this effect removed from the model (left) and included (right), in the coordinate in which the effect acts. \
             Black: the fitted effect with its 95 % band. {legend} {}",
            drawn.notes.join(" ")
        );
        page.figure_of_two(&format!("effect_{number}"), &drawn.panels, &drawn.whole, words.trim());
    }
    let rows: Vec<Vec<String>> = effect
        .parameters
        .iter()
        .map(|p| {
            let (value, unit) = parameter_text(p);
            vec![p.name.clone(), value, unit_text(&unit)]
        })
        .collect();
    let folded = rows.len() > 6;
    if folded {
        page.raw(&format!("<details><summary>{}</summary>", count(rows.len(), "parameter")));
    }
    page.table("Parameters with 95 % confidence intervals", &["parameter", "value", "unit"], &rows, true);
    if folded {
        page.raw("</details>");
    }
    if effect.only_jointly {
        page.note(ONLY_JOINTLY);
    }
    page.text(&format!(
        "Existence: {} (family-wise, rotation test){}; RMS on held-out rows {} → {} mm. Name (probability): {}.{}",
        p_text(effect.p_value),
        effect.selection().iter().map(|words| format!("; {words}")).collect::<String>(),
        significant(effect.holdout_rms_mm.before, 3),
        significant(effect.holdout_rms_mm.after, 3),
        effect.names(),
        effect.assumption().map_or_else(String::new, |words| format!(" {words}"))
    ));
    alternatives(page, effect, after);
}

fn alternatives(page: &mut Page, effect: &FindingSummary, after: f64) {
    if effect.alternatives.is_empty() {
        page.note("No competing hypothesis is close.");
        return;
    }
    let mut rows =
        vec![vec![format!("{} (found)", effect.name()), significant(after, 3), "0".into(), String::new()]];
    rows.extend(effect.alternatives.iter().map(|a| {
        let relation = if a.equivalent { "no" } else { "yes" };
        vec![a.name(), significant(a.holdout_rms_mm, 3), significant(a.behind, 3), relation.into()]
    }));
    page.table(
        "Competing hypotheses: RMS on held-out rows with each in place of the finding (all other findings kept), and penalised −2 ln L \
         relative to the finding",
        &["hypothesis", "RMS, mm", "Δ(−2 ln L)", "distinguishable"],
        &rows,
        true,
    );
}

fn untestable(page: &mut Page, summary: &DiscoverySummary) {
    if summary.not_testable.is_empty() {
        return;
    }
    page.title("Hypotheses that this data cannot test");
    page.text("Beside the model, this data has too little information on the effect of these hypotheses: it neither confirms nor excludes them.");
    let rows: Vec<Vec<String>> = summary
        .not_testable
        .iter()
        .map(|u| {
            vec![
                u.name(),
                format!("{} %", significant(100.0 * u.share, 2)),
                u.detectable_rms_mm.map_or_else(|| "no effect on this data".into(), |d| significant(d, 2)),
                u.advice.clone(),
            ]
        })
        .collect();
    page.raw(&format!(
        "<details><summary>{}</summary>",
        count(rows.len(), "hypothesis").replace("hypothesiss", "hypotheses")
    ));
    page.table(
        "Fraction of the effect that the model does not absorb, the 3-D RMS that would be detected with 80 % probability, and what to measure",
        &["hypothesis", "not absorbed", "detectable, mm", "to make it testable"],
        &rows,
        true,
    );
    page.raw("</details>");
}

fn not_added(page: &mut Page, summary: &DiscoverySummary) {
    if summary.refused.is_empty() {
        page.text("No candidate was tested and then rejected.");
        return;
    }
    let rows: Vec<Vec<String>> = summary
        .refused
        .iter()
        .map(|r| {
            vec![
                r.name(),
                significant(r.p_value, 2),
                format!("{} %", significant(100.0 * r.stability, 3)),
                format!(
                    "{} → {}",
                    significant(r.cross_validated_rms_mm.before, 3),
                    significant(r.cross_validated_rms_mm.after, 3)
                ),
                r.reason.clone(),
            ]
        })
        .collect();
    page.table(
        "Candidates that were tested and not added",
        &["candidate", "p", "selected in half-samples", "cross-validated RMS, mm", "reason"],
        &rows,
        true,
    );
}

fn settings(page: &mut Page, summary: &DiscoverySummary) {
    let s = &summary.settings;
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let rows = [
        row("seed of every random choice", s.seed.to_string()),
        row(
            "held-out fraction of the configurations",
            s.holdout.map_or_else(|| "automatic".into(), |h| h.to_string()),
        ),
        row("rotations per p-value", s.rotations.to_string()),
        row("family-wise significance level", s.alpha.to_string()),
        row("rows, pose measurements", format!("{}, {}", summary.rows, summary.visits)),
        row("rows with a held-out error", summary.after.holdout.count.to_string()),
    ];
    page.table("Settings", &["setting", "value"], &rows, true);
}
