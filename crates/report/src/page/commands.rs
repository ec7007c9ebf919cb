//! The page of a compensation: what became of every pose that was asked for.

use super::{Page, Report};
use crate::figure::{Bar, Chart, Plot, bars, cells_for, chart, escape, quantile, range, thin};
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
    /// In the order of the file.
    pub commands: Vec<CommandView>,
}

/// One command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CommandView {
    /// Row of the pose, from 1.
    pub row: usize,
    /// What became of it.
    pub status: String,
    /// Where the point is wanted, measurement frame, mm.
    pub at_mm: [f64; 3],
    /// How far the point ends from there, by the model, mm.
    pub left_mm: f64,
    /// How far the nominal robot would end from there under this command, mm: the correction.
    pub correction_mm: f64,
    /// With 95 %, the real point ends no farther from there than this, mm: noise of the fit and what its coefficients leave open.
    pub within_95_mm: f64,
    /// Whether the model was asked beyond the range that it was fitted on.
    pub extrapolates: bool,
}

/// Forms the page.
pub fn commands_report(view: &CommandsView, run: &RunRecord) -> Report {
    const DRAWN: usize = 3000;
    let mut page = Page::new(&format!("{}: compensated commands", view.robot));
    page.section("Verdict");
    let total: usize = view.commands.len();
    let within: Vec<f64> =
        view.commands.iter().filter(|c| c.status == "ok").map(|c| c.within_95_mm).collect();
    let good = view.status.iter().find(|s| s.0 == "ok").map_or(0, |s| s.1);
    page.raw(&format!(
        "<p class=\"verdict\">{}</p>",
        escape(&format!(
            "{good} of {} {} reached.{}",
            count(total, "pose"),
            if good == 1 { "is" } else { "are" },
            match quantile(within.clone(), 0.5) {
                mm if mm.is_finite() => format!(
                    " With 95 % a point ends within {} mm of where it is wanted (median of the poses; {} mm for the worst).",
                    significant(mm, 3),
                    significant(quantile(within, 1.0), 3)
                ),
                _ => String::new(),
            }
        ))
    ));
    match view.extrapolating {
        0 => page.text("No command is outside the range that the model was fitted on."),
        n => page.text(&format!(
            "{} outside the range that the model was fitted on: it extrapolates there, and its figures are less certain than they say.",
            count(n, "command")
        )),
    }
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
    let sizes: Vec<f64> = view.commands.iter().map(|c| c.correction_mm).collect();
    let top = sizes.iter().copied().filter(|v| v.is_finite()).fold(1e-9, f64::max);
    let drawn = thin(&sizes, DRAWN, |k| view.commands[k].status != "ok");
    let mut plot = Plot::new(420.0, 280.0, [1.0, total.max(2) as f64], [0.0, 1.05 * top]).axes(
        "size of the correction",
        "pose, in the order of the file",
        "correction, mm",
    );
    for (class, wanted) in [("after dots", true), ("before dots", false)] {
        let of = drawn.iter().filter(|&&k| (view.commands[k].status == "ok") == wanted);
        plot.dots(class, of.map(|&k| (view.commands[k].row as f64, sizes[k])));
    }
    page.figure(
        "corrections",
        &plot.finish("Size of the correction of every pose"),
        &format!(
            "Distance between the desired position and where the nominal robot would go under the compensated command: median {} mm, \
             95 % below {} mm, largest {} mm. Orange: poses that are not reached. {} of {total} are drawn.",
            significant(quantile(sizes.clone(), 0.5), 3),
            significant(quantile(sizes.clone(), 0.95), 3),
            significant(top, 3),
            drawn.len()
        ),
    );
    over_the_workspace(&mut page, view);
    let missed: Vec<Vec<String>> = view
        .commands
        .iter()
        .filter(|c| c.status != "ok")
        .take(100)
        .map(|c| vec![c.row.to_string(), c.status.clone(), significant(c.left_mm, 3)])
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

/// Charts of the correction and of what is expected after it, over the two directions in which the poses lie farthest apart.
fn over_the_workspace(page: &mut Page, view: &CommandsView) {
    let ok: Vec<&CommandView> = view.commands.iter().filter(|c| c.status == "ok").collect();
    let place = |axis: usize| ok.iter().map(|c| c.at_mm[axis]).collect::<Vec<f64>>();
    let mut axes: Vec<(usize, f64)> = (0..3)
        .map(|axis| {
            let [low, high] = range(&place(axis));
            (axis, high - low)
        })
        .collect();
    axes.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    if ok.len() < 12 || axes[1].1 <= 0.0 {
        return;
    }
    let (across, up) = (axes[0].0.min(axes[1].0), axes[0].0.max(axes[1].0));
    let names = [across, up].map(|axis| format!("{}, mm", ["x", "y", "z"][axis]));
    let columns = [
        ok.iter().map(|c| c.correction_mm).collect::<Vec<f64>>(),
        ok.iter().map(|c| c.within_95_mm).collect(),
    ];
    let titles = ["correction", "expected after it, with 95 %"];
    let charts =
        columns.each_ref().map(|list| Chart::rms(&place(across), &place(up), list, cells_for(ok.len())));
    let one = |k: usize, class: &str| {
        let most = charts[k].most();
        let about = format!(
            "{} over the workspace, RMS in each cell; largest {} mm",
            titles[k],
            significant(most, 3)
        );
        chart(&about, titles[k], [&names[0], &names[1]], &charts[k], most, class)
    };
    page.figures(
        "over_workspace",
        &[one(0, "bar-before"), one(1, "bar-after")],
        "RMS in cells over the workspace (measurement frame; each chart has a scale of its own). Right: the distance from where it is wanted \
         within which the point is expected with 95 %, by the noise of the fit and by what its coefficients leave open.",
    );
}
