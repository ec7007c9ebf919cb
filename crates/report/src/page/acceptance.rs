//! The page of an acceptance: a protocol that a customer gets.

use super::{Page, Report};
use crate::acceptance::{heads, pose_rows, symbols};
use crate::figure::{Bar, Plot, bars, escape};
use crate::{
    AcceptanceSummary, FigureSummary, Limit, PoseDistanceSummary, RunRecord, StateSummary, count, significant,
};
use truepose_acceptance::Conformity;

/// Builds the page.
pub fn acceptance_report(summary: &AcceptanceSummary, run: &RunRecord) -> Report {
    let mut page = Page::new(&format!("{}: acceptance after ISO 9283", summary.robot));
    let poses = summary.before.poses.len();
    let cycles = summary.before.poses.iter().map(|pose| pose.cycles).min().unwrap_or(0);
    let tested = match &summary.before.path {
        Some(path) => format!("path of {}, {}", count(path.points, "point"), count(path.cycles, "cycle")),
        None => format!("{}, {} at the least", count(poses, "pose"), count(cycles, "cycle")),
    };
    let instrument = match summary.instrument_u_mm {
        u if u > 0.0 => format!("{} mm in each axis", significant(u, 2)),
        _ => "not stated".into(),
    };
    page.head(
        run,
        &[
            ("tested", tested),
            ("frames", summary.alignment.to_owned()),
            ("standard uncertainty of the instrument", instrument),
        ],
    );
    page.section("Verdict");
    verdict(&mut page, summary);
    overview(&mut page, summary);
    page.list(&summary.remarks);
    page.raw(
        "<div class=\"signatures\"><div>date, signature of the operator</div><div>date, signature of the customer</div></div>",
    );
    page.end_of_sheet();
    page.section("Pose accuracy");
    largest(&mut page, summary);
    for state in std::iter::once(&summary.before).chain(&summary.after) {
        of_state(&mut page, state);
    }
    if !summary.verdicts.is_empty() {
        page.section("Limits");
        page.text(
            "Decision rule after ISO 14253-1: a figure conforms where it lies below the limit by its guard band at the least, and does not \
             conform where it lies above by that. Between them it is undecided. Guard bands are one-sided 95 % bounds: the factor of the \
             standard uncertainty is 1.645 where that is known, and Student's quantile where it has degrees of freedom.",
        );
        let head = ["state", "of", "figure", "value, mm", "guard band, mm", "factor", "limit, mm", "verdict"];
        page.table("Figures against their limits", &head, &summary.verdict_rows(), true);
    }
    if let Some(budget) = &summary.budget {
        page.section("Uncertainty budget");
        page.document(&budget.document());
    }
    page.section("Definitions");
    definitions(&mut page);
    page.section("Files");
    page.reproduction(run);
    page.finish()
}

fn verdict(page: &mut Page, summary: &AcceptanceSummary) {
    if let Some(verdict) = summary.verdict {
        let class = match verdict {
            "conform" => "pass",
            "not conform" => "fail",
            _ => "not_decided",
        };
        page.raw(&format!(
            "<p class=\"verdict\"><span class=\"badge {class}\">{}</span> {}</p>",
            escape(verdict),
            escape(&summary.sentence())
        ));
    } else {
        page.raw(&format!("<p class=\"verdict\">{}</p>", escape(&summary.sentence())));
        page.note("No limits were given. With --spec AP=0.5mm, figures are compared with them.");
    }
}

/// The worst of each figure, its limit and verdict.
fn overview(page: &mut Page, summary: &AcceptanceSummary) {
    let states: Vec<&StateSummary> = std::iter::once(&summary.before).chain(&summary.after).collect();
    let judged = states.last().map_or("", |state| state.name);
    let mut rows = Vec::new();
    for (name, symbol) in Limit::KNOWN {
        let worst: Vec<_> = states.iter().map(|state| state.worst(symbol)).collect();
        if worst.iter().all(Option::is_none) {
            continue;
        }
        let mut row = vec![format!("{name} ({symbol})")];
        for one in &worst {
            row.push(
                one.as_ref().map_or_else(|| "–".into(), |(of, figure)| format!("{} ({of})", figure.shown())),
            );
        }
        let of_figure = || summary.verdicts.iter().filter(|v| v.symbol == symbol && v.state == judged);
        let limit = of_figure().next().map(|v| significant(v.limit_mm, 3));
        let verdict = limit.is_some().then(|| Conformity::of_all(of_figure().map(|v| v.conformity)).name());
        row.push(limit.unwrap_or_else(|| "–".into()));
        row.push(verdict.unwrap_or("–").into());
        rows.push(row);
    }
    let mut head = vec!["figure, mm"];
    head.extend(states.iter().map(|state| state.name));
    head.extend(["limit", "verdict"]);
    let caption =
        "Worst of each figure (± expanded uncertainty, k = 2; in brackets 95 % interval), and where";
    page.table(caption, &head, &rows, true);
}

/// AP of every pose, before and after.
fn largest(page: &mut Page, summary: &AcceptanceSummary) {
    let states: Vec<&StateSummary> = std::iter::once(&summary.before).chain(&summary.after).collect();
    let mut list = Vec::new();
    for (k, pose) in summary.before.poses.iter().enumerate().take(12) {
        for (state, class) in states.iter().zip(["bar-before", "bar-after"]) {
            let Some(figure) = state.poses.get(k).and_then(|pose| pose.figure("AP_p")) else { continue };
            list.push(Bar {
                name: format!("{}, {}", pose.name, state.name),
                range: [0.0, figure.value],
                class,
                label: format!("{} mm", figure.text()),
            });
        }
    }
    if !list.is_empty() {
        let limit = summary.verdicts.iter().find(|v| v.symbol == "AP_p").map(|v| v.limit_mm);
        let level = limit.map(|limit| (limit, format!("limit {} mm", significant(limit, 3))));
        let svg = bars("Pose accuracy AP by pose", &list, level);
        page.figure("accuracy", &svg, "Pose accuracy AP_p with its expanded uncertainty (k = 2).");
    }
}

fn of_state(page: &mut Page, state: &StateSummary) {
    let title = match state.name {
        "as measured" => "Robot as measured",
        _ => "Robot with the identified model",
    };
    page.section(title);
    if state.name != "as measured" {
        page.note("The displacement that the model predicts is taken off the same measurements.");
    }
    let groups: [(&str, &[&str]); 3] = [
        ("Position: accuracy AP and repeatability RP", &["AP_p", "AP_x", "AP_y", "AP_z", "RP_l"]),
        ("Orientation", &["AP_a", "AP_b", "AP_c", "RP_a", "RP_b", "RP_c"]),
        (
            "Directions of approach (vAP) and drift (dAP, dRP)",
            &["vAP_p", "vAP_a", "vAP_b", "vAP_c", "dAP_p", "dRP_l"],
        ),
    ];
    for (caption, wanted) in groups {
        let symbols = symbols(state, wanted);
        if symbols.is_empty() {
            continue;
        }
        let mut head = vec!["pose".to_owned(), "cycles".into()];
        head.extend(heads(state, &symbols));
        let head: Vec<&str> = head.iter().map(String::as_str).collect();
        let caption = format!("{caption} (± expanded uncertainty, k = 2; in brackets 95 % interval)");
        page.table(&caption, &head, &pose_rows(state, &symbols), true);
    }
    cycles(page, state);
    distances(page, &state.distances);
    compliance(page, state);
    path(page, state);
}

/// Attained positions about their commands, pose by pose.
fn cycles(page: &mut Page, state: &StateSummary) {
    let all: Vec<&[f64; 3]> = state.poses.iter().flat_map(|pose| &pose.deviations_mm).collect();
    if all.is_empty() {
        return;
    }
    let most = all.iter().flat_map(|d| d.iter().map(|v| v.abs())).fold(1e-6, f64::max) * 1.05;
    let (range, class) = ([-most, most], if state.name == "as measured" { "before" } else { "after" });
    let panels: Vec<String> = [(0, 1), (0, 2)]
        .into_iter()
        .map(|(x, y)| {
            let name = |k: usize| format!("{}, mm", ["x", "y", "z"][k]);
            let title = format!("{} and {}", ["x", "y", "z"][x], ["x", "y", "z"][y]);
            let mut plot = Plot::new(340.0, 300.0, range, range).axes(&title, &name(x), &name(y));
            plot.line("ink thinline", &[(-most, 0.0), (most, 0.0)]);
            plot.line("ink thinline", &[(0.0, -most), (0.0, most)]);
            for pose in &state.poses {
                plot.dots(&format!("{class} dots"), pose.deviations_mm.iter().map(|d| (d[x], d[y])));
                let mean = |k: usize| {
                    pose.deviations_mm.iter().map(|d| d[k]).sum::<f64>() / pose.deviations_mm.len() as f64
                };
                let named = std::iter::once((mean(x), mean(y), pose.name.clone()));
                plot.named_dots(&format!("{class} strong"), named);
            }
            plot.finish(&format!("Attained minus commanded position of every cycle, {title}, {}", state.name))
        })
        .collect();
    let name = if state.name == "as measured" { "cycles" } else { "cycles_with_model" };
    page.figures(
        name,
        &panels,
        "Attained minus commanded position of every cycle, base frame; large: the mean of each pose.",
    );
}

fn distances(page: &mut Page, all: &[PoseDistanceSummary]) {
    let find = |pair: &PoseDistanceSummary, s: &str| {
        let figure = pair.figures.iter().find(|figure| figure.symbol == s);
        figure.map_or_else(String::new, FigureSummary::shown)
    };
    let symbols = ["AD_p", "AD_x", "AD_y", "AD_z", "RD_p"];
    let row = |pair: &PoseDistanceSummary| {
        let mut row =
            vec![pair.between.join("–"), pair.cycles.to_string(), significant(pair.commanded_mm, 6)];
        row.extend(symbols.map(|s| find(pair, s)));
        row
    };
    let rows: Vec<Vec<String>> = all.iter().map(row).collect();
    if !rows.is_empty() {
        let head =
            ["poses", "cycles", "commanded, mm", "AD_p, mm", "AD_x, mm", "AD_y, mm", "AD_z, mm", "RD_p, mm"];
        page.table("Distance accuracy AD and repeatability RD", &head, &rows, true);
    }
}

fn compliance(page: &mut Page, state: &StateSummary) {
    let row = |one: &crate::ComplianceSummary| {
        let [low, high] = one.forces_n.map(|v| significant(v, 3));
        let mut row = vec![
            one.poses.first().cloned().unwrap_or_default(),
            one.direction.clone(),
            format!("{low} to {high}"),
            one.levels.to_string(),
        ];
        row.extend(one.displacement_um_per_n.map(|v| significant(v, 3)));
        row.push(one.compliance.text());
        row
    };
    let rows: Vec<Vec<String>> = state.compliance.iter().map(row).collect();
    if !rows.is_empty() {
        let head =
            ["pose", "direction", "force, N", "levels", "x, µm/N", "y, µm/N", "z, µm/N", "compliance, µm/N"];
        page.table("Static compliance: displacement per force", &head, &rows, true);
    }
}

fn path(page: &mut Page, state: &StateSummary) {
    let Some(path) = &state.path else { return };
    let row = |(figure, at): (&FigureSummary, &usize)| {
        vec![figure.symbol.clone(), figure.shown(), at.to_string(), path.cycles.to_string()]
    };
    let rows: Vec<Vec<String>> = path.figures.iter().zip(&path.at_points).map(row).collect();
    page.table("Path accuracy AT and repeatability RT", &["figure", "mm", "at point", "cycles"], &rows, true);
    let most = path.deviations_mm.iter().map(|d| d.1).fold(1e-6, f64::max);
    let class = if state.name == "as measured" { "before" } else { "after" };
    let mut plot = Plot::new(420.0, 260.0, [1.0, path.points.max(2) as f64], [0.0, 1.05 * most]).axes(
        "deviation of the mean path",
        "commanded point",
        "deviation, mm",
    );
    let points: Vec<(f64, f64)> = path.deviations_mm.iter().map(|(p, d)| (*p as f64, *d)).collect();
    plot.line(&format!("{class} curve"), &points);
    let name = if state.name == "as measured" { "path" } else { "path_with_model" };
    page.figure(
        name,
        &plot.finish("Deviation of the mean attained path from the commanded points"),
        &format!(
            "Deviation of the mean attained path from the commanded points, in the plane normal to the path; {} of {} are evaluated.",
            path.evaluated,
            count(path.points, "point")
        ),
    );
}

fn definitions(page: &mut Page) {
    let row = |symbol: &str, words: &str| vec![symbol.to_owned(), words.to_owned()];
    let rows = [
        row(
            "AP_p; AP_x …; AP_a …",
            "distance of the mean attained position from the command; its components; components of the rotation of the mean attained orientation from the command, about the axes of the base",
        ),
        row(
            "RP_l; RP_a …",
            "mean plus three standard deviations of the distances of the cycles from their mean; three standard deviations of the angles",
        ),
        row("vAP", "largest distance between the means of different directions of approach"),
        row(
            "AD, RD",
            "mean attained minus commanded distance of two poses; three standard deviations of the distance",
        ),
        row("dAP, dRP", "largest change of AP and RP of ten cycles against the first ten"),
        row("AT, RT", "AP and RP at the worst point of a path, in the plane normal to the path"),
        row(
            "uncertainty",
            "k = 2. Student's t for AP_x, AP_a and AD and chi-squared for RP_a and RD: exact for normal scatter; AP_p, vAP, dAP and compliance to first order; RP_l by a parametric bootstrap",
        ),
    ];
    page.table("Figures of ISO 9283:1998, base frame", &["figure", "definition"], &rows, false);
}
