//! The page of a comparison of solver strategies.

use super::{Page, Report};
use crate::figure::{Bar, bars, escape};
use crate::{ComparisonSummary, RunRecord, StrategyOutcome, significant};

/// Forms the page.
pub fn comparison_report(summary: &ComparisonSummary, run: &RunRecord) -> Report {
    let mut page = Page::new(&format!("{}: solver strategies", summary.robot));
    page.section("Verdict");
    let mut fitted = Vec::new();
    let mut rows = Vec::new();
    for strategy in &summary.strategies {
        match &strategy.outcome {
            StrategyOutcome::Fitted {
                train,
                held_out,
                rank,
                nonzero,
                rounds,
                converged,
                seconds,
                p_value,
            } => {
                fitted.push((strategy.solver.clone(), held_out.rms_mm, *p_value));
                rows.push(vec![
                    strategy.solver.clone(),
                    significant(train.rms_mm, 4),
                    significant(held_out.rms_mm, 4),
                    p_value.map_or_else(|| "–".into(), |p| significant(p, 2)),
                    rank.to_string(),
                    nonzero.to_string(),
                    format!("{rounds}{}", if *converged { "" } else { " (still moving)" }),
                    significant(seconds * 1e3, 3),
                ]);
            }
            StrategyOutcome::Failed { error } => {
                rows.push(vec![strategy.solver.clone(), format!("no answer: {error}")]);
            }
        }
    }
    let best = fitted.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    page.raw(&format!("<p class=\"verdict\">{}</p>", escape(&verdict(best, fitted.first()))));
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
        "Strategies: RMS in mm; p: paired difference of squared errors to the first",
        &["solver", "train", "held out", "p", "rank", "not zero", "rounds", "ms"],
        &rows,
        true,
    );
    page.section("Settings, files");
    page.text("Wall times differ from run to run; everything else is repeated to the last digit.");
    page.repeat(run);
    page.finish()
}

fn verdict(best: Option<&(String, f64, Option<f64>)>, first: Option<&(String, f64, Option<f64>)>) -> String {
    /// Below it, a difference is taken for one.
    const LEVEL: f64 = 0.05;
    match (best, first) {
        (Some(best), Some(first)) if best.0 == first.0 => {
            format!("{} is the best on held-out configurations: {} mm.", best.0, significant(best.1, 3))
        }
        (Some(best), Some(first)) => format!(
            "{} has the smallest held-out error, {} mm, against {} mm of {}: {}.",
            best.0,
            significant(best.1, 3),
            significant(first.1, 3),
            first.0,
            match best.2 {
                Some(p) if p < LEVEL =>
                    format!("a difference that chance makes with p = {} only", significant(p, 2)),
                Some(p) => format!("chance would do as much (p = {})", significant(p, 2)),
                None => "not tested".into(),
            }
        ),
        _ => "No strategy gave an answer.".into(),
    }
}
