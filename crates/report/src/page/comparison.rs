//! The page of a comparison of solver strategies.

use super::{Page, Report};
use crate::figure::{Bar, bars, escape};
use crate::{ComparisonSummary, RunRecord, StrategyOutcome, significant};

/// Builds the page.
pub fn comparison_report(summary: &ComparisonSummary, run: &RunRecord) -> Report {
    let mut page = Page::new(&format!("{}: solver strategies", summary.robot));
    page.section("Verdict");
    let mut fitted = Vec::new();
    let mut rows = Vec::new();
    for strategy in &summary.strategies {
        match &strategy.outcome {
            StrategyOutcome::Fitted { train, held_out, rank, nonzero, rounds, seconds, p_value, .. } => {
                fitted.push((strategy.marked(), held_out.rms_mm, *p_value));
                rows.push(vec![
                    strategy.marked(),
                    significant(train.rms_mm, 4),
                    significant(held_out.rms_mm, 4),
                    p_value.map_or_else(|| "–".into(), |p| significant(p, 2)),
                    rank.to_string(),
                    nonzero.to_string(),
                    rounds.to_string(),
                    significant(seconds * 1e3, 3),
                ]);
            }
            StrategyOutcome::Failed { error } => {
                rows.push(vec![strategy.solver.clone(), format!("no fit: {error}")]);
            }
        }
    }
    let best = fitted.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    page.raw(&format!("<p class=\"verdict\">{}</p>", escape(&verdict(best, fitted.first()))));
    let warnings = summary.warnings();
    if !warnings.is_empty() {
        page.list(&warnings);
    }
    let list: Vec<Bar> = fitted
        .iter()
        .map(|(name, rms, p)| Bar {
            name: name.clone(),
            range: [0.0, *rms],
            class: if best.is_some_and(|b| b.0 == *name) { "bar-after" } else { "bar-before" },
            label: match p {
                Some(p) => format!("{} mm (p {})", significant(*rms, 3), significant(*p, 2)),
                None => format!("{} mm", significant(*rms, 3)),
            },
        })
        .collect();
    if !list.is_empty() {
        let words =
            format!("RMS of the 3-D position error on held-out configurations ({}).", summary.held_out_by);
        page.figure("strategies", &bars("Held-out error of each strategy", &list, None), &words);
    }
    page.table(
        "Strategies: RMS in mm; p: paired test of the squared errors against the first",
        &["solver", "training", "held out", "p", "rank", "not zero", "iterations", "ms"],
        &rows,
        true,
    );
    page.section("Settings, files");
    page.text("Wall times differ from run to run; all other figures are reproduced to the last digit.");
    page.reproduction(run);
    page.finish()
}

/// The best strategy, and whether its advantage is significant.
fn verdict(best: Option<&(String, f64, Option<f64>)>, first: Option<&(String, f64, Option<f64>)>) -> String {
    /// Significance level of the paired test.
    const LEVEL: f64 = 0.05;
    let (Some(best), Some(first)) = (best, first) else { return "No strategy gave a fit.".into() };
    // As many digits as distinguish the two.
    let mm = |digits| (significant(best.1, digits), significant(first.1, digits));
    let (smallest, reference) = (3..8).map(mm).find(|(a, b)| a != b).unwrap_or_else(|| mm(3));
    if best.0 == first.0 {
        return format!(
            "No strategy predicts held-out configurations better than {}: {smallest} mm.",
            best.0
        );
    }
    match best.2 {
        Some(p) if p < LEVEL => format!(
            "{} predicts held-out configurations better than {}: {smallest} mm against {reference} mm (p = {}).",
            best.0,
            first.0,
            significant(p, 2)
        ),
        p => format!(
            "No strategy predicts held-out configurations significantly better than {} ({reference} mm). The smallest error is that \
             of {}: {smallest} mm{}.",
            first.0,
            best.0,
            p.map_or_else(String::new, |p| format!(" (p = {})", significant(p, 2)))
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_that_is_not_significant_is_reported_as_such() {
        let qr = ("qr".to_owned(), 0.134_31, None);
        let smaller = ("ridge".to_owned(), 0.134_29, Some(0.68));
        let better = ("huber(qr)".to_owned(), 0.1, Some(0.001));
        assert_eq!(
            verdict(Some(&smaller), Some(&qr)),
            "No strategy predicts held-out configurations significantly better than qr (0.13431 mm). The smallest error is that \
             of ridge: 0.13429 mm (p = 0.68)."
        );
        assert_eq!(
            verdict(Some(&better), Some(&qr)),
            "huber(qr) predicts held-out configurations better than qr: 0.100 mm against 0.134 mm (p = 0.0010)."
        );
        assert_eq!(
            verdict(Some(&qr), Some(&qr)),
            "No strategy predicts held-out configurations better than qr: 0.134 mm."
        );
    }
}
