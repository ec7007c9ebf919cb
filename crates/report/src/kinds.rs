//! Kinds of observation: what each leaves in its own unit, and how much of the fit it determines.

use crate::document::Document;
use crate::layout::Alignment;
use crate::observers::{SuspectSummary, sentences};
use crate::significant;
use serde::{Deserialize, Serialize};
use truepose_errormodel::Dataset;
use truepose_identify::{Residuals, Touched};

/// A campaign of several kinds of observation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KindsSummary {
    /// Each kind.
    pub kinds: Vec<KindSummary>,
    /// What was observed by numbers, as it was found.
    pub sensors: Vec<SensorSummary>,
    /// What the data leaves open.
    pub remarks: Vec<String>,
    /// Sensors, tables and anchors that are not what they were taken for.
    #[serde(default)]
    pub suspects: Vec<SuspectSummary>,
}

/// One kind of observation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KindSummary {
    /// `position`, `pose`, `same_point`, `distance`, `plane` …
    pub kind: String,
    /// Its rows.
    pub rows: usize,
    /// Unit of the following: `mm` (of a position and a touched point the 3-D distance) or `px`.
    pub unit: String,
    /// RMS with errors of the installation alone: base, tool, targets, sensors and landmarks; null where it was not worked out.
    pub before: Option<f64>,
    /// RMS with the fit.
    pub after: f64,
    /// RMS by fits that have not seen the row; null where nothing was left out.
    pub held_out: Option<f64>,
    /// Standard deviation of one number as the fit weighs it; null of positions and touched points.
    pub sd: Option<f64>,
    /// Share of the unknowns that its rows determine (their leverage).
    pub share: f64,
}

/// A sensor, an anchor, a plane, a sphere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SensorSummary {
    /// Its name.
    pub name: String,
    /// How it is observed.
    pub kind: String,
    /// Its rows.
    pub rows: usize,
    /// What is known of it after the fit: name, value, unit (mm, 1).
    pub values: Vec<(String, f64, String)>,
    /// Half the 95 % interval of each of its unknowns that the fit has found: name, value, unit (mm, mrad, px, 1).
    #[serde(default)]
    pub within_95: Vec<(String, f64, String)>,
    /// RMS of what its rows leave, in the unit of its kind.
    pub rms: f64,
}

/// Of a normal distribution, 95 % lie within so many standard deviations.
const WITHIN_95: f64 = 1.96;

/// Half the intervals of a sensor's unknowns, in units for people.
fn within_95(sensor: &truepose_identify::SensorFound, sd: &[f64]) -> Vec<(String, f64, String)> {
    let unknowns = sensor.observation.unknowns(&sensor.name, 1.0);
    let found = unknowns.iter().zip(sd).filter(|(_, sd)| **sd > 0.0);
    let one = |(column, sd): (&truepose_errormodel::Column, &f64)| {
        let (scale, unit) = match column.unit.as_str() {
            "m" => (1e3, "mm"),
            "rad" => (1e3, "mrad"),
            unit => (1.0, unit),
        };
        (column.name.clone(), WITHIN_95 * scale * sd, unit.to_owned())
    };
    found.map(one).collect()
}

impl KindsSummary {
    /// Of a fit of these rows; `moved` is how far it has moved the unknowns of each sensor, and their standard deviations; `shares` is the leverage of
    /// each row.
    pub fn new(
        found: &Touched,
        (moved, uncertain): (&[Vec<f64>], &[Vec<f64>]),
        data: &Dataset,
        (before, after, held_out): (Option<&Residuals>, &Residuals, Option<&Residuals>),
        shares: &[f64],
    ) -> Self {
        let kind_of = |row: usize| -> &str {
            match (data.sensor(row), data.landmark(row), data.seen(row).orientation) {
                (Some(sensor), ..) => found.sensors.get(sensor).map_or("", |s| s.observation.kind()),
                (None, Some(_), _) => "same_point",
                (None, None, true) => "pose",
                (None, None, false) => "position",
            }
        };
        // Residuals are metres along the direction of a row; its own unit is as many to the metre as its derivative says.
        let per_metre = |row: usize| match (data.sensor(row), data.ray(row)) {
            (Some(sensor), Some(ray)) => {
                let sensor = &found.sensors[sensor];
                let scale = if sensor.observation.unit() == "px" { 1.0 } else { 1e3 };
                scale * ray.norm() / sensor.weight
            }
            _ => 1e3,
        };
        let rms = |rows: &[usize], of: &Residuals| {
            let left: Vec<f64> =
                rows.iter().filter_map(|&row| Some(of.distance(row)? * per_metre(row))).collect();
            (left.iter().map(|v| v * v).sum::<f64>() / left.len().max(1) as f64).sqrt()
        };
        let whole = |of: &&Residuals| of.position.len() == data.len();
        let mut names: Vec<&str> = Vec::new();
        for row in (0..data.len()).filter(|&row| data.seen(row).count() > 0) {
            if !names.contains(&kind_of(row)) {
                names.push(kind_of(row));
            }
        }
        let kinds = names.into_iter().map(|kind| {
            let rows: Vec<usize> =
                (0..data.len()).filter(|&row| data.seen(row).count() > 0 && kind_of(row) == kind).collect();
            let sensor = found.sensors.iter().find(|sensor| sensor.observation.kind() == kind);
            let pixels = sensor.is_some_and(|sensor| sensor.observation.unit() == "px");
            let numbers = sensor.map_or(1, |sensor| sensor.observation.numbers());
            KindSummary {
                kind: kind.into(),
                rows: rows.len() / numbers,
                unit: if pixels { "px" } else { "mm" }.into(),
                before: before.filter(whole).map(|of| rms(&rows, of)),
                after: rms(&rows, after),
                held_out: held_out.filter(whole).map(|of| rms(&rows, of)),
                sd: sensor.map(|sensor| if pixels { sensor.sd } else { 1e3 * sensor.sd }),
                share: rows.iter().filter_map(|&row| shares.get(row)).sum(),
            }
        });
        let sensor = |(k, sensor): (usize, &truepose_identify::SensorFound)| {
            let at =
                moved.get(k).map_or_else(|| sensor.observation.clone(), |by| sensor.observation.moved(by));
            let value = |(name, value, unit): (&str, f64, &str)| match unit {
                "m" => (name.to_owned(), 1e3 * value, "mm".to_owned()),
                unit => (name.to_owned(), value, unit.to_owned()),
            };
            let rows: Vec<usize> = (0..data.len()).filter(|&row| data.sensor(row) == Some(k)).collect();
            SensorSummary {
                name: sensor.name.clone(),
                kind: sensor.observation.kind().into(),
                rows: rows.len() / sensor.observation.numbers(),
                values: at.values().into_iter().map(value).collect(),
                within_95: within_95(sensor, uncertain.get(k).map_or(&[], Vec::as_slice)),
                rms: rms(&rows, after),
            }
        };
        KindsSummary {
            kinds: kinds.collect(),
            sensors: found.sensors.iter().enumerate().map(sensor).collect(),
            remarks: found.remarks.clone(),
            suspects: Vec::new(),
        }
    }

    /// What each kind leaves, in one sentence.
    pub(crate) fn verdict(&self) -> String {
        let held = self.kinds.iter().all(|kind| kind.held_out.is_some());
        let rows = if held { "on held-out rows" } else { "on the rows of the fit (no rows were held out)" };
        let each = |kind: &KindSummary| {
            let after = significant(kind.held_out.filter(|_| held).unwrap_or(kind.after), 3);
            format!("{} {after} {} ({})", kind.kind, kind.unit, crate::count(kind.rows, "row"))
        };
        let kinds: Vec<String> = self.kinds.iter().map(each).collect();
        format!("Residual by kind of observation (RMS), {rows}: {}.", kinds.join(", "))
    }

    const HEAD: [&str; 8] = ["kind", "rows", "unit", "installation", "fit", "held out", "noise", "share"];
    const LEGEND: &str = "share: of the unknowns, determined by the rows of the kind (leverage); noise: standard deviation of one number";

    /// A row a kind, under [`Self::HEAD`].
    fn cells(&self) -> Vec<Vec<String>> {
        let number = |value: Option<f64>| value.map_or_else(|| "-".into(), |v| significant(v, 3));
        let row = |kind: &KindSummary| {
            vec![
                kind.kind.clone(),
                kind.rows.to_string(),
                kind.unit.clone(),
                number(kind.before),
                number(Some(kind.after)),
                number(kind.held_out),
                number(kind.sd),
                format!("{:.0} %", 100.0 * kind.share),
            ]
        };
        self.kinds.iter().map(row).collect()
    }

    /// What each kind leaves, what was observed as it was found, and what is wrong with it; `remark` follows the caption.
    pub(crate) fn show(&self, remark: &str, document: &mut Document) {
        use Alignment::{Left, Right};
        let columns = [Left, Right, Left, Right, Right, Right, Right, Right];
        let caption = format!("kinds of observation, RMS{remark}");
        document.table(caption, &Self::HEAD, &columns, self.cells());
        document.note(Self::LEGEND);
        for sensor in &self.sensors {
            let value = |(name, value, unit): &(String, f64, String)| match unit.as_str() {
                "1" => format!("{name} {value:.5}"),
                unit => format!("{name} {value:.3} {unit}"),
            };
            let values: Vec<String> = sensor.values.iter().map(value).collect();
            document.note(format!("{} {}: {}", sensor.kind, sensor.name, values.join(", ")));
            let within = |(name, half, unit): &(String, f64, String)| {
                format!("{name} ± {} {unit}", significant(*half, 2))
            };
            let within: Vec<String> = sensor.within_95.iter().map(within).collect();
            if !within.is_empty() {
                document.note(format!("  95 %: {}", within.join(", ")));
            }
        }
        document.sentence(&sentences(&self.suspects));
    }
}
