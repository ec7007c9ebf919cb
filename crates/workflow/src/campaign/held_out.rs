//! Held-out rows of a search, kind by kind of observation.

use std::collections::{BTreeMap, BTreeSet};
use truepose_discover::Diagnosis;
use truepose_errormodel::Dataset;
use truepose_identify::{Residuals, Touched};
use truepose_kinematics::nalgebra::Vector3;

/// A kind on its held-out rows.
pub(super) struct Held {
    /// `mm` or `px`.
    pub unit: &'static str,
    pub rms: f64,
    pub standstills: usize,
}

/// Each kind on the rows that a search has not seen.
pub(super) fn by_kind(touched: &Touched, data: &Dataset, found: &Diagnosis) -> BTreeMap<String, Held> {
    let mut all: BTreeMap<String, (&'static str, Vec<f64>, BTreeSet<usize>)> = BTreeMap::new();
    let out = &found.after.outliers[1];
    for (k, &row) in found.holdout_rows.iter().enumerate().filter(|(k, _)| !out.contains(k)) {
        let (kind, unit, scale) = of_row(touched, data, row);
        if let Some(distance) = found.after.holdout.distance(k) {
            let (_, errors, standstills) =
                all.entry(kind.to_owned()).or_insert_with(|| (unit, Vec::new(), BTreeSet::new()));
            errors.push(scale * distance);
            standstills.extend(touched.standstills.get(row));
        }
    }
    let held = |(unit, errors, standstills): (&'static str, Vec<f64>, BTreeSet<usize>)| Held {
        unit,
        rms: (errors.iter().map(|v| v * v).sum::<f64>() / errors.len().max(1) as f64).sqrt(),
        standstills: standstills.len(),
    };
    all.into_iter().map(|(kind, of)| (kind, held(of))).collect()
}

/// Kind and unit of a row, and how many of that unit a metre of its residual is.
fn of_row<'a>(touched: &'a Touched, data: &Dataset, row: usize) -> (&'a str, &'static str, f64) {
    match (data.sensor(row), data.ray(row)) {
        (Some(sensor), Some(ray)) => {
            let sensor = &touched.sensors[sensor];
            let pixels = sensor.observation.unit() == "px";
            let (unit, scale) = if pixels { ("px", 1.0) } else { ("mm", 1e3) };
            (sensor.observation.kind(), unit, scale * ray.norm() / sensor.weight)
        }
        _ if data.landmark(row).is_some() => ("same_point", "mm", 1e3),
        _ => ("position", "mm", 1e3),
    }
}

/// The residuals of held-out rows among those of all rows.
pub(super) fn among_all(found: &Diagnosis, rows: usize) -> Residuals {
    let none = Vector3::repeat(f64::NAN);
    let mut all = Residuals { position: vec![none; rows], orientation: vec![None; rows] };
    for (k, &row) in found.holdout_rows.iter().enumerate() {
        all.position[row] = found.after.holdout.position[k];
        all.orientation[row] = found.after.holdout.orientation[k];
    }
    all
}
