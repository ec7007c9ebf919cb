//! The header of a table: which columns there are, and whether they make sense together.

use super::cells::cells;
use super::columns::{Column, FIXED, Role, joint_names, joint_quantity};
use crate::nearest::{listed, meant};
use crate::{IoError, Warning};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use truepose_errormodel::{Channel, Schema};
use truepose_kinematics::Chain;

/// A table with more columns is another kind of file.
pub(crate) const MOST_COLUMNS: usize = 4096;

/// Which columns a kind of file has to have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Needs {
    /// Every movable joint; otherwise all of them or none.
    pub joints: bool,
    /// Something measured: a position or an orientation.
    pub measured: bool,
    /// A position in every row.
    pub position: bool,
}

/// Where the columns of each meaning stand.
#[derive(Debug, Clone, Default)]
pub(crate) struct Slots {
    pub joints: Option<Vec<usize>>,
    pub position: Option<[usize; 3]>,
    pub quaternion: Option<[usize; 4]>,
    pub rotation_vector: Option<[usize; 3]>,
    pub visit: Option<usize>,
    pub payload: Option<usize>,
    pub centre: Option<[usize; 3]>,
    pub wrench: Option<[usize; 6]>,
    pub time: Option<usize>,
    pub approach: Vec<Option<usize>>,
    pub position_sd: Option<[usize; 3]>,
    pub orientation_sd: Option<[usize; 3]>,
    pub channels: Vec<usize>,
}

/// A header that makes sense.
#[derive(Debug, Clone)]
pub(crate) struct Header {
    pub file: PathBuf,
    pub line: u64,
    pub columns: Vec<Column>,
    pub slots: Slots,
}

impl Header {
    pub fn parse(
        file: &Path,
        line: u64,
        text: &[u8],
        chain: &Chain,
        needs: Needs,
        warnings: &mut Vec<Warning>,
    ) -> Result<Header, IoError> {
        if let [b'{' | b'[', ..] = text {
            return Err(IoError::line(
                file,
                line,
                "looks like JSON; a table is CSV, and names its columns in the first line",
            ));
        }
        let names = cells(text)
            .map_err(|_| IoError::line(file, line, "a quote in the header does not end; close it"))?;
        separated_by_commas(file, line, text, names.len())?;
        if names.len() > MOST_COLUMNS {
            let message =
                format!("{} columns are more than a table of measurements has ({MOST_COLUMNS})", names.len());
            return Err(IoError::line(file, line, message));
        }
        let mut header = Header { file: file.into(), line, columns: Vec::new(), slots: Slots::default() };
        let mut seen: HashMap<String, usize> = HashMap::new();
        let mut channels = 0;
        for (k, name) in names.iter().enumerate() {
            let at = |message: String| IoError::Cell {
                file: file.into(),
                line,
                name: super::cells::shown(name),
                number: k + 1,
                message,
            };
            let (column, warning) = Column::parse(name, chain, channels).map_err(at)?;
            if let Some(message) = warning {
                let column = Some((column.header.clone(), k + 1));
                warnings.push(Warning { file: file.into(), line: Some(line), column, message });
            }
            if let Some(first) = seen.insert(column.name.clone(), k + 1) {
                let message = format!("column {first} is called `{}`, too; remove one of them", column.name);
                return Err(at(message));
            }
            channels += usize::from(matches!(column.role, Role::Channel(_)));
            header.columns.push(column);
        }
        header.slots = header.slots(chain, needs)?;
        if header.slots.payload.is_some() && header.slots.centre.is_none() {
            header.warn(
                warnings,
                header.slots.payload,
                "has no centre of gravity: the tool's origin is assumed; add `cx[mm]`, `cy[mm]`, `cz[mm]`",
            );
        }
        if header.slots.payload.is_some() && header.slots.wrench.is_some() {
            header.warn(warnings, header.slots.payload, "is not used where a wrench (fx … tz) was measured");
        }
        Ok(header)
    }

    /// An error in a cell of a column.
    pub fn cell_error(&self, line: u64, column: usize, message: impl Into<String>) -> IoError {
        IoError::Cell {
            file: self.file.clone(),
            line,
            name: self.columns[column].header.clone(),
            number: column + 1,
            message: message.into(),
        }
    }

    /// A warning about a column as a whole.
    pub fn warn(&self, warnings: &mut Vec<Warning>, column: Option<usize>, message: impl Into<String>) {
        let column = column.map(|k| (self.columns[k].header.clone(), k + 1));
        warnings.push(Warning {
            file: self.file.clone(),
            line: Some(self.line),
            column,
            message: message.into(),
        });
    }

    /// The signals that the table carries.
    pub fn schema(&self, chain: &Chain) -> Schema {
        let channel = |&k: &usize| {
            let column = &self.columns[k];
            let temperature = column.meaning.ends_with("temperature");
            let unit = if temperature { "degC".into() } else { column.unit.clone() };
            Channel { name: column.name.clone(), unit, temperature }
        };
        Schema {
            channels: self.slots.channels.iter().map(channel).collect(),
            time: self.slots.time.is_some(),
            load: self.slots.payload.is_some() || self.slots.wrench.is_some(),
            approach: self.slots.approach.len() == chain.movable().len()
                && self.slots.approach.iter().all(Option::is_some),
        }
    }

    fn find(&self, role: Role) -> Option<usize> {
        self.columns.iter().position(|column| column.role == role)
    }

    fn error(&self, message: impl Into<String>) -> IoError {
        IoError::line(&self.file, self.line, message)
    }

    fn slots(&self, chain: &Chain, needs: Needs) -> Result<Slots, IoError> {
        let joints = self.joints(chain, needs)?;
        let slots = Slots {
            joints,
            position: self.group([0, 1, 2].map(Role::Position))?,
            quaternion: self.group([0, 1, 2, 3].map(Role::Quaternion))?,
            rotation_vector: self.group([0, 1, 2].map(Role::RotationVector))?,
            visit: self.find(Role::Visit),
            payload: self.find(Role::PayloadMass),
            centre: self.group([0, 1, 2].map(Role::PayloadCentre))?,
            wrench: self.group([
                Role::Force(0),
                Role::Force(1),
                Role::Force(2),
                Role::Moment(0),
                Role::Moment(1),
                Role::Moment(2),
            ])?,
            time: self.find(Role::Time),
            approach: (0..chain.movable().len()).map(|k| self.find(Role::Approach(k))).collect(),
            position_sd: self.group([0, 1, 2].map(Role::PositionSd))?,
            orientation_sd: self.group([0, 1, 2].map(Role::OrientationSd))?,
            channels: (0..self.columns.len())
                .filter(|&k| matches!(self.columns[k].role, Role::Channel(_)))
                .collect(),
        };
        if let (Some(_), Some(second)) = (slots.quaternion, slots.rotation_vector) {
            let message = "the orientation is given twice, as a quaternion and as a rotation vector; remove one of them";
            return Err(self.cell_error(self.line, second[0], message));
        }
        if let (Some(centre), None) = (slots.centre, slots.payload) {
            let message = "a centre of gravity needs a mass; add `payload[kg]`";
            return Err(self.cell_error(self.line, centre[0], message));
        }
        let seen = slots.position.is_some() || slots.quaternion.is_some() || slots.rotation_vector.is_some();
        if (needs.position && slots.position.is_none()) || (needs.measured && !seen) {
            let what = if needs.position { "a position" } else { "anything measured" };
            let columns = self.listed();
            let message =
                format!("no columns hold {what}; add `x[mm]`, `y[mm]`, `z[mm]` (columns here: {columns})");
            return Err(self.error(message));
        }
        Ok(slots)
    }

    /// All columns of one thing, or none.
    fn group<const N: usize>(&self, roles: [Role; N]) -> Result<Option<[usize; N]>, IoError> {
        let found = roles.map(|role| self.find(role));
        let Some(first) = found.iter().flatten().min() else {
            return Ok(None);
        };
        let mut slots = [0; N];
        for (slot, (found, role)) in slots.iter_mut().zip(found.iter().zip(roles)) {
            match found {
                Some(k) => *slot = *k,
                None => {
                    let word = |role: Role| {
                        FIXED.iter().find(|(_, other)| *other == role).map_or("?", |(word, _)| word)
                    };
                    let all: Vec<&str> = roles.iter().map(|&role| word(role)).collect();
                    let message = format!(
                        "column `{}` is missing; {} belong together (a cell may be empty where nothing was measured)",
                        word(role),
                        all.join(" ")
                    );
                    return Err(self.cell_error(self.line, *first, message));
                }
            }
        }
        Ok(Some(slots))
    }

    fn joints(&self, chain: &Chain, needs: Needs) -> Result<Option<Vec<usize>>, IoError> {
        let found: Vec<Option<usize>> =
            (0..chain.movable().len()).map(|k| self.find(Role::Joint(k))).collect();
        if !needs.joints && found.iter().all(Option::is_none) {
            return Ok(None);
        }
        let mut slots = Vec::with_capacity(found.len());
        for (k, (found, name)) in found.iter().zip(joint_names(chain)).enumerate() {
            match found {
                Some(slot) => slots.push(*slot),
                None => {
                    let units: Vec<String> = joint_quantity(chain, k)
                        .units()
                        .take(2)
                        .map(|unit| format!("`{name}[{unit}]`"))
                        .collect();
                    let others = self
                        .columns
                        .iter()
                        .filter(|column| matches!(column.role, Role::Channel(_)))
                        .map(|column| column.name.as_str());
                    if self.columns.iter().filter(|c| c.name.parse::<f64>().is_ok()).count() > 2 {
                        return Err(self.error(
                            "the first line holds numbers; put a line above it that names the columns, such as `theta[deg],x[mm]`",
                        ));
                    }
                    let hint = meant(name, others).replace("did you mean", "is it called");
                    return Err(self.error(format!(
                        "joint `{name}` has no column{hint}; add {} (columns here: {})",
                        units.join(" or "),
                        self.listed()
                    )));
                }
            }
        }
        Ok(Some(slots))
    }

    fn listed(&self) -> String {
        listed(self.columns.iter().map(|column| column.header.as_str()))
    }
}

fn separated_by_commas(file: &Path, line: u64, text: &[u8], count: usize) -> Result<(), IoError> {
    let has = |byte: u8| text.contains(&byte);
    let other = match () {
        () if has(b'\r') => {
            return Err(IoError::line(
                file,
                line,
                "lines end in a lone carriage return; save with LF or CRLF line ends",
            ));
        }
        () if has(0) => return Err(IoError::line(file, line, "is binary data; this is not a CSV file")),
        () if count > 1 => return Ok(()),
        () if has(b';') => "`;`",
        () if has(b'\t') => "tabs",
        () if has(b'|') => "`|`",
        () => return Ok(()),
    };
    let message =
        format!("columns are separated by {other}; separate them by commas and write decimals with a point");
    Err(IoError::line(file, line, message))
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    const NEEDS: Needs = Needs { joints: true, measured: true, position: false };

    fn parse(text: &str) -> Result<(Header, Vec<String>), String> {
        let mut warnings = Vec::new();
        Header::parse(Path::new("d.csv"), 1, text.as_bytes(), &samples::scara(), NEEDS, &mut warnings)
            .map(|header| (header, warnings.iter().map(Warning::to_string).collect()))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn columns_that_belong_together() {
        let joints = "r1[rad],r2[deg],slide[mm],r4[rad]";
        let with = |rest: &str| parse(&format!("{joints},{rest}"));
        let (header, warnings) = with("x[mm],y[mm],z[mm],temp[K],payload[kg]").unwrap();
        assert_eq!(header.slots.joints, Some(vec![0, 1, 2, 3]));
        assert_eq!(header.schema(&samples::scara()).channels[0].unit, "degC");
        assert_eq!(
            warnings,
            [
                "d.csv:1: column `payload[kg]` (9): has no centre of gravity: the tool's origin is assumed; add `cx[mm]`, `cy[mm]`, `cz[mm]`"
            ]
        );
        for (rest, message) in [
            (
                "x[mm],y[mm]",
                "d.csv:1: column `x[mm]` (5): column `z` is missing; x y z belong together (a cell may be empty where \
                 nothing was measured)",
            ),
            (
                "x[mm],y[mm],z[mm],x[m]",
                "d.csv:1: column `x[m]` (8): column 5 is called `x`, too; remove one of them",
            ),
            (
                "qw,qx,qy,qz,rx[rad],ry[rad],rz[rad]",
                "d.csv:1: column `rx[rad]` (9): the orientation is given twice, as a quaternion and as a rotation vector; \
                 remove one of them",
            ),
            (
                "x[mm],y[mm],z[mm],cx[mm],cy[mm],cz[mm]",
                "d.csv:1: column `cx[mm]` (8): a centre of gravity needs a mass; add `payload[kg]`",
            ),
            (
                "temp[K]",
                "d.csv:1: no columns hold anything measured; add `x[mm]`, `y[mm]`, `z[mm]` (columns here: r1[rad], \
                 r2[deg], slide[mm], r4[rad], temp[K])",
            ),
        ] {
            assert_eq!(with(rest).unwrap_err(), message);
        }
    }

    #[test]
    fn a_missing_joint_is_reported() {
        assert_eq!(
            parse("r1[rad],r2[deg],slyde[mm],r4[rad],x[m],y[m],z[m]").unwrap_err(),
            "d.csv:1: joint `slide` has no column; is it called `slyde`?; add `slide[m]` or `slide[mm]` (columns here: \
             r1[rad], r2[deg], slyde[mm], r4[rad], x[m], y[m], z[m])"
        );
    }

    #[test]
    fn other_separators_are_reported() {
        assert_eq!(
            parse("r1[rad];r2[deg]").unwrap_err(),
            "d.csv:1: columns are separated by `;`; separate them by commas and write decimals with a point"
        );
        assert!(parse("r1\tr2").unwrap_err().contains("separated by tabs"));
        assert!(parse("r1,r2\rx").unwrap_err().contains("lone carriage return"));
        assert!(parse("r1,\"r2").unwrap_err().contains("a quote in the header does not end"));
    }
}
