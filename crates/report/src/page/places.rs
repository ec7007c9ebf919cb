//! Pages of a map, a plan and a prediction.

use super::commands::over_two_axes;
use super::robot::{Stick, Words, corners};
use super::{Page, Report};
use crate::figure::{Plot, escape, quantile, thin};
use crate::{PlanSummary, PositionStatistics, RunRecord, count, significant};
use serde::{Deserialize, Serialize};
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, PostureBuffer};

/// A map of the accuracy as its page shows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MapView {
    /// The robot's name.
    pub robot: String,
    /// Sentences of the terminal.
    pub sentences: Vec<String>,
    /// Places, in the order of the file.
    pub places: Vec<PlaceView>,
}

/// One place of a map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlaceView {
    /// Position of the point, measurement frame, mm.
    pub at_mm: [f64; 3],
    /// Status of the command there.
    pub status: String,
    /// Predicted position error of the nominal robot, mm; null where the place is not reached.
    pub before_mm: Option<f64>,
    /// 95 % bound of the position error of the nominal robot, mm; null where the place is not reached.
    pub before_95_mm: Option<f64>,
    /// 95 % bound of the position error of the compensated robot, mm; null where the place is not reached.
    pub after_95_mm: Option<f64>,
    /// Whether the place is outside of the range of the data of the fit; null where it is not reached.
    pub extrapolates: Option<bool>,
}

/// Builds the page of a map.
pub fn map_report(view: &MapView, run: &RunRecord) -> Report {
    let mut page = Page::new(&format!("{}: accuracy over the workspace", view.robot));
    page.head(run, &[("places", view.places.len().to_string())]);
    page.section("Verdict");
    view.sentences.iter().for_each(|sentence| page.text(sentence));
    let reached: Vec<&PlaceView> = view.places.iter().filter(|place| place.after_95_mm.is_some()).collect();
    let within = |place: &&&PlaceView| place.extrapolates == Some(false);
    let row = |name: &str, places: &[&PlaceView]| {
        let mut cells = vec![name.to_owned(), places.len().to_string()];
        for of in [|p: &PlaceView| p.before_95_mm, |p: &PlaceView| p.after_95_mm] {
            let values: Vec<f64> = places.iter().filter_map(|p| of(p)).collect();
            cells.extend([0.5, 0.95, 1.0].map(|fraction| significant(quantile(values.clone(), fraction), 3)));
        }
        cells
    };
    let inside: Vec<&PlaceView> = reached.iter().filter(within).copied().collect();
    page.table(
        "95 % bounds of the position error, mm: nominal robot (before) and compensated robot (after)",
        &[
            "places",
            "number",
            "before: median",
            "95 % of places",
            "largest",
            "after: median",
            "95 % of places",
            "largest",
        ],
        &[row("reachable", &reached), row("within the data of the fit", &inside)],
        true,
    );
    page.end_of_sheet();
    page.section("Over the workspace");
    let at: Vec<[f64; 3]> = reached.iter().map(|place| place.at_mm).collect();
    let column = |of: fn(&PlaceView) -> Option<f64>| -> Vec<f64> {
        reached.iter().map(|place| of(place).unwrap_or(f64::NAN)).collect()
    };
    over_two_axes(
        &mut page,
        &at,
        [column(|p| p.before_95_mm), column(|p| p.after_95_mm)],
        ["before compensation (95 %)", "after compensation (95 %)"],
        true,
        "RMS of the 95 % bounds in cells over the workspace (measurement frame), both charts in one scale.",
    );
    page.section("Files");
    page.reproduction(run);
    page.finish()
}

/// A plan as its page shows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanView {
    /// The robot's name.
    pub robot: String,
    /// The expected benefit.
    pub summary: PlanSummary,
    /// Names and units of the joints below: degrees or mm.
    pub joints: Vec<String>,
    /// Planned pose measurements, in the order of the file.
    pub poses: Vec<PlannedView>,
}

/// One planned pose measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlannedView {
    /// Joint values, degrees or mm.
    pub joints: Vec<f64>,
    /// Mass carried, kg; null where the plan states none.
    pub payload_kg: Option<f64>,
    /// `new` or `repeat`.
    pub why: String,
    /// Fraction of the expected squared error that it removes, or its discrimination statistic.
    pub worth: f64,
}

/// Builds the page of a plan; `data` has the planned joints.
pub fn plan_report(view: &PlanView, chain: &Chain, data: &Dataset, run: &RunRecord) -> Report {
    let mut page = Page::new(&format!("{}: further measurements", view.robot));
    page.head(run, &[("pose measurements", view.poses.len().to_string())]);
    page.section("Verdict");
    view.summary.to_string().lines().for_each(|line| page.text(line));
    page.end_of_sheet();
    let mut buffer = PostureBuffer::new(chain);
    let stick = |row: usize| {
        let corners = corners(chain, data, row, &mut buffer);
        let point = corners.last().copied().unwrap_or_default();
        Stick {
            corners,
            point,
            errors: Vec::new(),
            moved: Vec::new(),
            label: format!("pose measurement {}", row + 1),
        }
    };
    let list: Vec<Stick> = (0..data.len()).map(stick).collect();
    page.section("Poses");
    page.sticks(&list, &[], &Words::of_poses(list.len()), "Nominal robot in the measurement frame.");
    let mut head = vec!["number"];
    head.extend(view.joints.iter().map(String::as_str));
    head.extend(["payload, kg", "why", "worth"]);
    let row = |(k, pose): (usize, &PlannedView)| {
        let mut cells = vec![k.to_string()];
        cells.extend(pose.joints.iter().map(|v| format!("{v:.2}")));
        cells.push(pose.payload_kg.map_or_else(String::new, |kg| significant(kg, 3)));
        cells.extend([pose.why.clone(), significant(pose.worth, 2)]);
        cells
    };
    let rows: Vec<Vec<String>> = (1..).zip(&view.poses).map(row).collect();
    page.table("Planned pose measurements; the file is to be filled in", &head, &rows, true);
    page.section("Files");
    page.reproduction(run);
    page.finish()
}

/// A prediction as its page shows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PredictionView {
    /// The robot's name.
    pub robot: String,
    /// Predicted rows.
    pub rows: usize,
    /// Of them outside of the range of the data of the fit.
    pub extrapolating: usize,
    /// Errors against the measured positions; null without any.
    pub position: Option<PositionStatistics>,
    /// Of every row: distance within which a new measurement lies with 95 % probability, mm.
    pub within_95_mm: Vec<f64>,
    /// Of every row: distance of the measured position, mm; null where it was not measured.
    pub error_mm: Vec<Option<f64>>,
}

/// Builds the page of a prediction.
pub fn prediction_report(view: &PredictionView, run: &RunRecord) -> Report {
    const DRAWN: usize = 3000;
    let mut page = Page::new(&format!("{}: predicted poses", view.robot));
    page.head(run, &[("rows", view.rows.to_string())]);
    page.section("Verdict");
    let sentence = match view.position {
        Some(s) => format!(
            "Error against the measured positions: RMS {} mm, 95th percentile {} mm, largest {} mm ({}).",
            significant(s.rms_mm, 3),
            significant(s.p95_mm, 3),
            significant(s.max_mm, 3),
            count(s.count, "row")
        ),
        None => format!("{} predicted; none was measured.", count(view.rows, "row")),
    };
    page.raw(&format!("<p class=\"verdict\">{}</p>", escape(&sentence)));
    let pairs =
        view.within_95_mm.iter().zip(&view.error_mm).filter_map(|(within, error)| Some((within, (*error)?)));
    let (inside, measured) =
        pairs.fold((0, 0), |(i, n), (within, error)| (i + usize::from(error <= *within), n + 1));
    if measured > 0 {
        page.text(&format!(
            "{inside} of {} within the stated 95 % distance.",
            if measured == 1 {
                "1 measured row is".to_owned()
            } else {
                format!("{measured} measured rows are")
            }
        ));
    }
    page.text(&match view.extrapolating {
        0 => "All rows are within the range of the data of the fit.".to_owned(),
        n => format!(
            "{} outside of the range of the data of the fit: the model extrapolates there, and the true uncertainty is larger than stated.",
            count(n, "row")
        ),
    });
    page.end_of_sheet();
    page.section("Rows");
    let sizes: Vec<f64> =
        view.error_mm.iter().zip(&view.within_95_mm).map(|(e, w)| e.unwrap_or(0.0).max(*w)).collect();
    let top = sizes.iter().copied().filter(|v| v.is_finite()).fold(1e-9, f64::max);
    let drawn = thin(&sizes, DRAWN, |_| false);
    let mut plot = Plot::new(560.0, 300.0, [1.0, view.rows.max(2) as f64], [0.0, 1.05 * top]).axes(
        "errors and their 95 % bound",
        "row, in the order of the data",
        "mm",
    );
    plot.dots("before dots", drawn.iter().map(|&k| (k as f64 + 1.0, view.within_95_mm[k])));
    plot.dots("after dots", drawn.iter().filter_map(|&k| Some((k as f64 + 1.0, view.error_mm[k]?))));
    page.figure(
        "prediction",
        &plot.finish("Distance of measured from predicted positions, and the distance that holds 95 % of new measurements"),
        "Orange: distance within which a new measurement lies with 95 % probability. Blue: distance of the measured position.",
    );
    page.section("Files");
    page.reproduction(run);
    page.finish()
}
