//! The rows of the data that a fit file holds, format 1: one object a row, in SI units; what was not measured is `null` or absent.

use serde::{Deserialize, Serialize};
use truepose_errormodel::{Channel, Dataset, Sample, Schema};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Load, Payload, TargetId, Wrench};

/// Quaternions are of length one to this.
const UNIT: f64 = 1e-6;

/// What the rows have in common.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct SampleOfV1 {
    /// How many rows they were drawn from.
    pub rows: usize,
    #[serde(default)]
    pub channels: Vec<Channel>,
    #[serde(default)]
    pub time: bool,
    #[serde(default)]
    pub load: bool,
    #[serde(default)]
    pub approach: bool,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct RowV1 {
    joints: Vec<f64>,
    position: [Option<f64>; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    orientation: Option<[f64; 4]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    target: Option<usize>,
    /// Mass, kg, and its centre, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    payload: Option<[f64; 4]>,
    /// Force, N, and moment, N·m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    wrench: Option<[f64; 6]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    time: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    approach: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    channels: Vec<f64>,
}

/// As a file has it; none of a sample without rows.
pub(super) fn written(sample: &Sample) -> (Option<SampleOfV1>, Vec<RowV1>) {
    let data = sample.rows();
    if data.is_empty() {
        return (None, Vec::new());
    }
    let at = |columns: &[Vec<f64>], row: usize| columns.iter().map(|column| column[row]).collect();
    let Schema { channels, time, load, approach } = data.schema.clone();
    let rows = (0..data.len()).map(|row| RowV1 {
        joints: at(&data.joints, row),
        position: data.position[row].map(|v| (!v.is_nan()).then_some(v)),
        orientation: data.orientation[row],
        target: data.target[row].map(|target| target.0),
        payload: match data.load[row] {
            Load::Payload(p) => Some([p.mass, p.com.x, p.com.y, p.com.z]),
            _ => None,
        },
        wrench: match data.load[row] {
            Load::Wrench(w) => Some([w.force.x, w.force.y, w.force.z, w.moment.x, w.moment.y, w.moment.z]),
            _ => None,
        },
        time: time.then(|| data.time[row]),
        approach: data.approach.iter().any(|column| column[row] != 0.0).then(|| at(&data.approach, row)),
        channels: at(&data.channels, row),
    });
    (Some(SampleOfV1 { rows: sample.drawn_from(), channels, time, load, approach }), rows.collect())
}

/// The sample that a file holds, of a robot with so many moving joints and targets.
///
/// # Errors
/// What in the rows does not fit the robot.
pub(super) fn read(
    of: SampleOfV1,
    rows: Vec<RowV1>,
    joints: usize,
    targets: usize,
) -> Result<Sample, String> {
    let n = rows.len();
    let SampleOfV1 { rows: drawn_from, channels, time, load, approach } = of;
    let mut data = Dataset {
        joints: vec![Vec::with_capacity(n); joints],
        approach: vec![Vec::with_capacity(n); joints],
        channels: vec![Vec::with_capacity(n); channels.len()],
        position_sd: vec![[f64::NAN; 3]; n],
        orientation_sd: vec![[f64::NAN; 3]; n],
        visit: (0..n).collect(),
        schema: Schema { channels, time, load, approach },
        ..Dataset::default()
    };
    for (number, row) in (1..).zip(rows) {
        let sides = row.approach.unwrap_or_else(|| vec![0.0; joints]);
        let fits = row.joints.len() == joints
            && sides.len() == joints
            && row.channels.len() == data.channels.len()
            && row.target.is_none_or(|target| target < targets);
        if !fits {
            return Err(format!(
                "row {number} of the sample is not of the robot of the file; the file is damaged"
            ));
        }
        if let Some([mass, ..]) = row.payload.filter(|[mass, ..]| *mass < 0.0) {
            return Err(format!(
                "`sample[{}].payload` is {mass} kg, below zero; the file is damaged",
                number - 1
            ));
        }
        if let Some(q) = row.orientation.filter(|q| (q.iter().map(|v| v * v).sum::<f64>() - 1.0).abs() > UNIT)
        {
            return Err(format!(
                "`sample[{}].orientation` {q:?} is no unit quaternion; the file is damaged",
                number - 1
            ));
        }
        let lists = [
            (&mut data.joints, &row.joints),
            (&mut data.approach, &sides),
            (&mut data.channels, &row.channels),
        ];
        for (columns, values) in lists {
            columns.iter_mut().zip(values).for_each(|(column, &value)| column.push(value));
        }
        data.position.push(row.position.map(|v| v.unwrap_or(f64::NAN)));
        data.orientation.push(row.orientation);
        data.target.push(row.target.map(TargetId));
        data.time.push(row.time.unwrap_or(0.0));
        data.load.push(match (row.wrench, row.payload) {
            (Some([fx, fy, fz, mx, my, mz]), _) => {
                Load::Wrench(Wrench { force: Vector3::new(fx, fy, fz), moment: Vector3::new(mx, my, mz) })
            }
            (None, Some([mass, x, y, z])) => Load::Payload(Payload { mass, com: Vector3::new(x, y, z) }),
            (None, None) => Load::None,
        });
    }
    Ok(Sample::stored(data, drawn_from))
}
