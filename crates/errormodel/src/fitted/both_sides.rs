//! Rows in which two points of the robot met, as a row of each point.

use crate::{Dataset, FittedModel, ModelError};
use truepose_kinematics::{Conditions, Load, ToolId};

/// The rows with every contact as two rows, one of each point, where this robot has them: m, measurement frame.
pub(super) fn both_sides(robot: &FittedModel, rows: &Dataset) -> Result<Dataset, ModelError> {
    let sides = |row: usize| if rows.meets(row).is_some() { 2 } else { 1 };
    let source: Vec<usize> = (0..rows.len()).flat_map(|row| std::iter::repeat_n(row, sides(row))).collect();
    if source.len() == rows.len() {
        return Ok(rows.clone());
    }
    let mut both = rows.select(&source);
    let mut tools: Vec<ToolId> = source.iter().map(|&row| rows.tool(row)).collect();
    for at in 1..source.len() {
        if let Some(met) = rows.meets(source[at]).filter(|_| source[at] == source[at - 1]) {
            both.target[at] = met.target();
            tools[at] = met.tool(robot.chain());
            // What the row carries is on its own tool.
            both.load[at] = Load::None;
        }
    }
    both.set_tools(robot.chain(), &tools);
    let mut predictor = robot.bind(&both.schema)?;
    let mut conditions = Conditions::default();
    for at in 0..both.len() {
        if both.meets(at).is_some() {
            both.conditions_into(at, &mut conditions);
            both.position[at] = predictor.predict(&conditions, both.target[at]).translation.into();
        }
    }
    Ok(both)
}
