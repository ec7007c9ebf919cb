//! `[[targets]]` of a robot description.

use super::names::cell_problem;
use super::{MOST_TARGETS, tree};
use crate::toml_tree::{Table, Value};
use crate::{IoError, Unit};
use truepose_kinematics::Target;
use truepose_kinematics::nalgebra::Vector3;

/// The targets of a description, on these tools; every error joins the others.
pub(super) fn read(
    value: &Value<'_>,
    length: &Unit,
    tools: &[String],
    errors: &mut Vec<IoError>,
) -> Result<Vec<Target>, IoError> {
    let mut targets: Vec<Target> = Vec::new();
    let tables = value.tables("targets")?;
    if let Some(table) = tables.get(MOST_TARGETS) {
        return Err(table.error(format!("a robot has at most {MOST_TARGETS} targets")));
    }
    for table in &tables {
        targets.extend(target(table, length, &targets, tools).map_err(|error| errors.push(error)).ok());
    }
    Ok(targets)
}

fn target(table: &Table<'_>, length: &Unit, others: &[Target], tools: &[String]) -> Result<Target, IoError> {
    table.only(&["name", "xyz", "known", "tool"])?;
    let name = table.require("name")?;
    if let Some(problem) = cell_problem(name.string()?) {
        return Err(name.error(problem));
    }
    let word = name.string()?;
    if others.iter().any(|other| other.name == word) {
        return Err(name.error(format!("two targets have the name `{word}`; names must be different")));
    }
    let known = table.get("known").map_or(Ok(true), |value| value.boolean())?;
    let position = match table.get("xyz") {
        Some(value) => Vector3::from(value.numbers::<3>()?.map(|v| length.to_si(v))),
        None if !known => Vector3::zeros(),
        None => {
            return Err(table.error(format!("{} lacks `xyz`; add it, or `known = false`", table.name())));
        }
    };
    Ok(Target { name: word.into(), position, known, tool: tree::tool_of(table, tools)? })
}
