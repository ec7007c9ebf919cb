//! `[columns]` of a robot description: names of columns in tables of measurements.

use super::details::units;
use crate::toml_tree::{Table, Value};
use crate::{ColumnMap, IoError, OrientationConvention};

pub(super) fn read(root: &Table<'_>) -> Result<ColumnMap, IoError> {
    let mut map = ColumnMap::default();
    let Some(columns) = root.get("columns") else { return Ok(map) };
    let columns = columns.table("[columns]")?;
    for key in columns.keys() {
        let Some(value) = columns.get(key) else { continue };
        match key {
            "orientation" => map.orientation = Some(value.word(&OrientationConvention::WORDS)?),
            "ignore" => {
                let names = value.elements("an array of names of columns")?;
                let names: Result<Vec<&str>, IoError> = names.iter().map(Value::string).collect();
                map.ignore = names?.into_iter().map(String::from).collect();
            }
            // The centre of gravity of all rows, in the unit of the file.
            "cx" | "cy" | "cz" if !value.is_string() => {
                let unit = units(root)?.length;
                map.names.push((key.to_owned(), format!("{}[{}]", value.number()?, unit.word)));
            }
            name => map.names.push((name.to_owned(), value.string()?.to_owned())),
        }
    }
    Ok(map)
}
