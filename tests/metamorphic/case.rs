//! The files of a discovery, to be changed as texts: robot, declared model, measurements.

use std::collections::BTreeMap;
use toml::{Table, Value};

/// Robot, declared model and measurements.
#[derive(Debug, Clone)]
pub struct Case {
    pub robot: Table,
    pub model: Table,
    /// (Name, unit) of each column.
    pub columns: Vec<(String, Option<String>)>,
    /// Cells as they stand in the file.
    pub rows: Vec<Vec<String>>,
    /// How the table is written: plainly, or in the dialect of a spreadsheet.
    pub spreadsheet: bool,
    pub threads: usize,
    /// New names of joints and targets, with the old ones.
    pub names: BTreeMap<String, String>,
}

/// Keys of the robot file that hold angles, in frames and in rows of a DH table; those of lengths.
const ANGLES: [&str; 3] = ["rpy", "alpha", "theta"];
const LENGTHS: [&str; 4] = ["xyz", "com", "a", "d"];

impl Case {
    /// Of the texts of the files; without quotes in the table.
    pub fn of(robot: &str, model: &str, table: &str) -> Self {
        let mut lines = table.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty());
        let head = |cell: &str| match cell.split_once('[') {
            Some((name, unit)) => (name.to_owned(), Some(unit.trim_end_matches(']').to_owned())),
            None => (cell.to_owned(), None),
        };
        let columns = lines.next().unwrap().split(',').map(head).collect();
        Case {
            robot: robot.parse().unwrap(),
            model: model.parse().unwrap(),
            columns,
            rows: lines.map(|line| line.split(',').map(String::from).collect()).collect(),
            spreadsheet: false,
            threads: 1,
            names: BTreeMap::new(),
        }
    }

    /// The table as text.
    pub fn table(&self) -> String {
        let head = |(name, unit): &(String, Option<String>)| match unit {
            Some(unit) => format!("{name}[{unit}]"),
            None => name.clone(),
        };
        let head: Vec<String> = self.columns.iter().map(head).collect();
        if !self.spreadsheet {
            let rows = self.rows.iter().map(|row| row.join(",") + "\n");
            return head.join(",") + "\n" + &rows.collect::<String>();
        }
        // As a spreadsheet of another country exports it: a mark, quotes, semicolons, decimal commas, line ends of Windows.
        let head: Vec<String> = head.iter().map(|cell| format!("\"{cell}\"")).collect();
        let rows = self.rows.iter().map(|row| row.join(";").replace('.', ",") + "\r\n");
        format!("\u{feff}# exported\r\n{}\r\n", head.join(";")) + &rows.collect::<String>()
    }

    /// The place of a column.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|(known, _)| known == name)
    }

    /// The numbers of a column, in its unit.
    pub fn numbers(&self, column: usize) -> Vec<f64> {
        self.rows.iter().map(|row| row[column].parse().unwrap_or(f64::NAN)).collect()
    }

    /// Changes the cells of a column that are not empty.
    pub fn cells(&mut self, column: usize, change: impl Fn(&str) -> String) {
        for row in &mut self.rows {
            if !row[column].is_empty() {
                row[column] = change(&row[column]);
            }
        }
    }

    /// A further column.
    pub fn add(&mut self, name: &str, unit: Option<&str>, mut cell: impl FnMut(usize) -> String) {
        self.columns.push((name.into(), unit.map(String::from)));
        self.rows.iter_mut().enumerate().for_each(|(k, row)| row.push(cell(k)));
    }

    /// Names of the joints that move, those that slide and those that turn.
    pub fn joints(&self, sliding: bool) -> Vec<String> {
        let of = |joint: &Value| {
            let kind = joint.get("type").and_then(Value::as_str).unwrap_or("revolute");
            let wanted = kind == if sliding { "prismatic" } else { "revolute" };
            wanted.then(|| joint["name"].as_str().unwrap().to_owned())
        };
        self.robot["joints"].as_array().unwrap().iter().filter_map(of).collect()
    }

    /// Unit of lengths or of angles of the robot file.
    pub fn unit(&self, quantity: &str) -> String {
        let units = self.robot.get("units").and_then(|units| units.get(quantity));
        let usual = if quantity == "length" { "m" } else { "rad" };
        units.and_then(Value::as_str).unwrap_or(usual).to_owned()
    }

    /// Says it otherwise; the numbers stay.
    pub fn set_unit(&mut self, quantity: &str, unit: &str) {
        let units = self.robot.entry("units").or_insert_with(|| Value::Table(Table::new()));
        units.as_table_mut().unwrap().insert(quantity.into(), unit.into());
    }

    /// Changes all lengths of the robot file.
    pub fn lengths(&mut self, change: &dyn Fn(f64) -> f64) {
        changed(
            &mut Value::Table(std::mem::take(&mut self.robot)),
            (&LENGTHS, "prismatic"),
            change,
            &mut self.robot,
        );
    }

    /// Changes all angles of the robot file.
    pub fn angles(&mut self, change: &dyn Fn(f64) -> f64) {
        changed(
            &mut Value::Table(std::mem::take(&mut self.robot)),
            (&ANGLES, "revolute"),
            change,
            &mut self.robot,
        );
    }
}

fn changed(whole: &mut Value, keys: (&[&str], &str), change: &dyn Fn(f64) -> f64, into: &mut Table) {
    visit(whole, keys, change);
    *into = whole.as_table().unwrap().clone();
}

/// Changes the numbers under these keys, and the limits of joints of this kind.
fn visit(value: &mut Value, (keys, kind): (&[&str], &str), change: &dyn Fn(f64) -> f64) {
    match value {
        Value::Table(table) => {
            let own = table.get("type").and_then(Value::as_str).map_or("revolute", |t| t) == kind;
            for (key, value) in table.iter_mut() {
                if keys.contains(&key.as_str()) || (key == "limits" && own) {
                    numbers(value, change);
                } else {
                    visit(value, (keys, kind), change);
                }
            }
        }
        Value::Array(all) => all.iter_mut().for_each(|value| visit(value, (keys, kind), change)),
        _ => (),
    }
}

/// Changes a number, or a list of them.
fn numbers(value: &mut Value, change: &dyn Fn(f64) -> f64) {
    match value {
        Value::Array(all) => all.iter_mut().for_each(|value| numbers(value, change)),
        Value::Integer(number) => *value = Value::Float(change(*number as f64)),
        Value::Float(number) => *number = change(*number),
        _ => (),
    }
}
