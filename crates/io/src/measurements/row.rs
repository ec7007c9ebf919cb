//! One row of a table: its cells as numbers in SI units, and what they say together.

use super::cells::{cell, number, plain_number, shown};
use super::columns::{Cells, joint_names};
use super::header::Header;
use super::info::Seen;
use super::plausible::Plausible;
use crate::IoError;
use crate::nearest::{listed, meant};
use truepose_errormodel::Dataset;
use truepose_kinematics::nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Chain, Load, Payload, Pose, TargetId, Wrench, rotation_vector};

/// Further from one than this, a quaternion is something else.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Reads rows, one at a time, into the same memory.
#[derive(Debug)]
pub(crate) struct RowReader {
    pub header: Header,
    plausible: Vec<Plausible>,
    targets: Vec<String>,
    position_needed: bool,
    /// The cells of the row in SI units, NaN where they are empty.
    numbers: Vec<f64>,
    pub row: Row,
    /// What was seen in each column, in the units of the file.
    pub seen: Vec<Seen>,
    /// Of each joint, the first line beyond its limits and how many lines are.
    pub beyond: Vec<Option<(u64, usize)>>,
}

/// What a row says, apart from what is still in its cells.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Row {
    pub line: u64,
    pub visit: Option<i64>,
    pub time: f64,
    target: Option<TargetId>,
    orientation: Option<[f64; 4]>,
    load: Load,
}

impl RowReader {
    pub fn new(header: Header, chain: &Chain, position_needed: bool) -> Self {
        RowReader {
            plausible: chain.movable().iter().map(|&joint| Plausible::new(chain.joint(joint))).collect(),
            targets: chain.targets().iter().map(|target| target.name.clone()).collect(),
            position_needed,
            numbers: vec![f64::NAN; header.columns.len()],
            row: Row::default(),
            seen: vec![Seen::default(); header.columns.len()],
            beyond: vec![None; joint_names(chain).count()],
            header,
        }
    }

    pub fn plausible(&self, joint: usize) -> &Plausible {
        &self.plausible[joint]
    }

    /// Reads a line of the file.
    pub fn read(&mut self, line: u64, text: &[u8]) -> Result<(), IoError> {
        self.row = Row { line, ..Row::default() };
        let mut at = 0;
        for k in 0..self.header.columns.len() {
            if k > 0 {
                if at >= text.len() {
                    return Err(self.too_few(line, k));
                }
                at += 1; // the comma
            }
            let cells = self.header.columns[k].cells;
            if cells == Cells::Target {
                at = self.read_target(line, text, at, k)?;
                continue;
            }
            let raw = match plain_number(text, at) {
                Some((raw, end)) => {
                    at = end;
                    raw
                }
                None => {
                    let (content, end) = self.cell(line, text, at, k)?;
                    at = end;
                    match number(&content) {
                        Ok(Some(raw)) => raw,
                        Ok(None) => {
                            if cells != Cells::Maybe {
                                return Err(self.empty(line, k));
                            }
                            self.numbers[k] = f64::NAN;
                            continue;
                        }
                        Err(message) => return Err(self.header.cell_error(line, k, message)),
                    }
                }
            };
            if !matches!(cells, Cells::Number | Cells::Maybe) {
                self.check_whole(line, k, cells, raw)?;
            }
            self.seen[k].see(raw);
            self.numbers[k] = self.header.columns[k].conversion.to_si(raw);
        }
        if at < text.len() {
            return Err(self.too_many(line, text));
        }
        self.understand()
    }

    /// Appends the row to a data set.
    pub fn push(&self, visit: usize, into: &mut Dataset) {
        let three =
            |slots: Option<[usize; 3]>| slots.map_or([f64::NAN; 3], |slots| slots.map(|k| self.numbers[k]));
        let slots = &self.header.slots;
        match &slots.joints {
            Some(slots) => {
                for (column, &k) in into.joints.iter_mut().zip(slots) {
                    column.push(self.numbers[k]);
                }
            }
            None => into.joints.iter_mut().for_each(|column| column.push(0.0)),
        }
        for (column, slot) in into.approach.iter_mut().zip(&slots.approach) {
            column.push(slot.map_or(0.0, |k| self.numbers[k]));
        }
        for (column, &k) in into.channels.iter_mut().zip(&slots.channels) {
            column.push(self.numbers[k]);
        }
        into.position.push(three(slots.position));
        into.position_sd.push(three(slots.position_sd));
        into.orientation_sd.push(three(slots.orientation_sd));
        into.orientation.push(self.row.orientation);
        into.target.push(self.row.target);
        into.load.push(self.row.load);
        into.time.push(self.row.time);
        into.visit.push(visit);
        into.line.push(self.row.line);
    }

    /// What the cells of the row say together.
    fn understand(&mut self) -> Result<(), IoError> {
        let line = self.row.line;
        if let Some(slots) = &self.header.slots.joints {
            for (joint, &k) in slots.iter().enumerate() {
                let (value, plausible) = (self.numbers[k], &self.plausible[joint]);
                if value < plausible.lower || value > plausible.upper {
                    plausible
                        .judge(value, &self.header.columns[k])
                        .map_err(|message| self.header.cell_error(line, k, message))?;
                    self.beyond[joint].get_or_insert((line, 0)).1 += 1;
                }
            }
        }
        if self.position_needed
            && let Some(slots) = self.header.slots.position
            && let Some(&k) = slots.iter().find(|&&k| self.numbers[k].is_nan())
        {
            return Err(self.header.cell_error(line, k, "is empty; a desired pose needs all of x, y, z"));
        }
        if let Some(k) = self.header.slots.visit {
            self.row.visit = Some(self.numbers[k] as i64);
        }
        if let Some(k) = self.header.slots.time {
            self.row.time = self.numbers[k];
        }
        if let Some(slots) = self.header.slots.quaternion {
            self.row.orientation = self.quaternion(slots)?;
        }
        if let Some(slots) = self.header.slots.rotation_vector {
            self.row.orientation = self.rotation_vector(slots)?;
        }
        for slots in [self.header.slots.position_sd, self.header.slots.orientation_sd].into_iter().flatten() {
            if let Some(&k) = slots.iter().find(|&&k| self.numbers[k] <= 0.0) {
                let message =
                    "a standard deviation has to be above zero; leave the cell empty where none is stated";
                return Err(self.header.cell_error(line, k, message));
            }
        }
        self.row.load = self.load()?;
        Ok(())
    }

    fn load(&self) -> Result<Load, IoError> {
        let slots = &self.header.slots;
        if let Some(slots) = slots.wrench
            && let Some(w) = self.all_or_none(slots, "the wrench")?
        {
            return Ok(Load::Wrench(Wrench {
                force: Vector3::new(w[0], w[1], w[2]),
                moment: Vector3::new(w[3], w[4], w[5]),
            }));
        }
        let Some(k) = slots.payload else {
            return Ok(Load::None);
        };
        let mass = self.numbers[k];
        if mass < 0.0 {
            return Err(self.header.cell_error(self.row.line, k, "a mass cannot be negative"));
        }
        let mut com = Vector3::zeros();
        if let Some(slots) = slots.centre {
            com = Vector3::from(slots.map(|k| self.numbers[k]));
            if com.iter().any(|v| v.is_nan()) {
                if mass > 0.0 {
                    let k = slots[com.iter().position(|v| v.is_nan()).unwrap_or(0)];
                    return Err(self.header.cell_error(
                        self.row.line,
                        k,
                        "is empty; a mass needs its centre of gravity",
                    ));
                }
                com = Vector3::zeros();
            }
        }
        Ok(Load::Payload(Payload { mass, com }))
    }

    fn quaternion(&self, slots: [usize; 4]) -> Result<Option<[f64; 4]>, IoError> {
        let Some(q) = self.all_or_none(slots, "the quaternion")? else {
            return Ok(None);
        };
        let norm = q.iter().map(|v| v * v).sum::<f64>().sqrt();
        if norm.is_nan() || (norm - 1.0).abs() > UNIT_TOLERANCE {
            let message = format!(
                "the quaternion has length {}, not 1; check the order qw qx qy qz",
                super::plausible::rounded(norm)
            );
            return Err(self.header.cell_error(self.row.line, slots[0], message));
        }
        Ok(Some(q.map(|v| v / norm)))
    }

    fn rotation_vector(&self, slots: [usize; 3]) -> Result<Option<[f64; 4]>, IoError> {
        let Some(v) = self.all_or_none(slots, "the rotation vector")? else {
            return Ok(None);
        };
        let v = Vector3::from(v);
        let turn = v.norm();
        if turn.is_nan() || turn > 3.0 * std::f64::consts::PI {
            let message = format!(
                "the rotation vector turns by {} rad, beyond any plausible turn; check the unit",
                super::plausible::rounded(turn)
            );
            return Err(self.header.cell_error(self.row.line, slots[0], message));
        }
        let rotation: Matrix3<f64> = rotation_vector(&v);
        Ok(Some(Pose::new(rotation, Vector3::zeros()).quaternion()))
    }

    /// The cells of one thing: all of them, or none when all are empty.
    fn all_or_none<const N: usize>(
        &self,
        slots: [usize; N],
        what: &str,
    ) -> Result<Option<[f64; N]>, IoError> {
        let values = slots.map(|k| self.numbers[k]);
        match values.iter().filter(|v| v.is_nan()).count() {
            0 => Ok(Some(values)),
            empty if empty == N => Ok(None),
            _ => {
                let k = slots[values.iter().position(|v| v.is_nan()).unwrap_or(0)];
                let message =
                    format!("is empty while other cells of {what} are filled; fill or empty all of them");
                Err(self.header.cell_error(self.row.line, k, message))
            }
        }
    }

    fn read_target(&mut self, line: u64, text: &[u8], at: usize, k: usize) -> Result<usize, IoError> {
        let (name, end) = self.cell(line, text, at, k)?;
        self.row.target = if name.is_empty() {
            None
        } else {
            match self.targets.iter().position(|target| *target == name) {
                Some(index) => Some(TargetId(index)),
                None => {
                    let known = || self.targets.iter().map(String::as_str);
                    let name = shown(&name);
                    let hint = meant(&name, known());
                    let known = listed(known());
                    let message = format!(
                        "the robot has no target `{name}`{hint}; declare it in [[targets]] (its targets: {known})"
                    );
                    return Err(self.header.cell_error(line, k, message));
                }
            }
        };
        self.seen[k].filled += usize::from(self.row.target.is_some());
        Ok(end)
    }

    fn cell<'t>(
        &self,
        line: u64,
        text: &'t [u8],
        at: usize,
        k: usize,
    ) -> Result<(std::borrow::Cow<'t, str>, usize), IoError> {
        cell(text, at)
            .map_err(|_| self.header.cell_error(line, k, "a quote in the cell does not end; close it"))
    }

    #[cold]
    fn empty(&self, line: u64, k: usize) -> IoError {
        use super::columns::Role;
        let message = match self.header.columns[k].role {
            Role::Joint(_) => "is empty; every row needs all joint values",
            Role::PayloadMass => "is empty; write 0 where nothing is carried",
            Role::Approach(_) => "is empty; write 0 where the direction is not known",
            Role::Channel(_) => {
                "is empty; a channel needs a value in every row: fill it or remove the column"
            }
            _ => "is empty; every row needs a value",
        };
        self.header.cell_error(line, k, message)
    }

    #[cold]
    fn too_few(&self, line: u64, k: usize) -> IoError {
        let message = format!("is missing: the row has {k} cells, the header {}", self.header.columns.len());
        self.header.cell_error(line, k, message)
    }

    #[cold]
    fn too_many(&self, line: u64, text: &[u8]) -> IoError {
        let have = super::cells::cells(text).map_or(0, |cells| cells.len());
        let need = self.header.columns.len();
        let hint = if 2 * have >= 3 * need { "; write decimals with a point, not a comma" } else { "" };
        IoError::line(&self.header.file, line, format!("the row has {have} cells, the header {need}{hint}"))
    }

    fn check_whole(&self, line: u64, k: usize, cells: Cells, raw: f64) -> Result<(), IoError> {
        let whole = raw.fract().abs() < f64::MIN_POSITIVE;
        match cells {
            Cells::Direction if !(whole && raw.abs() <= 1.0) => Err(self.header.cell_error(
                line,
                k,
                format!("a direction of approach is -1, 0 or 1, not {raw}"),
            )),
            Cells::Integer if !(whole && raw.abs() < 9e15) => Err(self.header.cell_error(
                line,
                k,
                format!("the number of a visit is an integer, not {raw}"),
            )),
            _ => Ok(()),
        }
    }
}
