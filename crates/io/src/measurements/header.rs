//! The header of a table: which columns there are, and whether they make sense together.

use super::beside_kind::numbered;
use super::cells::cells;
use super::columns::{Column, FIXED, Role};
use super::constants;
use super::coupled;
use super::names::Names;
use super::orientation::OrientationConvention;
use super::proposal::{Proposal, applied, impossible};
use super::sampled::Sample;
use super::scalars::SCALARS;
use crate::nearest::listed;
use crate::{IoError, Warning};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use truepose_errormodel::{Channel, KIND, LANDMARK, POINT, SESSION, Schema, TOOL, VALUE};
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
    /// Angles in the order of the convention, and the convention.
    pub angles: Option<([usize; 3], OrientationConvention)>,
    pub visit: Option<usize>,
    pub session: Option<usize>,
    pub kind: Option<usize>,
    pub landmark: Option<usize>,
    pub point: Option<usize>,
    /// Measured numbers, in the order of [`SCALARS`].
    pub scalars: [Option<usize>; SCALARS.len()],
    pub payload: Option<usize>,
    pub centre: Option<[usize; 3]>,
    /// The centre of gravity of all rows, m, where it is no column.
    pub same_centre: Option<[f64; 3]>,
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
    /// What columns without a meaning are perhaps.
    pub proposal: Proposal,
    /// Why a fit refuses the table, where no column holds anything measured.
    pub unmeasured: Option<String>,
}

impl Header {
    pub fn parse(
        file: &Path,
        line: u64,
        text: &[u8],
        names: &Names<'_>,
        sample: &Sample,
        needs: Needs,
        warnings: &mut Vec<Warning>,
    ) -> Result<Header, IoError> {
        let resolver = names;
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
        if names.len() > 2 && names.iter().all(|name| name.parse::<f64>().is_ok()) {
            let message = "holds numbers alone, where the names of the columns are expected; add a line above it, such as \
                           `theta[deg],x[mm],y[mm],z[mm]`, with a name for each column";
            return Err(IoError::line(file, line, message));
        }
        if names.len() > MOST_COLUMNS {
            let message =
                format!("{} columns are more than a table of measurements has ({MOST_COLUMNS})", names.len());
            return Err(IoError::line(file, line, message));
        }
        let headers: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
        for (mistake, message) in resolver.unmatched(&headers, needs.measured) {
            if mistake {
                return Err(IoError::line(file, line, message));
            }
            warnings.push(Warning { file: file.into(), line: Some(line), column: None, message });
        }
        let (own, said) = applied(&headers, sample, resolver);
        for message in said {
            warnings.push(Warning { file: file.into(), line: Some(line), column: None, message });
        }
        let resolver = &Names { chain: resolver.chain, map: &own };
        let proposal = Proposal::of(&headers, sample, resolver);
        let (columns, slots) = (Vec::new(), Slots::default());
        let mut header = Header { file: file.into(), line, columns, slots, proposal, unmeasured: None };
        let mut seen: HashMap<String, usize> = HashMap::new();
        let mut channels = 0;
        let mut errors = Vec::new();
        let observed = headers.iter().any(|header| resolver.means(header, Role::Kind));
        for (k, name) in names.iter().enumerate() {
            let at = |message: String| IoError::Cell {
                file: file.into(),
                line,
                name: super::cells::shown(name),
                number: k + 1,
                message,
            };
            let found = sample.column(k, name, resolver, channels);
            let (column, warning) = match found.and_then(|found| numbered(found, observed, resolver.chain)) {
                Ok(found) => found,
                Err(message) => {
                    errors.push(at(message));
                    continue;
                }
            };
            // What is proposed is said once.
            let told = |message: &String| {
                !(matches!(column.role, Role::Channel(_)) && message.contains("did you mean"))
            };
            if let Some(message) = warning.filter(|message| !header.proposal.has(name) || told(message)) {
                let column = Some((column.header.clone(), k + 1));
                warnings.push(Warning { file: file.into(), line: Some(line), column, message });
            }
            if column.role != Role::Nothing
                && let Some(first) = seen.insert(column.name.clone(), k + 1)
            {
                let message = format!("column {first} is called `{}`, too; remove one of them", column.name);
                errors.push(at(message));
            }
            errors.extend(impossible(&column, sample, k).map(at));
            channels += usize::from(matches!(column.role, Role::Channel(_)));
            header.columns.push(column);
        }
        if !errors.is_empty() {
            errors.extend(header.proposed());
            return Err(IoError::several(errors, 0));
        }
        header.slots = header.slots(resolver, needs)?;
        if (needs.measured || needs.position) && !header.proposal.is_empty() {
            let message = format!("{}{}", header.proposal.matter(), header.proposal.text());
            warnings.push(Warning { file: file.into(), line: Some(line), column: None, message });
        }
        if header.slots.payload.is_some()
            && header.slots.centre.is_none()
            && header.slots.same_centre.is_none()
        {
            header.warn(
                warnings,
                header.slots.payload,
                "has no centre of gravity: the tool's origin is assumed (the point that is measured, where tool and targets are not known); give it \
                 with `--map \"cz=120mm\"` for all rows, in the tool frame, or in columns `cx[mm]`, `cy[mm]`, `cz[mm]`",
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
        // Numbers of sessions and landmarks stand behind the channels of the file.
        let number = |name: &str| Channel { name: name.into(), unit: "1".into(), temperature: false };
        let channels = self.slots.channels.iter().map(channel);
        let session = self.slots.session.map(|_| number(SESSION));
        let landmark = self.slots.landmark.map(|_| number(LANDMARK));
        let observed =
            [KIND, VALUE[0], VALUE[1], VALUE[2]].map(|name| self.slots.landmark.map(|_| number(name)));
        let point = self.slots.point.map(|_| number(POINT));
        let tool = (chain.tools().len() > 1).then(|| number(TOOL));
        let hidden = session.into_iter().chain(landmark).chain(observed.into_iter().flatten());
        let hidden = hidden.chain(point).chain(tool);
        Schema {
            channels: channels.chain(hidden).collect(),
            time: self.slots.time.is_some(),
            load: self.slots.payload.is_some() || self.slots.wrench.is_some(),
            approach: self.slots.approach.len() == chain.movable().len()
                && self.slots.approach.iter().all(Option::is_some),
        }
    }

    pub(super) fn find(&self, role: Role) -> Option<usize> {
        self.columns.iter().position(|column| column.role == role)
    }

    fn error(&self, message: impl Into<String>) -> IoError {
        IoError::line(&self.file, self.line, message)
    }

    fn slots(&mut self, names: &Names<'_>, needs: Needs) -> Result<Slots, IoError> {
        let chain = names.chain;
        let joints = self.joints(chain, needs)?;
        let slots = Slots {
            joints,
            position: self.group([0, 1, 2].map(Role::Position))?,
            quaternion: self.group([0, 1, 2, 3].map(Role::Quaternion))?,
            rotation_vector: self.group([0, 1, 2].map(Role::RotationVector))?,
            angles: self.group([0, 1, 2].map(Role::Angle))?.zip(names.map.orientation),
            visit: self.find(Role::Visit),
            session: self.find(Role::Session),
            kind: self.find(Role::Kind),
            landmark: self.find(Role::Landmark),
            point: self.find(Role::Point),
            scalars: std::array::from_fn(|k| self.find(Role::Scalar(k))),
            payload: self.find(Role::PayloadMass),
            centre: self.group([0, 1, 2].map(Role::PayloadCentre))?,
            same_centre: constants::centre(names.map),
            wrench: self.group([
                Role::Force(0),
                Role::Force(1),
                Role::Force(2),
                Role::Moment(0),
                Role::Moment(1),
                Role::Moment(2),
            ])?,
            time: self.find(Role::Time),
            approach: self.sides(chain),
            position_sd: self.group([0, 1, 2].map(Role::PositionSd))?,
            orientation_sd: self.group([0, 1, 2].map(Role::OrientationSd))?,
            channels: (0..self.columns.len())
                .filter(|&k| matches!(self.columns[k].role, Role::Channel(_)))
                .collect(),
        };
        let angles = slots.angles.map(|(angles, _)| angles);
        let twice = (slots.quaternion.is_some(), slots.rotation_vector, angles);
        if let (_, Some(_), Some(second)) | (true, None, Some(second)) = twice {
            let message = "the orientation is given twice, once as angles; remove one of them";
            return Err(self.cell_error(self.line, second[0], message));
        }
        if let (Some(_), Some(second)) = (slots.quaternion, slots.rotation_vector) {
            let message = "the orientation is given twice, as a quaternion and as a rotation vector; remove one of them";
            return Err(self.cell_error(self.line, second[0], message));
        }
        if let (Some(centre), None) = (slots.centre, slots.payload) {
            let message = "a centre of gravity needs a mass; add `payload[kg]`";
            return Err(self.cell_error(self.line, centre[0], message));
        }
        let oriented = slots.quaternion.is_some() || slots.rotation_vector.is_some() || angles.is_some();
        let seen = slots.position.is_some() || oriented || slots.kind.is_some();
        if let (None, Some(k)) = (slots.kind, slots.landmark) {
            let message = "needs a column `kind` beside it, which says how the landmark was observed (`same_point`, `distance`, `plane` …)";
            return Err(self.cell_error(self.line, k, message));
        }
        let wanted = if needs.position { slots.position.is_some() } else { seen };
        if !wanted {
            let message = self.nothing_measured(needs);
            if needs.measured || needs.position {
                return Err(self.error(message));
            }
            self.unmeasured = Some(message);
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
                    let word = |role: Role| match role {
                        Role::Angle(k) => ["first angle", "second angle", "third angle"][k],
                        role => FIXED.iter().find(|(_, other)| *other == role).map_or("?", |(word, _)| word),
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

    /// The columns of directions of approach; a joint that follows another one shares its column.
    fn sides(&self, chain: &Chain) -> Vec<Option<usize>> {
        let own = |k: usize| self.find(Role::Approach(k));
        (0..chain.movable().len()).map(|k| own(coupled::column_of(chain, k))).collect()
    }

    fn joints(&self, chain: &Chain, needs: Needs) -> Result<Option<Vec<usize>>, IoError> {
        let found: Vec<Option<usize>> = (0..chain.movable().len())
            .map(|k| self.find(Role::Joint(coupled::column_of(chain, k))))
            .collect();
        if !needs.joints && found.iter().all(Option::is_none) {
            return Ok(None);
        }
        if found.iter().all(Option::is_some) {
            return Ok(Some(found.into_iter().flatten().collect()));
        }
        if self.columns.iter().filter(|c| c.name.parse::<f64>().is_ok()).count() > 2 {
            return Err(self.error(
                "the first line holds numbers; put a line above it that names the columns, such as `theta[deg],x[mm]`",
            ));
        }
        Err(self.error(self.missing_joints(chain, &found)))
    }

    pub(super) fn listed(&self) -> String {
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
mod tests;
