//! Rows in which two points of one robot met: two arms that touch, a hand that touches the torso.
//!
//! Which point the target of a row met is a channel, [`MEETS`]: 0 where it met none, 2 t + 1 for target t, 2 k + 2 for the origin of tool k.

use super::table::Dataset;
use crate::aim::{Aim, RobotPoint};
use truepose_kinematics::{TargetId, ToolId};

/// The channel of the point that was met. No file can have a column of this name, and no cause is looked for in it.
pub const MEETS: &str = "meets~";

impl Dataset {
    /// The point that the target of a row met; none where it met none.
    pub fn meets(&self, row: usize) -> Option<RobotPoint> {
        // Numbers are small and whole.
        let number = (self.schema.channel(MEETS).map(|k| self.channels[k][row])? as usize).checked_sub(1)?;
        Some(match number % 2 {
            0 => RobotPoint::Target(TargetId(number / 2)),
            _ => RobotPoint::Tool(ToolId(number / 2)),
        })
    }

    /// Whether points met in some row.
    pub(crate) fn any_met(&self) -> bool {
        self.schema.channel(MEETS).is_some()
    }

    /// What the position of a row is of.
    #[inline]
    pub fn aim(&self, row: usize) -> Aim {
        Aim { target: self.target[row], met: self.meets(row) }
    }

    /// Whether a row measured all of the position of one point.
    pub fn whole_position(&self, row: usize) -> bool {
        self.seen(row).position == [true; 3] && self.meets(row).is_none()
    }

    /// With these points, one a row; none where nothing met anything.
    pub fn set_meets(&mut self, of_row: Option<&[Option<RobotPoint>]>) {
        let number = |point: &Option<RobotPoint>| match point {
            None => 0,
            Some(RobotPoint::Target(target)) => 2 * target.0 + 1,
            Some(RobotPoint::Tool(tool)) => 2 * tool.0 + 2,
        };
        let numbers = |of: &[Option<RobotPoint>]| of.iter().map(|point| number(point) as f64).collect();
        self.set_numbers(MEETS, of_row.map(numbers));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DatasetBuilder, Measurement, is_derived};
    use truepose_kinematics::samples;

    #[test]
    fn what_a_row_met_is_kept() {
        let chain = samples::ur10();
        let mut builder = DatasetBuilder::new(&chain);
        for k in 0..3 {
            builder.push(Measurement::at([0.1 * f64::from(k); 6])).unwrap();
        }
        let mut data = builder.finish();
        assert_eq!(data.meets(1), None);
        let met = [None, Some(RobotPoint::Target(TargetId(2))), Some(RobotPoint::Tool(ToolId(0)))];
        data.set_meets(Some(&met));
        assert_eq!([0, 1, 2].map(|row| data.meets(row)), met);
        assert!(is_derived(MEETS));
        data.set_meets(None);
        assert!(data.schema.channel(MEETS).is_none());
    }
}
