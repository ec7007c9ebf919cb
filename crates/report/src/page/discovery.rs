//! The page of a discovery, for a metrologist who has five minutes.

use super::rows::{Rows, complement, merged};
use super::{Page, Report};
use crate::discovery::{DiscoverySummary, FindingSummary};
use crate::figure::{Bar, escape, trace_figure, unit_words, waterfall};
use crate::{RunRecord, SpecificationSummary, count, parameter_words, significant};
use truepose_discover::{Diagnosis, Family, Termination};
use truepose_errormodel::Dataset;
use truepose_identify::IdentifyError;

const TITLES: [&str; 2] = ["declared model", "with what was found"];

/// Forms the page; `data` and `labels` are as they were read.
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
    page.section("Verdict");
    verdict(&mut page, summary);
    let rows = rows(found, data, labels);
    page.section("Position errors");
    page.space(&rows, TITLES, summary.specification.map(|s| s.limit_mm));
    page.joint_space(&rows, TITLES);
    if !summary.effects.is_empty() {
        page.section("Error budget");
        steps(&mut page, summary);
        page.section("Each effect");
    }
    for (number, effect) in (1..).zip(&summary.effects) {
        finding(&mut page, number, effect, found, summary.after.judged().rms_mm);
    }
    page.section("Residuals");
    page.by_axis(&rows, TITLES);
    page.title("Against what the robot did");
    page.against_inputs(&rows, TITLES);
    page.title("Against the normal distribution");
    page.quantiles(&rows, found.fit.noise.floor(f64::NAN) / 3f64.sqrt());
    page.title("Worst visits");
    page.worst(&rows, 8);
    page.section("What the data determines");
    page.identifiability(&found.fit, &found.data)?;
    untestable(&mut page, summary);
    page.section("Refused, settings, files");
    refused(&mut page, summary);
    settings(&mut page, summary);
    page.repeat(run);
    Ok(page.finish())
}

/// Rows in the order of the data, those that took part in nothing among them.
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

fn verdict(page: &mut Page, summary: &DiscoverySummary) {
    let (before, after) = (summary.before.judged(), summary.after.judged());
    let mm = |v: f64| significant(v, 3);
    let named: Vec<String> = summary.effects.iter().map(FindingSummary::words).collect();
    let answer = match (named.len(), summary.stopped) {
        (0, Termination::NothingLeft) => "No effect beyond the declared model was found.".to_owned(),
        (0, Termination::Withdrawn) => {
            "The declared model stands: what was found did not hold on unseen data.".to_owned()
        }
        (0, _) => "Nothing was found that can be added to the declared model with confidence.".to_owned(),
        (1, _) => format!("The declared model lacks one effect: {}.", named.join(", ")),
        (count, _) => format!("The declared model lacks {count} effects: {}.", named.join(", ")),
    };
    let sentence = format!("{answer} Position error (3-D RMS): {}", summary.result());
    page.raw(&format!("<p class=\"verdict\">{}</p>", escape(&sentence)));
    page.raw("<div class=\"numbers4\">");
    let tail = [
        (mm(after.p95_mm), "mm: 95 % of held-out rows are below"),
        (mm(after.max_mm), "mm largest, held out"),
    ];
    let limit = match summary.noise_floor_mm {
        Some(limit) => (mm(limit), "mm repeatability limit"),
        None => ("unknown".into(), "repeatability limit: no repeated poses"),
    };
    let head = if named.is_empty() {
        [(mm(after.rms_mm), "mm RMS, held out"), limit]
    } else {
        [(mm(before.rms_mm), "mm RMS before, held out"), (mm(after.rms_mm), "mm RMS after, held out")]
    };
    for (value, words) in head.into_iter().chain(tail) {
        page.raw(&format!("<div><b>{}</b><span>{words}</span></div>", escape(&value)));
    }
    page.raw("</div>");
    page.note(
        "The held-out test set was drawn before anything was fitted. It took part in no fit, and in one choice: findings that predict it worse \
         than the declared model does are withdrawn.",
    );
    specification(page, summary.specification.as_ref());
    page.text(&summary.question());
    page.text(&summary.why());
    if let Some(few) = &summary.too_few_poses {
        page.text(&few.words());
    }
    if let Some(nested) = &summary.nested {
        page.text(&nested.words());
    }
}

/// Against the specification, with its mark.
pub(super) fn specification(page: &mut Page, of: Option<&SpecificationSummary>) {
    match of {
        None => page.note("No specification was given: --spec 0.5mm holds the held-out poses against one."),
        Some(spec) => {
            let word = spec.verdict.words();
            page.raw(&format!(
                "<p><span class=\"badge {}\">{word}</span> {}</p>",
                word.replace(' ', "_"),
                escape(&spec.words())
            ));
        }
    }
}

fn steps(page: &mut Page, summary: &DiscoverySummary) {
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
        list.push(bar(&effect.words(), [change.before, change.after], "bar-gain", label));
    }
    list.push(bar(
        "left",
        [0.0, summary.after.holdout.rms_mm],
        "bar-after",
        mm(summary.after.holdout.rms_mm),
    ));
    let floor = summary.noise_floor_mm.map(|limit| (limit, format!("repeatability limit {}", mm(limit))));
    let svg = waterfall("Error budget of the held-out test set", &list, floor);
    page.figure(
        "waterfall",
        &svg,
        "RMS of the 3-D position error on held-out rows, in the order in which effects were added. Dashed: repeatability limit, where one is known.",
    );
}

fn finding(page: &mut Page, number: usize, effect: &FindingSummary, found: &Diagnosis, after: f64) {
    page.title(&format!("{number}. {}", effect.words()));
    page.text(&effect.meaning);
    if effect.family == Family::Outlier.word() {
        let rows: Vec<String> = effect.rows.iter().take(60).map(ToString::to_string).collect();
        let more = effect.rows.len().saturating_sub(60);
        let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
        page.text(&format!("Rows {}{rest}; they are kept out of every fit.", rows.join(", ")));
        return;
    }
    if let Some(trace) = found.findings.get(number - 1).and_then(|f| f.trace.as_ref()) {
        // Laid on top of each other, waves that do not repeat together would be a cloud.
        let alone =
            |p: &f64| effect.periods.iter().all(|q| (p / q - (p / q).round()).abs() < 0.01 && p / q > 0.5);
        let drawn = trace_figure(trace, &effect.words(), effect.period.filter(alone));
        let legend = if trace.classes.is_empty() {
            "Marks with bars: means with their 95 % intervals.".to_owned()
        } else {
            let present = |class: usize| trace.points.iter().any(|p| p.class == class);
            let colours = ["orange", "violet", "blue"].iter().zip(&trace.classes).enumerate();
            let named: Vec<String> = colours
                .filter(|(k, _)| present(*k))
                .map(|(_, (colour, name))| format!("{colour}: {name}"))
                .collect();
            format!("Colours: {}. Marks with bars: means with their 95 % intervals.", named.join("; "))
        };
        let words = format!(
            "Residual traced to this effect (all others stay in the model). Black: what the model says, with its 95 % band. {legend} {}",
            drawn.notes.join(" ")
        );
        page.figure_of_two(&format!("effect_{number}"), &drawn.panels, &drawn.whole, words.trim());
    }
    let rows: Vec<Vec<String>> = effect
        .parameters
        .iter()
        .map(|p| {
            let (value, unit) = parameter_words(p);
            vec![p.name.clone(), value, unit_words(&unit)]
        })
        .collect();
    let folded = rows.len() > 6;
    if folded {
        page.raw(&format!("<details><summary>{}</summary>", count(rows.len(), "coefficient")));
    }
    page.table("Sizes with their 95 % intervals", &["coefficient", "value", "unit"], &rows, true);
    if folded {
        page.raw("</details>");
    }
    page.text(&format!(
        "p = {} (family-wise, by sign flips); selected in {} % of half-samples; cross-validated {} → {} mm, held out {} → {} mm.",
        significant(effect.p_value, 2),
        significant(100.0 * effect.stability, 3),
        significant(effect.cross_validated_rms_mm.before, 3),
        significant(effect.cross_validated_rms_mm.after, 3),
        significant(effect.holdout_rms_mm.before, 3),
        significant(effect.holdout_rms_mm.after, 3)
    ));
    rivals(page, effect, after);
}

fn rivals(page: &mut Page, effect: &FindingSummary, after: f64) {
    if effect.alternatives.is_empty() {
        page.note("No other explanation came near.");
        return;
    }
    let mut rows =
        vec![vec![format!("{} (found)", effect.words()), significant(after, 3), "0".into(), String::new()]];
    rows.extend(effect.alternatives.iter().map(|a| {
        let words = format!("{} {}", a.family, a.place.words());
        let told = if a.equivalent { "this data cannot tell it from the find" } else { "less likely" };
        vec![
            words.trim_end().to_owned(),
            significant(a.holdout_rms_mm, 3),
            significant(a.behind, 3),
            told.into(),
        ]
    }));
    page.table(
        "Rivals: held-out RMS with each in place of the find (all other finds in), and how much less likely it makes the data (−2 ln L)",
        &["explanation", "held out, mm", "behind", "told apart"],
        &rows,
        true,
    );
}

fn untestable(page: &mut Page, summary: &DiscoverySummary) {
    if summary.not_testable.is_empty() {
        return;
    }
    page.title("What this data cannot test");
    page.text("The declared model imitates these causes almost wholly, so that the data neither shows nor excludes them.");
    let rows: Vec<Vec<String>> = summary
        .not_testable
        .iter()
        .map(|u| {
            let words = format!("{} {}", u.family, u.place.words());
            vec![
                words.trim_end().to_owned(),
                format!("{} %", significant(100.0 * u.share, 2)),
                u.detectable_rms_mm.map_or_else(|| "does nothing here".into(), |d| significant(d, 2)),
            ]
        })
        .collect();
    page.raw(&format!("<details><summary>{}</summary>", count(rows.len(), "cause")));
    page.table(
        "Share that the model does not imitate, and the 3-D RMS that would be seen",
        &["cause", "left", "needed, mm"],
        &rows,
        true,
    );
    page.raw("</details>");
}

fn refused(page: &mut Page, summary: &DiscoverySummary) {
    if summary.refused.is_empty() {
        page.text("No candidate that won a contest was refused.");
        return;
    }
    let rows: Vec<Vec<String>> = summary
        .refused
        .iter()
        .map(|r| {
            let words = format!("{} {}", r.family, r.place.words());
            vec![
                words.trim_end().to_owned(),
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
        "Candidates that won a contest and were not believed",
        &["candidate", "p", "half-samples", "cross-validated, mm", "why not"],
        &rows,
        true,
    );
}

fn settings(page: &mut Page, summary: &DiscoverySummary) {
    let s = &summary.settings;
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let rows = [
        row("seed of every draw", s.seed.to_string()),
        row("share held out", s.holdout.to_string()),
        row("sign flips behind each p", s.flips.to_string()),
        row("family-wise level", s.alpha.to_string()),
        row("rows, visits", format!("{}, {}", summary.rows, summary.visits)),
        row("rows held out", summary.holdout_rows.len().to_string()),
    ];
    page.table("Settings", &["setting", "value"], &rows, true);
}
