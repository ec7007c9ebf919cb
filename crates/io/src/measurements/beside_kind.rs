//! Columns that have a meaning beside a column `kind` only: measured numbers, and what a camera on the robot saw.

use super::columns::{Column, Role};
use super::scalars::SCALARS;
use truepose_kinematics::Chain;

/// The column of what a camera on the robot saw, beside a column `kind`.
const POINT_COLUMN: &str = "point";

/// Whether a column of this name has a meaning beside a column `kind`.
pub(super) fn is_numbered(name: &str) -> bool {
    name == POINT_COLUMN || SCALARS.contains(&name)
}

/// A column as it was read; beside a column `kind`, one of measured numbers where its name is one of theirs.
pub(super) fn numbered(
    (column, warning): (Column, Option<String>),
    observed: bool,
    chain: &Chain,
) -> Result<(Column, Option<String>), String> {
    if observed && column.name == POINT_COLUMN && matches!(column.role, Role::Channel(_) | Role::Nothing) {
        return Column::named(&column.header, POINT_COLUMN, (chain, Some(Role::Point)), 0);
    }
    let which = SCALARS.iter().position(|name| *name == column.name);
    let Some(k) = which.filter(|_| observed && matches!(column.role, Role::Channel(_))) else {
        return Ok((column, warning));
    };
    let header = match column.unit_given {
        true => format!("{}[{}]", column.name, column.unit),
        false => column.name.clone(),
    };
    Column::named(&column.header, &header, (chain, Some(Role::Scalar(k))), 0)
}
