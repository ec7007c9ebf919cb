//! A data set from single measurements, each checked when it is added.

use super::approach::approach_from_order;
use super::dwell::{Dwell, DwellTolerance};
use super::measurement::Measurement;
use super::schema::{Channel, Schema};
use super::table::Dataset;
use super::visits::visits_from_rows;
use crate::error::ModelError;
use std::collections::HashMap;
use truepose_kinematics::{Chain, Load, ToolId};

/// Collects measurements of one robot into a [`Dataset`].
///
/// ```
/// use truepose_errormodel::{DatasetBuilder, Measurement};
/// use truepose_kinematics::samples;
///
/// let chain = samples::ur10();
/// let mut builder = DatasetBuilder::new(&chain);
/// builder.push(Measurement::at([0.0, -1.2, 1.5, 0.0, 0.3, 0.0]).position([0.7, 0.2, 0.4]))?;
/// builder.push(Measurement::at([0.4, -1.0, 1.1, 0.2, 0.3, 0.0]).position([0.8, 0.5, 0.6]))?;
/// let data = builder.finish();
/// assert_eq!(data.len(), 2);
/// # Ok::<(), truepose_errormodel::ModelError>(())
/// ```
#[derive(Debug, Clone)]
pub struct DatasetBuilder {
    movable: usize,
    chain: Chain,
    tools: Vec<ToolId>,
    data: Dataset,
    /// The number of each visit that was given, and its index.
    visits: HashMap<u64, usize>,
    /// Whether rows have a visit, a time, directions of approach; none before the first row.
    given: Option<[bool; 3]>,
}

/// What is given for all rows or for none, in the order of `given`.
const SIGNALS: [&str; 3] = ["visit", "time", "approach"];

impl DatasetBuilder {
    /// Of this robot, with the default tolerance of a dwell.
    pub fn new(chain: &Chain) -> Self {
        let movable = chain.movable().len();
        let data = Dataset {
            dwell: Dwell::of(chain, DwellTolerance::default()),
            joints: vec![Vec::new(); movable],
            approach: vec![Vec::new(); movable],
            ..Dataset::default()
        };
        DatasetBuilder {
            movable,
            chain: chain.clone(),
            tools: Vec::new(),
            data,
            visits: HashMap::new(),
            given: None,
        }
    }

    /// With another tolerance of dwells and configurations.
    pub fn dwell(mut self, dwell: Dwell) -> Self {
        self.data.dwell = dwell;
        self
    }

    /// With these channels: every measurement has one value for each.
    pub fn channels(mut self, channels: Vec<Channel>) -> Self {
        self.data.channels = vec![Vec::new(); channels.len()];
        self.data.schema.channels = channels;
        self
    }

    /// Adds a measurement as the next row.
    ///
    /// # Errors
    /// [`ModelError::Measurement`] with the number of the row when it does not fit the robot, a value is not finite, or it lacks (or has) a
    /// visit, time or approach that the rows before have (or lack); the builder is then as it was.
    pub fn push(&mut self, row: Measurement) -> Result<(), ModelError> {
        let given = [row.visit.is_some(), row.time.is_some(), row.approach.is_some()];
        self.check(&row, given).map_err(|reason| ModelError::Measurement { row: self.data.len(), reason })?;
        self.given = Some(given);
        let data = &mut self.data;
        let put = |columns: &mut [Vec<f64>], values: &[f64]| {
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(*value));
        };
        put(&mut data.joints, &row.joints);
        put(&mut data.channels, &row.channels);
        put(&mut data.approach, &row.approach.unwrap_or_else(|| vec![0.0; self.movable]));
        data.position.push(row.position);
        data.orientation.push(row.orientation);
        data.position_sd.push(row.position_sd);
        data.orientation_sd.push(row.orientation_sd);
        data.target.push(row.target);
        self.tools.push(row.tool);
        data.schema.load |= row.load != Load::None;
        data.load.push(row.load);
        data.time.push(row.time.unwrap_or(0.0));
        let next = self.visits.len();
        data.visit.push(row.visit.map_or(0, |number| *self.visits.entry(number).or_insert(next)));
        Ok(())
    }

    fn check(&self, row: &Measurement, given: [bool; 3]) -> Result<(), String> {
        let lengths = [
            ("joint values", row.joints.len(), self.movable),
            ("channel values", row.channels.len(), self.data.schema.channels.len()),
            ("directions of approach", row.approach.as_ref().map_or(self.movable, Vec::len), self.movable),
        ];
        for (what, have, need) in lengths {
            if have != need {
                return Err(format!("{have} {what} where {need} are needed"));
            }
        }
        let before = self.given.unwrap_or(given);
        if let Some(k) = (0..SIGNALS.len()).find(|&k| before[k] != given[k]) {
            let has = if given[k] { "has" } else { "lacks" };
            return Err(format!("it {has} a value of `{}`, unlike the rows before it", SIGNALS[k]));
        }
        if let Some(value) = row.joints.iter().chain(&row.channels).chain(&row.time).find(|v| !v.is_finite())
        {
            return Err(format!("a joint value, channel or time is {value}, not a finite number"));
        }
        if let Some(value) =
            row.position.iter().chain(row.orientation.iter().flatten()).find(|v| v.is_infinite())
        {
            return Err(format!("a measured component is {value}"));
        }
        if let Some(q) = row.orientation
            && !(1.0 - UNIT..1.0 + UNIT).contains(&q.iter().map(|v| v * v).sum())
        {
            return Err(format!("the orientation {q:?} is not a unit quaternion"));
        }
        let stated = row.position_sd.iter().chain(&row.orientation_sd);
        if let Some(sd) = stated.filter(|sd| !sd.is_nan()).find(|&&sd| !(sd > 0.0 && sd.is_finite())) {
            return Err(format!("a stated standard deviation is {sd}, not positive and finite"));
        }
        if let Some(direction) = row.approach.iter().flatten().find(|d| ![-1.0, 0.0, 1.0].contains(*d)) {
            return Err(format!("a direction of approach is -1, 0 or 1, not {direction}"));
        }
        match row.target {
            Some(target) if target.0 >= self.chain.targets().len() => {
                let has = self.chain.targets().len();
                Err(format!("target {} is measured, but the robot has {has}", target.0))
            }
            _ if row.tool.0 >= self.chain.tools().len() => {
                let has = self.chain.tools().len();
                Err(format!("it is of tool {}, but the robot has {has}", row.tool.0))
            }
            _ => Ok(()),
        }
    }

    /// The data set. Without visit numbers consecutive rows of one dwell are one visit; without directions of approach they follow from the
    /// order of the visits.
    pub fn finish(self) -> Dataset {
        let mut data = self.data;
        let [visit, time, approach] = self.given.unwrap_or([true, false, true]);
        data.schema = Schema { time, approach: true, ..data.schema };
        data.set_tools(&self.chain, &self.tools);
        if !visit {
            data.visit = visits_from_rows(&data);
        }
        if !approach {
            data.approach = approach_from_order(&data);
        }
        data
    }
}

/// By how much the square of a unit quaternion's length may differ from one: seven digits, as files have them.
const UNIT: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::{Payload, TargetId, samples};

    const Q: [f64; 6] = [0.1, -1.2, 1.3, 0.4, 0.5, 0.6];

    #[test]
    fn rows_become_columns() {
        let chain = samples::ur10();
        let heated = Channel { name: "T".into(), unit: "degC".into(), temperature: true };
        let mut builder = DatasetBuilder::new(&chain).channels(vec![heated]);
        let load = Load::Payload(Payload { mass: 5.0, com: [0.0; 3].into() });
        for (row, number) in [7_u64, 7, 3].into_iter().enumerate() {
            let mut q = Q;
            q[0] += number as f64;
            let row = Measurement::at(q).position([row as f64, 0.0, 1.0]).visit(number).time(row as f64);
            builder.push(row.load(load).channels([20.0])).unwrap();
        }
        let data = builder.finish();
        data.validate(&chain).unwrap();
        assert_eq!(data.visit, [0, 0, 1]);
        assert_eq!((data.schema.time, data.schema.load, data.schema.approach), (true, true, true));
        assert_eq!(data.position[2].map(f64::to_bits), [2.0_f64, 0.0, 1.0].map(f64::to_bits));
        assert_eq!(data.channels[0].len(), 3);
        // The third row was measured after joint 1 had moved back by 4 rad.
        assert!(data.approach[0][2] < 0.0 && data.approach[1][2].abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn rows_without_a_number_are_grouped_by_dwell() {
        let chain = samples::ur10();
        let mut builder = DatasetBuilder::new(&chain);
        let mut moved = Q;
        moved[2] += 0.1;
        for q in [Q, Q, moved] {
            builder.push(Measurement::at(q).position([0.5, 0.2, 0.3])).unwrap();
        }
        assert_eq!(builder.finish().visit, [0, 0, 1]);
    }

    #[test]
    fn what_does_not_fit_is_refused_with_its_row_and_leaves_no_trace() {
        let chain = samples::ur10();
        let mut builder = DatasetBuilder::new(&chain);
        builder.push(Measurement::at(Q).position([0.5, 0.2, 0.3])).unwrap();
        let row = || Measurement::at(Q);
        for (wrong, words) in [
            (Measurement::at([0.0; 5]), "5 joint values where 6 are needed"),
            (row().channels([1.0]), "1 channel values where 0 are needed"),
            (row().visit(1), "it has a value of `visit`, unlike the rows before it"),
            (row().time(1.0), "`time`"),
            (Measurement::at([f64::NAN; 6]), "NaN, not a finite number"),
            (row().position([f64::INFINITY, 0.0, 0.0]), "a measured component is inf"),
            (row().orientation([0.5; 4].map(|v: f64| v * 1.1)), "not a unit quaternion"),
            (row().position_sd([0.0; 3]), "standard deviation is 0"),
            (row().target(TargetId(9)), "target 9"),
        ] {
            let error = builder.push(wrong).unwrap_err().to_string();
            assert!(error.starts_with("measurement 1: ") && error.contains(words), "{error}");
        }
        let data = builder.finish();
        data.validate(&chain).unwrap();
        assert_eq!(data.len(), 1);
    }
}
