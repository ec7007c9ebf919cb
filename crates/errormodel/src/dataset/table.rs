//! Measurements, column by column, in SI units.
//!
//! A row is one target seen at one visit; a visit is one standstill of the robot. What was not measured is
//! NaN in `position` and `None` in `orientation`: files cannot contain a NaN, so that nothing else is.

use super::dwell::Dwell;
use super::record::Record;
use super::schema::Schema;
use crate::ModelError;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Chain, Conditions, Load, Pose, Slot, TargetId};

/// Measured (or to be predicted) rows of one robot. All columns have the same length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Dataset {
    /// Which signals the data carries.
    pub schema: Schema,
    /// One column for each movable joint, rad or m.
    pub joints: Vec<Vec<f64>>,
    /// Measured position of the target in the measurement frame, m; NaN where it was not measured.
    pub position: Vec<[f64; 3]>,
    /// Measured orientation of the tool in the measurement frame, unit quaternion (w, x, y, z).
    pub orientation: Vec<Option<[f64; 4]>>,
    /// Standard deviation of `position` as the instrument states it, m; NaN where it states none.
    pub position_sd: Vec<[f64; 3]>,
    /// Standard deviation of the orientation about x, y, z of the measurement frame, rad; NaN where none is stated.
    pub orientation_sd: Vec<[f64; 3]>,
    /// The measured target; none stands for the tool's origin.
    pub target: Vec<Option<TargetId>>,
    /// The visit of each row, as an index 0… in order of first appearance.
    pub visit: Vec<usize>,
    /// The load of each row.
    pub load: Vec<Load>,
    /// When, s; zero where the data has no time; with `by_order` the number of the pose measurement, 1…
    pub time: Vec<f64>,
    /// Whether the data has no time, and the order of its rows stands for it ([`Dataset::ordered`]).
    pub by_order: bool,
    /// One column for each movable joint: the direction in which it last moved, −1, 0 or +1.
    pub approach: Vec<Vec<f64>>,
    /// One column for each channel of the schema.
    pub channels: Vec<Vec<f64>>,
    /// What tells dwells and configurations apart.
    pub dwell: Dwell,
    /// The line of the file on which each row stood, for messages; empty when the data came from no file.
    pub line: Vec<u64>,
    /// The order of poses of the whole record, where these rows are a part of it; none where they are the whole.
    pub record: Option<Record>,
}

/// Which three components of a position (of one number along a direction: the first), and whether the orientation, were measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Seen {
    /// x, y, z.
    pub position: [bool; 3],
    /// All three components of the orientation.
    pub orientation: bool,
}

impl Seen {
    /// How many numbers of a pose were measured, 0…6.
    pub fn count(&self) -> usize {
        self.components() + if self.orientation { 3 } else { 0 }
    }

    /// How many of them are of the position, 0…3.
    pub fn components(&self) -> usize {
        self.position.iter().filter(|&&seen| seen).count()
    }
}

impl Dataset {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.visit.len()
    }

    /// True without any row.
    pub fn is_empty(&self) -> bool {
        self.visit.is_empty()
    }

    /// What was measured in a row.
    pub fn seen(&self, row: usize) -> Seen {
        let position = match self.ray(row) {
            Some(_) => [true, false, false],
            None => self.position[row].map(|v| !v.is_nan()),
        };
        Seen { position, orientation: self.orientation[row].is_some() }
    }

    /// The measured position, m, with NaN for what was not measured.
    pub fn measured_position(&self, row: usize) -> Vector3<f64> {
        Vector3::from(self.position[row])
    }

    /// The measured orientation as a rotation matrix.
    pub fn measured_rotation(&self, row: usize) -> Option<Matrix3<f64>> {
        self.orientation[row].map(Pose::rotation_from_quaternion)
    }

    /// The column to which a signal was resolved.
    pub(crate) fn slot(&self, slot: Slot) -> &[f64] {
        match slot {
            Slot::Time => &self.time,
            Slot::Approach(k) => &self.approach[k],
            Slot::Channel(k) => &self.channels[k],
        }
    }

    /// Writes the inputs of a row into `into`, without allocating when it already has the right shape.
    pub fn conditions_into(&self, row: usize, into: &mut Conditions) {
        into.joints.resize(self.joints.len(), 0.0);
        into.approach.resize(self.approach.len(), 0.0);
        into.channels.resize(self.channels.len(), 0.0);
        for (value, column) in into.joints.iter_mut().zip(&self.joints) {
            *value = column[row];
        }
        for (value, column) in into.approach.iter_mut().zip(&self.approach) {
            *value = column[row];
        }
        for (value, column) in into.channels.iter_mut().zip(&self.channels) {
            *value = column[row];
        }
        into.tool = self.tool(row);
        into.load = self.load[row];
        into.time = self.time[row];
    }

    /// The inputs of a row.
    pub fn conditions(&self, row: usize) -> Conditions {
        let mut conditions = Conditions::default();
        self.conditions_into(row, &mut conditions);
        conditions
    }

    /// Checks that every column fits the robot and all have one length.
    ///
    /// # Errors
    /// [`ModelError::Shape`] names the column that does not fit.
    pub fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        let rows = self.len();
        let shape = |what: &'static str, have: usize, need: usize| {
            if have == need { Ok(()) } else { Err(ModelError::Shape { what, have, need }) }
        };
        shape("joint columns", self.joints.len(), chain.movable().len())?;
        shape("approach columns", self.approach.len(), chain.movable().len())?;
        shape("channels", self.channels.len(), self.schema.channels.len())?;
        for column in self.joints.iter().chain(&self.approach).chain(&self.channels) {
            shape("rows of a column", column.len(), rows)?;
        }
        shape("positions", self.position.len(), rows)?;
        shape("orientations", self.orientation.len(), rows)?;
        shape("position deviations", self.position_sd.len(), rows)?;
        shape("orientation deviations", self.orientation_sd.len(), rows)?;
        shape("targets", self.target.len(), rows)?;
        shape("loads", self.load.len(), rows)?;
        shape("times", self.time.len(), rows)?;
        if let Some(&target) = self.target.iter().flatten().find(|t| t.0 >= chain.targets().len()) {
            return Err(ModelError::Shape {
                what: "declared targets",
                have: chain.targets().len(),
                need: target.0 + 1,
            });
        }
        Ok(())
    }
}
