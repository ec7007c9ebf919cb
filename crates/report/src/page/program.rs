//! The page of a compensated robot program: what became of every point.

use super::changed::{ChangedLine, changed};
use super::commands::over_two_axes;
use super::robot::{Stick, Words};
use super::{Page, Report};
use crate::figure::{Bar, Plot, bars, escape, quantile, thin};
use crate::{RunRecord, count, significant};
use serde::{Deserialize, Serialize};

/// Outcome of points that stay at a singularity of the wrist.
const SINGULAR: &str = "unchanged at a wrist singularity";

/// Parts of a path that are drawn.
const DRAWN: usize = 400;

/// Corrections as the page shows them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ProgramView {
    /// The robot's name.
    pub robot: String,
    /// Name of the program's file; further files that have points of it are named by these.
    pub program: String,
    /// Its language.
    pub language: String,
    /// Whether the program was written as it was.
    pub dry_run: bool,
    /// Names and units of the joints below: degrees or mm.
    pub joints: Vec<String>,
    /// Frames of its points about which nothing is stated: whether they were taught with the uncorrected robot.
    #[serde(default)]
    pub open_frames: Vec<String>,
    /// Values of frames and tools that correct the points, in place of the program.
    #[serde(default)]
    pub offsets: Vec<OffsetView>,
    /// Statements of the program whose positions are not in it.
    pub notes: Vec<String>,
    /// One for each point, in the order of the file.
    pub points: Vec<CorrectionView>,
    /// Lines that are not as they were.
    #[serde(default)]
    pub changed: Vec<ChangedLine>,
}

/// A frame or a tool with another value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OffsetView {
    /// Its name in the program.
    pub name: String,
    /// `frame` or `tool`.
    pub kind: String,
    /// The value, in the form of the program's language.
    pub value: Vec<(String, f64)>,
    /// How many points it has.
    pub points: usize,
    /// Root mean square of their corrections, mm.
    pub rms_before_mm: f64,
    /// And of what remains.
    pub rms_after_mm: f64,
}

/// One point; null where it is not known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CorrectionView {
    /// Name of the file that has it: the program's, or a further one.
    #[serde(default)]
    pub file: String,
    /// As the program calls it.
    pub name: String,
    /// Line of the program.
    pub line: usize,
    /// `pose` or `joints`.
    pub kind: String,
    /// Its frame in the program; empty of joints.
    #[serde(default)]
    pub frame: String,
    /// Its tool.
    #[serde(default)]
    pub tool: String,
    /// `corrected`, `not significant` or `refused`.
    pub outcome: String,
    /// Why, where it is not corrected.
    pub reason: String,
    /// Desired position of the tool of the measurements, measurement frame, mm.
    pub at_mm: Option<[f64; 3]>,
    /// Displacement of the point, axes of the robot's base, mm.
    pub displacement_mm: Option<[f64; 3]>,
    /// The same in the axes of the measurement frame, mm.
    #[serde(default)]
    pub moved_mm: Option<[f64; 3]>,
    /// Its size, mm.
    pub correction_mm: Option<f64>,
    /// Rotation of the point, degrees.
    pub rotation_deg: Option<f64>,
    /// Distance from the desired position within which the real tool lies with 95 % probability, mm.
    pub within_95_mm: Option<f64>,
    /// Joints of the nominal robot at the point, degrees or mm.
    pub joints: Option<Vec<f64>>,
}

/// Builds the page.
pub fn program_report(view: &ProgramView, run: &RunRecord) -> Report {
    let mut page = Page::new(&format!("{}: {}", view.robot, view.program));
    page.head(run, &[("points", view.points.len().to_string()), ("language", view.language.clone())]);
    page.section("Verdict");
    let of = |outcome: &str| view.points.iter().filter(|point| point.outcome == outcome).count();
    let sizes: Vec<f64> = view
        .points
        .iter()
        .filter(|point| point.outcome == "corrected")
        .filter_map(|point| point.correction_mm)
        .collect();
    let corrected = of("corrected");
    let mut verdict = format!(
        "{corrected} of {} {} compensated.",
        count(view.points.len(), "point"),
        if corrected == 1 { "is" } else { "are" }
    );
    if !sizes.is_empty() {
        verdict.push_str(&format!(
            " Correction: {} mm (median), {} mm (largest).",
            significant(quantile(sizes.clone(), 0.5), 3),
            significant(quantile(sizes, 1.0), 3)
        ));
    }
    page.raw(&format!("<p class=\"verdict\">{}</p>", escape(&verdict)));
    if view.dry_run {
        page.text("Dry run: the program was written as it was. The corrections below are not in it.");
    }
    if of("refused") > 0 {
        page.text(&format!("{} unchanged: see the reasons below.", count(of("refused"), "point")));
    }
    let list: Vec<Bar> = ["corrected", "not significant", SINGULAR, "refused"]
        .into_iter()
        .filter(|outcome| of(outcome) > 0)
        .map(|outcome| Bar {
            name: outcome.into(),
            range: [0.0, of(outcome) as f64],
            class: if outcome == "corrected" { "bar-after" } else { "bar-before" },
            label: of(outcome).to_string(),
        })
        .collect();
    if !list.is_empty() {
        page.figure("outcomes", &bars("Points by outcome", &list, None), "Points by outcome.");
    }
    page.end_of_sheet();
    offsets(&mut page, view);
    corrections(&mut page, view);
    path(&mut page, view);
    frames(&mut page, view);
    refused(&mut page, view);
    listed(&mut page, view);
    changed(&mut page, &view.changed);
    if !view.notes.is_empty() {
        page.section("Notes");
        page.list(&view.notes);
    }
    page.section("Files");
    page.reproduction(run);
    page.finish()
}

/// The line of a point, with the file's name where points are in several.
fn place(view: &ProgramView, point: &CorrectionView) -> String {
    match view.points.iter().any(|other| other.file != point.file) {
        true => format!("{}:{}", point.file, point.line),
        false => point.line.to_string(),
    }
}

/// The size of every correction, and where it is.
fn corrections(page: &mut Page, view: &ProgramView) {
    let known: Vec<(usize, f64)> =
        view.points.iter().enumerate().filter_map(|(k, point)| Some((k, point.correction_mm?))).collect();
    if known.is_empty() {
        return;
    }
    page.section("Corrections");
    let top = known.iter().map(|(_, size)| *size).fold(1e-9, f64::max);
    let most = view.points.len().max(2) as f64;
    let mut plot = Plot::new(420.0, 280.0, [0.5, most + 0.5], [0.0, 1.05 * top]).axes(
        "size of the correction",
        "point, in the order of the program",
        "correction, mm",
    );
    let dots = |corrected: bool| {
        let keep = move |k: usize| (view.points[k].outcome == "corrected") == corrected;
        known.iter().filter(move |(k, _)| keep(*k)).map(|&(k, size)| ((k + 1) as f64, size))
    };
    plot.dots("before dots", dots(false));
    plot.dots("after dots", dots(true));
    page.figure(
        "corrections",
        &plot.finish("Size of the correction of every point"),
        "Distance by which each point is displaced. Points that were refused with a known correction have the other colour.",
    );
    let placed: Vec<&CorrectionView> = view.points.iter().filter(|point| point.at_mm.is_some()).collect();
    let at: Vec<[f64; 3]> = placed.iter().filter_map(|point| point.at_mm).collect();
    let columns = [
        placed.iter().map(|point| point.correction_mm.unwrap_or(f64::NAN)).collect(),
        placed.iter().map(|point| point.within_95_mm.unwrap_or(f64::NAN)).collect(),
    ];
    over_two_axes(
        page,
        &at,
        columns,
        ["correction", "expected error (95 %)"],
        false,
        "RMS in cells over the workspace (measurement frame; each chart has its own scale). Right: distance from the desired position \
         within which the tool lies with 95 % probability, from noise and from the uncertainty of the coefficients.",
    );
}

/// Values of frames and tools in place of the program.
fn offsets(page: &mut Page, view: &ProgramView) {
    if view.offsets.is_empty() {
        return;
    }
    page.section("Offsets");
    page.text("No program was written. These values of frames and tools correct their points as far as one value can; the rest remains at each point.");
    let row = |offset: &OffsetView| {
        let value: Vec<String> =
            offset.value.iter().map(|(name, value)| format!("{name} {value:.4}")).collect();
        let mut cells =
            vec![offset.name.clone(), offset.kind.clone(), value.join(", "), offset.points.to_string()];
        cells.extend([offset.rms_before_mm, offset.rms_after_mm].map(|v| significant(v, 3)));
        cells
    };
    let rows: Vec<Vec<String>> = view.offsets.iter().map(row).collect();
    let head = ["name", "kind", "value", "points", "RMS before, mm", "RMS after, mm"];
    page.table("New values; RMS of the corrections before and after", &head, &rows, false);
}

/// The path before and after, and the corrections by frame and tool.
fn path(page: &mut Page, view: &ProgramView) {
    let mut groups: Vec<([&str; 2], Vec<f64>)> = Vec::new();
    let mut sticks: Vec<(f64, Stick)> = Vec::new();
    let mut last: Option<(&CorrectionView, [f64; 3])> = None;
    for point in &view.points {
        let Some(at) = point.at_mm else {
            last = None;
            continue;
        };
        let moved = |point: &CorrectionView| point.moved_mm.unwrap_or_default();
        let size = point.correction_mm.unwrap_or(0.0);
        let on = [point.frame.as_str(), point.tool.as_str()];
        if point.correction_mm.is_some() {
            match groups.iter_mut().find(|(other, _)| *other == on) {
                Some((_, sizes)) => sizes.push(size),
                None => groups.push((on, vec![size])),
            }
        }
        let from = last.filter(|(other, _)| other.file == point.file);
        let ends: Vec<(&CorrectionView, [f64; 3])> = from.into_iter().chain([(point, at)]).collect();
        sticks.push((
            size,
            Stick {
                corners: ends.iter().map(|(_, at)| *at).collect(),
                moved: ends.iter().map(|(point, _)| moved(point)).collect(),
                point: at,
                errors: if size > 0.0 { vec![moved(point)] } else { Vec::new() },
                label: match point.name.contains(" in line ") {
                    true => point.name.clone(),
                    false => format!("{}, line {}", point.name, place(view, point)),
                },
            },
        ));
        last = Some((point, at));
    }
    let count = sticks.len();
    // The largest first; of a long program each of its parts.
    let sizes: Vec<f64> = sticks.iter().map(|(size, _)| *size).collect();
    let kept = thin(&sizes, DRAWN, |_| false);
    let mut k = 0;
    sticks.retain(|_| {
        k += 1;
        kept.contains(&(k - 1))
    });
    sticks.sort_by(|a, b| b.0.total_cmp(&a.0));
    let list: Vec<Stick> = sticks.into_iter().map(|(_, stick)| stick).collect();
    if !list.iter().any(|stick| !stick.errors.is_empty()) {
        return;
    }
    let drawn = if list.len() < count {
        format!("{} of {count} points are drawn. ", list.len())
    } else {
        String::new()
    };
    let words = Words {
        title: "The path before and after",
        about: format!("The path of the tool through {}", crate::count(list.len(), "point")),
        arrows: "corrections",
        item: "point",
        hint: "point at a place for its correction",
    };
    page.sticks(
        &list,
        &["correction"],
        &words,
        &format!(
            "{drawn}The slider goes from the largest correction to the smallest. Desired positions of the tool of the measurements, measurement frame; the second line is the path of \
             the compensated program, its displacement exaggerated as the arrows are."
        ),
    );
    groups.sort_by(|a, b| quantile(b.1.clone(), 1.0).total_cmp(&quantile(a.1.clone(), 1.0)));
    let shown = |name: &str| if name.is_empty() { "–".to_owned() } else { name.to_owned() };
    let row = |([frame, tool], sizes): &([&str; 2], Vec<f64>)| {
        let rms = (sizes.iter().map(|v| v * v).sum::<f64>() / sizes.len() as f64).sqrt();
        let mut cells = vec![shown(frame), shown(tool), sizes.len().to_string()];
        cells.extend(
            [quantile(sizes.clone(), 1.0), quantile(sizes.clone(), 0.5), rms].map(|v| significant(v, 3)),
        );
        cells
    };
    let rows: Vec<Vec<String>> = groups.iter().map(row).collect();
    let head = ["frame", "tool", "points", "largest, mm", "median, mm", "RMS, mm"];
    page.table("Corrections by frame and tool, the largest first", &head, &rows, false);
}

/// What a frame that was taught does to its points.
fn frames(page: &mut Page, view: &ProgramView) {
    if view.open_frames.is_empty() {
        return;
    }
    page.section("Frames");
    page.text(&format!(
        "How these frames were made is not stated: {}. A frame that was taught by touching points with this robot, before it was \
         compensated, is displaced by the robot's errors there: in it the uncompensated robot was right near the touched points. This \
         program takes the frame as right and compensates the errors once more, which can make the fixture worse than before. \
         State the joints at which it was touched (--taught NAME=FILE), and its points are compensated relative to the fixture where it \
         really is. A frame that was measured or that is one of a drawing needs nothing else: --measured NAME, --cad NAME.",
        view.open_frames.join(", ")
    ));
}

fn refused(page: &mut Page, view: &ProgramView) {
    let rows: Vec<Vec<String>> = view
        .points
        .iter()
        .filter(|point| [SINGULAR, "refused"].contains(&point.outcome.as_str()))
        .take(100)
        .map(|point| vec![point.name.clone(), place(view, point), point.reason.clone()])
        .collect();
    if !rows.is_empty() {
        page.section("Unchanged points");
        page.table(
            "Points that stay as they are, and why (the first 100)",
            &["point", "line", "reason"],
            &rows,
            false,
        );
    }
}

fn listed(page: &mut Page, view: &ProgramView) {
    const LISTED: usize = 200;
    page.section("Points");
    let shown = |v: Option<f64>| v.map_or_else(String::new, |v| significant(v, 3));
    let row = |point: &CorrectionView| {
        let mut cells = vec![point.name.clone(), place(view, point), point.outcome.clone()];
        cells.extend([&point.frame, &point.tool].map(Clone::clone));
        let parts = point.displacement_mm.map_or([None; 3], |d| d.map(Some));
        cells.extend(parts.map(|v| v.map_or_else(String::new, |v| format!("{v:.3}"))));
        cells.push(shown(point.correction_mm));
        cells.push(point.rotation_deg.map_or_else(String::new, |v| format!("{v:.4}")));
        cells.push(shown(point.within_95_mm));
        cells
    };
    let mut points: Vec<&CorrectionView> = view.points.iter().collect();
    points.sort_by(|a, b| b.correction_mm.unwrap_or(-1.0).total_cmp(&a.correction_mm.unwrap_or(-1.0)));
    let rows: Vec<Vec<String>> = points.into_iter().take(LISTED).map(row).collect();
    let caption = if view.points.len() > LISTED {
        format!(
            "The {LISTED} largest corrections of {} points; the table beside the program has all",
            view.points.len()
        )
    } else {
        "Points, the largest correction first, rounded; the table beside the program has them in full precision".into()
    };
    let head = [
        "point",
        "line",
        "outcome",
        "frame",
        "tool",
        "dx, mm",
        "dy, mm",
        "dz, mm",
        "correction, mm",
        "turned, °",
        "within (95 %), mm",
    ];
    page.table(&caption, &head, &rows, true);
}
