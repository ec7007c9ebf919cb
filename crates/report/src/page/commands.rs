//! The page of a compensation: what became of every pose that was asked for.

use super::{Page, Report};
use crate::figure::{Bar, Plot, bars, escape, quantile, thin};
use crate::{RunRecord, count, significant};
use serde::{Deserialize, Serialize};

/// What a page shows of commands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CommandsView {
    /// The robot's name.
    pub robot: String,
    /// Words of the statuses with their counts.
    pub status: Vec<(String, usize)>,
    /// Commands beyond the range on which the model was fitted.
    pub extrapolating: usize,
    /// Row (from 1), status, distance between the desired pose and what is reached by the model (mm), and how far the
    /// nominal robot would end from the desired pose under this command (mm): the correction.
    pub commands: Vec<(usize, String, f64, f64)>,
}

/// Forms the page.
pub fn commands_report(view: &CommandsView, run: &RunRecord) -> Report {
    const DRAWN: usize = 3000;
    let mut page = Page::new(&format!("{}: compensated commands", view.robot));
    page.section("Verdict");
    let total: usize = view.commands.len();
    let good = view.status.iter().find(|s| s.0 == "ok").map_or(0, |s| s.1);
    page.raw(&format!(
        "<p class=\"verdict\">{}</p>",
        escape(&format!(
            "{} of {} are reached; {} outside the range that the model was fitted on, where it extrapolates.",
            good,
            count(total, "pose"),
            count(view.extrapolating, "command")
        ))
    ));
    let list: Vec<Bar> = view
        .status
        .iter()
        .map(|(word, number)| Bar {
            name: word.clone(),
            range: [0.0, *number as f64],
            class: if word == "ok" { "bar-after" } else { "bar-before" },
            label: number.to_string(),
        })
        .collect();
    page.figure("statuses", &bars("Poses by status", &list, None), "Poses by status.");
    page.section("Corrections");
    let sizes: Vec<f64> = view.commands.iter().map(|c| c.3).collect();
    let top = sizes.iter().copied().filter(|v| v.is_finite()).fold(1e-9, f64::max);
    let drawn = thin(&sizes, DRAWN, |k| view.commands[k].1 != "ok");
    let mut plot = Plot::new(760.0, 300.0, [1.0, total.max(2) as f64], [0.0, 1.05 * top]).axes(
        "size of the correction",
        "pose, in the order of the file",
        "correction, mm",
    );
    plot.dots(
        "after dots",
        drawn.iter().filter(|&&k| view.commands[k].1 == "ok").map(|&k| (view.commands[k].0 as f64, sizes[k])),
    );
    plot.dots(
        "before dots",
        drawn.iter().filter(|&&k| view.commands[k].1 != "ok").map(|&k| (view.commands[k].0 as f64, sizes[k])),
    );
    page.figure(
        "corrections",
        &plot.finish("Size of the correction of every pose"),
        &format!(
            "Distance between the desired position and where the nominal robot would go under the compensated command: median {} mm, 95 % {} mm, largest {} mm. \
             Orange: poses that are not reached. {} of {total} are drawn.",
            significant(quantile(sizes.clone(), 0.5), 3),
            significant(quantile(sizes.clone(), 0.95), 3),
            significant(top, 3),
            drawn.len()
        ),
    );
    let missed: Vec<Vec<String>> = view
        .commands
        .iter()
        .filter(|c| c.1 != "ok")
        .take(100)
        .map(|c| vec![c.0.to_string(), c.1.clone(), significant(c.2, 3)])
        .collect();
    if !missed.is_empty() {
        page.table(
            "Poses that are not reached (the first 100), with what the nearest command leaves",
            &["pose", "status", "mm"],
            &missed,
            true,
        );
    }
    page.section("Files");
    page.repeat(run);
    page.finish()
}
