//! One row of a table: its cells as numbers in SI units.

use super::cells::{cell, number, plain_number};
use super::clock;
use super::columns::{Cells, Column, Role, columns_of, joint_names};
use super::coupled;
use super::excluded::Excluded;
use super::header::Header;
use super::info::Seen;
use super::lost::Lost;
use super::plausible::Plausible;
use crate::IoError;
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, Load, TargetId, ToolId};

/// No number of a table is larger (SI): squares and sums of such numbers are still numbers.
const LARGEST: f64 = 1e30;

/// Reads rows, one at a time, into the same memory.
#[derive(Debug)]
pub(crate) struct RowReader {
    pub header: Header,
    /// Of each column: what its cells hold, and whether they are in the unit of memory already.
    pub(super) kinds: Vec<(Cells, bool)>,
    pub(super) plausible: Vec<Plausible>,
    /// Names of the targets, and the tool that carries each.
    pub(super) targets: Vec<String>,
    carriers: Vec<ToolId>,
    /// Names of the tools.
    pub(super) tools: Vec<String>,
    pub(super) position_needed: bool,
    /// The cells of the row in SI units, NaN where they are empty.
    pub(super) numbers: Vec<f64>,
    pub row: Row,
    /// What the file calls the row, where it has a column for that.
    pub id: String,
    /// Names of the sessions so far, in order of first appearance.
    pub sessions: Vec<String>,
    /// Names of the landmarks so far, in order of first appearance.
    pub landmarks: Vec<String>,
    /// What was seen in each column, in the units of the file.
    pub seen: Vec<Seen>,
    /// Of each joint, the first line beyond its limits and how many lines are.
    pub beyond: Vec<Option<(u64, usize)>>,
    /// Rows that an instrument marks as not measured.
    pub lost: Lost,
    /// Lines that are left out, ascending.
    pub(super) exclude: Excluded,
    /// The robot, where its joints are coupled: columns hold the controller's values.
    coupled: Option<Box<Chain>>,
    /// Whether the last error was about a row, and not about the file.
    pub failed: bool,
    /// What else is wrong with the row of the last error.
    pub problems: Vec<IoError>,
}

/// What a row measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Kind {
    /// A position, an orientation or both, by an instrument.
    #[default]
    Pose,
    /// That the target was at a landmark.
    SamePoint,
    /// A number, by its place in [`KINDS`](truepose_errormodel::observation::KINDS).
    Number(usize),
}

/// Values of a row, apart from those still in its cells.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Row {
    pub line: u64,
    /// The instrument had lost its target.
    pub lost: bool,
    /// Left out by the user.
    pub skipped: bool,
    pub visit: Option<i64>,
    /// Number of the session, as in [`RowReader::sessions`].
    pub session: usize,
    /// What was measured.
    pub kind: Kind,
    /// Number of the landmark, as in [`RowReader::landmarks`].
    pub landmark: Option<usize>,
    /// Number of the landmark that a camera on the robot saw, likewise.
    pub point: Option<usize>,
    pub time: f64,
    pub(super) target: Option<TargetId>,
    /// The tool that the row names.
    pub(super) tool: Option<ToolId>,
    pub orientation: Option<[f64; 4]>,
    pub load: Load,
}

impl RowReader {
    pub fn new(header: Header, chain: &Chain, position_needed: bool, exclude: Vec<u64>) -> Self {
        let kind = |column: &Column| (column.cells, column.conversion.is_si());
        RowReader {
            kinds: header.columns.iter().map(kind).collect(),
            plausible: columns_of(chain).map(|joint| Plausible::of(chain, joint)).collect(),
            targets: chain.targets().iter().map(|target| target.name.clone()).collect(),
            carriers: chain.targets().iter().map(|target| target.tool).collect(),
            tools: chain.tools().iter().map(|tool| tool.name.clone()).collect(),
            position_needed,
            numbers: vec![f64::NAN; header.columns.len()],
            row: Row::default(),
            id: String::new(),
            sessions: Vec::new(),
            landmarks: Vec::new(),
            seen: vec![Seen::default(); header.columns.len()],
            beyond: vec![None; joint_names(chain).count()],
            lost: Lost::new(chain),
            exclude: Excluded::new(exclude),
            coupled: chain.has_other_values().then(|| Box::new(chain.clone())),
            failed: false,
            problems: Vec::new(),
            header,
        }
    }

    pub fn plausible(&self, joint: usize) -> &Plausible {
        &self.plausible[joint]
    }

    /// Reads a line of the file.
    pub fn read(&mut self, line: u64, text: &[u8]) -> Result<(), IoError> {
        let read = self.read_cells(line, text);
        self.failed = read.is_err();
        read
    }

    /// Begins a row; whether it is read.
    pub(super) fn begin(&mut self, line: u64) -> bool {
        self.row = Row { line, ..Row::default() };
        self.row.skipped = self.exclude.has(line);
        !self.row.skipped
    }

    fn read_cells(&mut self, line: u64, text: &[u8]) -> Result<(), IoError> {
        if !self.begin(line) {
            return Ok(());
        }
        let mut at = 0;
        for k in 0..self.kinds.len() {
            if k > 0 {
                if at >= text.len() {
                    return Err(self.too_few(line, k));
                }
                at += 1; // the comma
            }
            let cells = self.kinds[k].0;
            if matches!(
                cells,
                Cells::Target
                    | Cells::Note
                    | Cells::Blank
                    | Cells::Use
                    | Cells::Id
                    | Cells::Session
                    | Cells::Kind
                    | Cells::Landmark
                    | Cells::Point
                    | Cells::Tool
            ) {
                at = self.read_text(line, text, at, k)?;
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
                                let error = self.empty(line, k);
                                self.problems.push(error);
                            }
                            self.numbers[k] = f64::NAN;
                            continue;
                        }
                        Err(message) => {
                            self.no_number(line, text, k, &content, message)?;
                            continue;
                        }
                    }
                }
            };
            if let Err(error) = self.put(line, k, raw) {
                self.keep(error);
            }
        }
        if at < text.len() && text[at..].iter().any(|byte| !matches!(byte, b',' | b' ' | b'\t')) {
            return Err(self.too_many(line, text));
        }
        self.judge()
    }

    /// What all cells of the row come to.
    pub(super) fn judge(&mut self) -> Result<(), IoError> {
        if self.row.skipped {
            self.problems.clear();
            return Ok(());
        }
        if !self.problems.is_empty() {
            return Err(self.problems.remove(0));
        }
        self.understand()
    }

    /// Takes a number in the unit of the file.
    #[inline]
    pub(super) fn put(&mut self, line: u64, k: usize, raw: f64) -> Result<(), IoError> {
        let (cells, si) = self.kinds[k];
        if !matches!(cells, Cells::Number | Cells::Maybe) {
            self.check_whole(line, k, cells, raw)?;
        }
        self.seen[k].see(raw);
        self.numbers[k] = if si { raw } else { self.header.columns[k].conversion.to_si(raw) };
        if self.numbers[k].abs() > LARGEST { Err(self.too_large(line, k, raw)) } else { Ok(()) }
    }

    #[cold]
    fn keep(&mut self, error: IoError) {
        self.problems.push(error);
    }

    #[cold]
    fn too_large(&self, line: u64, k: usize, raw: f64) -> IoError {
        self.header.cell_error(line, k, format!("{raw:e} cannot be meant; check the number"))
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
                if let Some(chain) = &self.coupled {
                    coupled::variables(chain, &mut into.joints);
                }
            }
            None => into.joints.iter_mut().for_each(|column| column.push(0.0)),
        }
        for (column, slot) in into.approach.iter_mut().zip(&slots.approach) {
            column.push(slot.map_or(0.0, |k| self.numbers[k]));
        }
        if let Some(chain) = &self.coupled {
            coupled::sides(chain, &mut into.approach);
        }
        for (column, &k) in into.channels.iter_mut().zip(&slots.channels) {
            column.push(self.numbers[k]);
        }
        let session = slots.session.map(|_| self.row.session as f64);
        let landmark = slots.landmark.map(|_| self.row.landmark.map_or(0.0, |k| (k + 1) as f64));
        let observed = slots.landmark.map(|_| self.observation());
        let point = slots.point.map(|_| self.row.point.map_or(0.0, |k| (k + 1) as f64));
        let tool = (self.tools.len() > 1).then(|| self.tool().0 as f64);
        let hidden = session.into_iter().chain(landmark).chain(observed.into_iter().flatten());
        let hidden = hidden.chain(point).chain(tool);
        for (column, number) in into.channels.iter_mut().skip(slots.channels.len()).zip(hidden) {
            column.push(number);
        }
        let nowhere = self.row.lost || self.is_relative();
        into.position.push(if nowhere { [f64::NAN; 3] } else { three(slots.position) });
        into.position_sd.push(if self.is_relative() { [f64::NAN; 3] } else { three(slots.position_sd) });
        into.orientation_sd.push(three(slots.orientation_sd));
        into.orientation.push(self.row.orientation);
        into.target.push(self.row.target);
        into.load.push(self.row.load);
        into.time.push(self.row.time);
        into.visit.push(visit);
        into.line.push(self.row.line);
    }

    /// The tool that carries a target.
    pub(super) fn carrier(&self, target: TargetId) -> ToolId {
        self.carriers.get(target.0).copied().unwrap_or_default()
    }

    /// The tool of the row: that of its target, the one that it names, or the first.
    fn tool(&self) -> ToolId {
        let carrier = self.row.target.map(|target| self.carrier(target));
        carrier.or(self.row.tool).unwrap_or_default()
    }

    pub(super) fn cell<'t>(
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
    pub(super) fn empty(&self, line: u64, k: usize) -> IoError {
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

    /// A cell that is no number: a date, or most often because the row is none of this table.
    #[cold]
    fn no_number(
        &mut self,
        line: u64,
        text: &[u8],
        k: usize,
        content: &str,
        message: String,
    ) -> Result<(), IoError> {
        if let Some(error) = self.miscounted(line, text) {
            return Err(error);
        }
        if content == self.header.columns[k].header {
            let message = "the header stands here again; join tables below one header".to_owned();
            return Err(IoError::line(&self.header.file, line, message));
        }
        let role = self.header.columns[k].role;
        let message = match (role, clock::seconds(content)) {
            (Role::Time, Ok(Some(seconds))) => {
                self.seen[k].see(seconds);
                self.numbers[k] = seconds;
                return Ok(());
            }
            (Role::Time, Err(message)) => message,
            (Role::Channel(_), _) if !self.header.columns[k].unit_given => {
                format!("{message}; `--ignore \"{}\"` leaves the column out", self.header.columns[k].header)
            }
            _ => message,
        };
        self.problems.push(self.header.cell_error(line, k, message));
        Ok(())
    }

    /// A row with another number of cells than the header has.
    #[cold]
    pub(super) fn miscounted(&self, line: u64, text: &[u8]) -> Option<IoError> {
        let need = self.header.columns.len();
        let mut cells = super::cells::cells(text).ok()?;
        while cells.len() > need && cells.last().is_some_and(|cell| cell.is_empty()) {
            cells.pop();
        }
        let have = cells.len();
        match have.cmp(&need) {
            std::cmp::Ordering::Less => Some(self.too_few(line, have)),
            std::cmp::Ordering::Equal => None,
            std::cmp::Ordering::Greater => Some(self.too_many(line, text)),
        }
    }

    #[cold]
    fn too_few(&self, line: u64, k: usize) -> IoError {
        let message = format!("is missing: the row has {k} cells, the header {}", self.header.columns.len());
        self.header.cell_error(line, k, message)
    }

    #[cold]
    fn too_many(&self, line: u64, text: &[u8]) -> IoError {
        let cells = super::cells::cells(text).unwrap_or_default();
        let (have, need) = (cells.len(), self.header.columns.len());
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
