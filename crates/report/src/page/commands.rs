//! The page of a compensation: status and correction of every desired pose.

use super::{Page, Report};
use crate::figure::{Bar, Chart, Plot, bars, cells_for, chart, escape, quantile, range, thin};
use crate::{RunRecord, count, significant};
use serde::{Deserialize, Serialize};

/// Commands as the page shows them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CommandsView {
    /// The robot's name.
    pub robot: String,
    /// Names and units of the joints, as in the commands below: degrees or mm.
    #[serde(default)]
    pub joints: Vec<String>,
    /// Names of the statuses with their counts.
    pub status: Vec<(String, usize)>,
    /// Number of commands outside of the range of the data of the fit.
    pub extrapolating: usize,
    /// One command for each pose, in the order of the file.
    pub commands: Vec<CommandView>,
}

/// One command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CommandView {
    /// Row of the pose, from 1.
    pub row: usize,
    /// Line of its file; null where the poses came from no file.
    #[serde(default)]
    pub line: Option<u64>,
    /// Status of the command: `ok`, `limit`, `unreachable`, `not_converged`.
    pub status: String,
    /// Desired position of the point, measurement frame, mm.
    pub at_mm: [f64; 3],
    /// Distance of the point from there by the model, mm.
    pub left_mm: f64,
    /// The correction: distance of the nominal robot from there under this command, mm; null without a command.
    pub correction_mm: Option<f64>,
    /// Distance within which the real point lies with 95 % probability, mm: noise and uncertainty of the coefficients; null without a
    /// command.
    pub within_95_mm: Option<f64>,
    /// Whether the command is outside of the range of the data of the fit; null without a command.
    pub extrapolates: Option<bool>,
    /// Joint values of the command, degrees or mm; null without a command.
    #[serde(default)]
    pub joints: Option<Vec<f64>>,
}

/// Builds the page.
pub fn commands_report(view: &CommandsView, run: &RunRecord) -> Report {
    const DRAWN: usize = 3000;
    let mut page = Page::new(&format!("{}: compensated commands", view.robot));
    page.head(run, &[("poses", view.commands.len().to_string())]);
    page.section("Verdict");
    let total: usize = view.commands.len();
    let within: Vec<f64> = view.commands.iter().filter_map(|c| c.within_95_mm).collect();
    let good = view.status.iter().find(|s| s.0 == "ok").map_or(0, |s| s.1);
    page.raw(&format!(
        "<p class=\"verdict\">{}</p>",
        escape(&format!(
            "{good} of {} {} reached.{}",
            count(total, "pose"),
            if good == 1 { "is" } else { "are" },
            match quantile(within.clone(), 0.5) {
                mm if mm.is_finite() => format!(
                    " Expected position error (95 %): {} mm (median of the poses), {} mm (largest).",
                    significant(mm, 3),
                    significant(quantile(within, 1.0), 3)
                ),
                _ => String::new(),
            }
        ))
    ));
    match view.extrapolating {
        0 => page.text("All commands are within the range of the data of the fit."),
        n => page.text(&format!(
            "{} outside of the range of the data of the fit: the model extrapolates there, and the true uncertainty is larger than stated.",
            count(n, "command")
        )),
    }
    let list: Vec<Bar> = view
        .status
        .iter()
        .map(|(name, number)| Bar {
            name: name.clone(),
            range: [0.0, *number as f64],
            class: if name == "ok" { "bar-after" } else { "bar-before" },
            label: number.to_string(),
        })
        .collect();
    page.figure("statuses", &bars("Poses by status", &list, None), "Poses by status.");
    page.end_of_sheet();
    page.section("Corrections");
    let sizes: Vec<f64> = view.commands.iter().map(|c| c.correction_mm.unwrap_or(f64::NAN)).collect();
    let top = sizes.iter().copied().filter(|v| v.is_finite()).fold(1e-9, f64::max);
    let drawn: Vec<usize> =
        thin(&sizes, DRAWN, |_| false).into_iter().filter(|&k| sizes[k].is_finite()).collect();
    let mut plot = Plot::new(420.0, 280.0, [1.0, total.max(2) as f64], [0.0, 1.05 * top]).axes(
        "size of the correction",
        "pose, in the order of the file",
        "correction, mm",
    );
    plot.dots("after dots", drawn.iter().map(|&k| (view.commands[k].row as f64, sizes[k])));
    page.figure(
        "corrections",
        &plot.finish("Size of the correction of every pose"),
        &format!(
            "Distance between the desired position and the position of the nominal robot under the compensated command: median {} mm, \
             95th percentile {} mm, largest {} mm. {} of {total} are drawn.",
            significant(quantile(sizes.clone(), 0.5), 3),
            significant(quantile(sizes.clone(), 0.95), 3),
            significant(top, 3),
            drawn.len()
        ),
    );
    over_the_workspace(&mut page, view);
    commands(&mut page, view);
    let line = |c: &CommandView| c.line.map_or_else(|| "–".into(), |line| line.to_string());
    let missed: Vec<Vec<String>> = view
        .commands
        .iter()
        .filter(|c| c.status != "ok")
        .take(100)
        .map(|c| vec![c.row.to_string(), line(c), c.status.clone(), significant(c.left_mm, 3)])
        .collect();
    if !missed.is_empty() {
        page.table(
            "Poses that are not reached (the first 100), with the error of the nearest command",
            &["row", "line", "status", "mm"],
            &missed,
            true,
        );
    }
    page.section("Files");
    page.reproduction(run);
    page.finish()
}

/// The commands themselves.
fn commands(page: &mut Page, view: &CommandsView) {
    const LISTED: usize = 200;
    page.section("Commands");
    let mut head = vec!["row".to_owned(), "line".into(), "status".into()];
    head.extend(view.joints.iter().cloned());
    head.extend(["correction, mm", "within (95 %), mm", "extrapolates"].map(String::from));
    let row = |c: &CommandView| {
        let mut cells =
            vec![c.row.to_string(), c.line.map_or_else(|| "–".into(), |l| l.to_string()), c.status.clone()];
        cells.extend((0..view.joints.len()).map(|k| {
            c.joints.as_ref().and_then(|joints| joints.get(k)).map_or_else(String::new, |v| format!("{v:.4}"))
        }));
        let shown = |v: Option<f64>| v.map_or_else(String::new, |v| significant(v, 3));
        cells.extend([shown(c.correction_mm), shown(c.within_95_mm)]);
        cells.push(c.extrapolates.map_or("", |e| if e { "yes" } else { "no" }).into());
        cells
    };
    let rows: Vec<Vec<String>> = view.commands.iter().take(LISTED).map(row).collect();
    let caption = if view.commands.len() > LISTED {
        format!("The first {LISTED} of {} commands; the file has all, in full precision", view.commands.len())
    } else {
        "Commands, rounded; the file has them in full precision".into()
    };
    let names: Vec<&str> = head.iter().map(String::as_str).collect();
    page.table(&caption, &names, &rows, true);
}

/// Charts of the correction and of the expected error after it.
fn over_the_workspace(page: &mut Page, view: &CommandsView) {
    let ok: Vec<&CommandView> = view.commands.iter().filter(|c| c.status == "ok").collect();
    let at: Vec<[f64; 3]> = ok.iter().map(|c| c.at_mm).collect();
    let columns = [
        ok.iter().map(|c| c.correction_mm.unwrap_or(f64::NAN)).collect::<Vec<f64>>(),
        ok.iter().map(|c| c.within_95_mm.unwrap_or(f64::NAN)).collect(),
    ];
    over_two_axes(
        page,
        &at,
        columns,
        ["correction", "expected error (95 %)"],
        false,
        "RMS in cells over the workspace (measurement frame; each chart has its own scale). Right: distance from the desired position \
         within which the point lies with 95 % probability, from noise and from the uncertainty of the coefficients.",
    );
}

/// Two quantities over the two directions in which places lie farthest apart, in one scale or in two.
pub(super) fn over_two_axes(
    page: &mut Page,
    at: &[[f64; 3]],
    columns: [Vec<f64>; 2],
    titles: [&str; 2],
    one_scale: bool,
    caption: &str,
) {
    let place = |axis: usize| at.iter().map(|v| v[axis]).collect::<Vec<f64>>();
    let mut axes: Vec<(usize, f64)> = (0..3)
        .map(|axis| {
            let [low, high] = range(&place(axis));
            (axis, high - low)
        })
        .collect();
    axes.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    if at.len() < 12 || axes[1].1 <= 0.0 {
        return;
    }
    let (across, up) = (axes[0].0.min(axes[1].0), axes[0].0.max(axes[1].0));
    let names = [across, up].map(|axis| format!("{}, mm", ["x", "y", "z"][axis]));
    let charts =
        columns.each_ref().map(|list| Chart::rms(&place(across), &place(up), list, cells_for(at.len())));
    let both = charts[0].most().max(charts[1].most());
    let one = |k: usize, class: &str| {
        let most = if one_scale { both } else { charts[k].most() };
        let about = format!(
            "{} over the workspace, RMS in each cell; largest {} mm",
            titles[k],
            significant(charts[k].most(), 3)
        );
        chart(&about, titles[k], [&names[0], &names[1]], &charts[k], most, class)
    };
    page.figures("over_workspace", &[one(0, "bar-before"), one(1, "bar-after")], caption);
}
