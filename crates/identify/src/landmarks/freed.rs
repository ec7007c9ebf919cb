//! What sensors take as given, as further unknowns: columns that a test sets beside those of a fit.

use super::carried::Carried;
use super::sensors::Sensors;
use truepose_errormodel::Column;
use truepose_errormodel::observation::Reading;
use truepose_kinematics::Pose;

/// What a sensor takes as given.
#[derive(Debug, Clone)]
pub struct Freed {
    /// Number of the sensor.
    pub sensor: usize,
    /// What it is, in words.
    pub what: &'static str,
    /// The further unknowns.
    pub columns: Vec<Column>,
    /// Of each of its rows: what a unit of them does to its number, weighted as the row is.
    pub(super) rows: Vec<(usize, Vec<f64>)>,
}

/// Of all sensors, with the tool at these poses, on a robot of this length, m.
pub(super) fn freed(sensors: &Sensors, poses: &[Pose], carried: &Carried, length: f64) -> Vec<Freed> {
    let mut all = Vec::new();
    let mut reading = Reading::default();
    for (sensor, found) in sensors.found.iter().enumerate() {
        let own = found.observation.unknowns(&found.name, length);
        for (what, more) in found.observation.freed() {
            let columns = more.unknowns(&found.name, length);
            let further: Vec<usize> =
                (0..columns.len()).filter(|&k| own.iter().all(|own| own.name != columns[k].name)).collect();
            let mut rows = Vec::new();
            for &row in &found.rows {
                let at = carried.seen_from(row, &poses[row]).unwrap_or(poses[row]);
                if more.read(&at, &mut reading) {
                    let by = &reading.by_own[sensors.which(row)];
                    rows.push((row, further.iter().map(|&k| found.weight * by[k]).collect()));
                }
            }
            let columns = further.iter().map(|&k| columns[k].clone()).collect();
            all.push(Freed { sensor, what, columns, rows });
        }
    }
    all
}
