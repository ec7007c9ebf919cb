//! Rows of a table in blocks, in constant memory.

use super::columns::Cells;
use super::header::{Header, Needs};
use super::info::{ColumnInfo, CsvInfo};
use super::mapping::ColumnMap;
use super::names::Names;
use super::problems::Problems;
use super::row::RowReader;
use super::sampled::Sample;
use super::source::Source;
use super::suspicious::{ReadSoFar, look_at_columns};
use super::visits::{VisitNumbers, check_standstills, label_in_file};
use crate::{IoError, Warning};
use std::path::Path;
use truepose_errormodel::{Dataset, Dwell, DwellTolerance, Schema};
use truepose_kinematics::Chain;

/// What a file of measurements has to have, and how its rows are grouped.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasurementsOptions {
    /// Whether something has to be measured; a prediction needs the conditions only.
    pub measured_required: bool,
    /// Joint values within this tolerance are those of one dwell, and of one configuration.
    pub dwell: DwellTolerance,
    /// Which column is which, and what is left out.
    pub columns: ColumnMap,
}

impl Default for MeasurementsOptions {
    fn default() -> Self {
        MeasurementsOptions {
            measured_required: true,
            dwell: DwellTolerance::default(),
            columns: ColumnMap::default(),
        }
    }
}

/// Reads measurements block by block, for files of any length.
#[derive(Debug)]
pub struct MeasurementsReader {
    /// Which column was to be which.
    map: ColumnMap,
    pub(super) source: Source,
    pub(super) rows: RowReader,
    schema: Schema,
    pub(super) dwell: Dwell,
    /// The default of this robot, whatever was asked for.
    pub(super) still: Dwell,
    joints: usize,
    pub(super) visits: VisitNumbers,
    labels: Vec<i64>,
    /// What the file calls the rows of the block (or file) that was read last; empty without a column `id`.
    ids: Vec<String>,
    /// A row that was read and belongs to the next block.
    pub(super) pending: bool,
    pub(super) count: usize,
    pub(super) first_bytes: usize,
    last_time: f64,
    /// The first line where time goes backwards, and how many do.
    pub(super) backwards: Option<(u64, usize)>,
    pub(super) warnings: Vec<Warning>,
}

impl MeasurementsReader {
    /// Reads the header of a source.
    pub(super) fn begin(
        path: &Path,
        (mut source, sample, remarks): (Source, Sample, Vec<String>),
        chain: &Chain,
        needs: Needs,
        dwell: DwellTolerance,
        columns: &ColumnMap,
    ) -> Result<Self, IoError> {
        let names = Names { chain, map: columns };
        let remark = |message| Warning { file: path.into(), line: None, column: None, message };
        let mut warnings: Vec<Warning> = remarks.into_iter().map(remark).collect();
        let header = match source.header()? {
            Some((line, text)) => Header::parse(path, line, &text, &names, &sample, needs, &mut warnings)?,
            None => {
                return Err(IoError::file(
                    path,
                    "is empty; the first line names the columns, such as `theta[deg],x[mm]`",
                ));
            }
        };
        let schema = header.schema(chain);
        Ok(MeasurementsReader {
            source,
            rows: RowReader::new(header, chain, needs.position, columns.exclude.clone()),
            schema,
            dwell: Dwell::of(chain, dwell),
            still: Dwell::of(chain, DwellTolerance::default()),
            joints: chain.movable().len(),
            visits: VisitNumbers::default(),
            labels: Vec::new(),
            ids: Vec::new(),
            map: columns.clone(),
            pending: false,
            count: 0,
            first_bytes: 0,
            last_time: f64::NEG_INFINITY,
            backwards: None,
            warnings,
        })
    }

    /// Which signals the file carries. Directions of approach count only where the file states them for every joint.
    pub fn schema(&self) -> &Schema {
        &self.schema
    }

    /// How many bytes have been read, and how many the file has.
    pub fn progress(&self) -> (u64, u64) {
        (self.source.handed_out(), self.source.size())
    }

    /// The file's own numbers of the visits of the block that was read last; none where it numbers none.
    pub fn block_labels(&self) -> &[i64] {
        &self.labels
    }

    /// What the file calls the rows of the block that was read last (column `id`); none where it has no such column.
    pub fn block_ids(&self) -> &[String] {
        &self.ids
    }

    /// Whether the file has names of its rows, in a column `id`.
    pub fn has_ids(&self) -> bool {
        self.rows.header.columns.iter().any(|column| column.cells == Cells::Id)
    }

    fn keep_id(&mut self, has_ids: bool) {
        if has_ids {
            self.ids.push(self.rows.id.clone());
        }
    }

    /// What was suspicious so far: about the header, and about the rows read as far as no row has to be remembered for that.
    pub fn warnings(&self, chain: &Chain) -> Vec<Warning> {
        let mut warnings = self.warnings.clone();
        look_at_columns(&self.read_so_far(), chain, &mut warnings);
        warnings
    }

    pub(super) fn read_so_far(&self) -> ReadSoFar<'_> {
        ReadSoFar { rows: &self.rows, count: self.count, backwards: self.backwards }
    }

    /// Whether the file numbers visits, and whether it has a column of targets.
    pub fn names(&self) -> (bool, bool) {
        let targets = self.rows.header.columns.iter().any(|column| column.cells == Cells::Target);
        (self.rows.header.slots.visit.is_some(), targets)
    }

    /// Reads the next block into `block`, replacing what it holds: at least `rows` rows, so many more that no visit
    /// is cut, and fewer at the end of the file. Returns how many; zero at the end.
    ///
    /// Visits count from zero in each block. Rows of one visit have to follow each other.
    ///
    /// # Errors
    /// At the first row that is wrong.
    pub fn read_block(&mut self, rows: usize, block: &mut Dataset) -> Result<usize, IoError> {
        self.clear(block);
        let mut labels = std::mem::take(&mut self.labels);
        labels.clear();
        let (mut visit, mut first) = (0, 0);
        let has_ids = self.has_ids();
        self.ids.clear();
        loop {
            if !self.pending && !self.next_row()? {
                break;
            }
            self.pending = false;
            let label = self.rows.row.visit;
            // Pushed first: whether a row without a number continues the visit shows only beside the one before.
            self.rows.push(visit, block);
            self.keep_id(has_ids);
            let row = block.visit.len() - 1;
            if row > 0 {
                let same = match label {
                    Some(_) => label == labels.last().copied(),
                    None => block.continues_dwell(first, row),
                };
                if !same && row >= rows {
                    self.take_back(block);
                    self.ids.pop();
                    self.pending = true;
                    break;
                }
                if !same {
                    (visit, first) = (visit + 1, row);
                }
                block.visit[row] = visit;
            }
            if let Some(label) = label
                && labels.last() != Some(&label)
            {
                self.number_visit(true)?;
                labels.push(label);
            }
        }
        if !labels.is_empty() {
            labels.iter_mut().for_each(|label| *label = self.label(*label));
            check_standstills((block, &self.still), &labels, &self.rows.header)?;
        }
        self.labels = labels;
        if self.count == 0 {
            return Err(self.no_rows());
        }
        Ok(block.len())
    }

    /// What was understood so far; the number of configurations is left at zero.
    pub fn info(&self) -> CsvInfo {
        let columns = self.rows.header.columns.iter().zip(&self.rows.seen);
        let mut visit_labels = self.visits.labels();
        visit_labels.iter_mut().for_each(|label| *label = self.label(*label));
        CsvInfo {
            file: self.source.file().into(),
            map: self.map.clone(),
            columns: columns
                .map(|(column, seen)| ColumnInfo {
                    name: column.name.clone(),
                    unit: column.unit.clone(),
                    unit_given: column.unit_given,
                    meaning: column.meaning.clone(),
                    filled: seen.filled,
                    range: seen.range(),
                })
                .collect(),
            rows: self.count,
            visits: visit_labels.len(),
            configurations: 0,
            grouping: None,
            visit_labels,
            sessions: self.rows.sessions.clone(),
            landmarks: self.rows.landmarks.clone(),
            unmeasured: self.rows.header.unmeasured.is_some(),
            proposal: self.rows.header.proposal.text(),
            ids: self.ids.clone(),
        }
    }

    /// Reads all rows. Visits have the numbers of the whole file, or none where the file numbers none.
    pub(super) fn read_all(&mut self) -> Result<Dataset, IoError> {
        let mut data = Dataset::default();
        self.clear(&mut data);
        let has_ids = self.has_ids();
        self.ids.clear();
        while self.next_row()? {
            let visit = self.number_visit(false)?;
            self.rows.push(visit, &mut data);
            self.keep_id(has_ids);
            if self.count == 1 {
                let rows = self.source.size() as usize / self.first_bytes.max(8) + 1;
                reserve(&mut data, rows.min(1 << 26));
            }
        }
        if self.count == 0 {
            return Err(self.no_rows());
        }
        Ok(data)
    }

    /// What the file calls a visit.
    fn label(&self, label: i64) -> i64 {
        label_in_file(label, self.rows.sessions.len())
    }

    fn no_rows(&self) -> IoError {
        IoError::file(self.source.file(), "has a header but no rows; add at least one row below the header")
    }

    fn next_row(&mut self) -> Result<bool, IoError> {
        let bytes = loop {
            match self.source.row(&mut self.rows) {
                Ok(Some(_)) if self.rows.row.skipped => {}
                Ok(Some(bytes)) => break bytes,
                Ok(None) => {
                    self.rows.exclude.all_met(self.source.file())?;
                    return Ok(false);
                }
                Err(error) if self.rows.failed => return Err(self.all_problems(error)),
                Err(error) => return Err(error),
            }
        };
        if self.count == 0 {
            self.first_bytes = bytes;
        }
        let line = self.rows.row.line;
        self.count += 1;
        let time = self.rows.row.time;
        if time < self.last_time {
            self.backwards.get_or_insert((line, 0)).1 += 1;
        }
        self.last_time = time;
        Ok(true)
    }

    /// The first error of a row, and what is wrong with the rows behind it.
    #[cold]
    fn all_problems(&mut self, first: IoError) -> IoError {
        let mut problems = Problems::default();
        problems.add(first);
        while !problems.enough() {
            self.rows.problems.drain(..).for_each(|error| problems.add(error));
            match self.source.row(&mut self.rows) {
                Ok(Some(_)) => {}
                Ok(None) => break,
                Err(error) => {
                    problems.add(error);
                    if !self.rows.failed {
                        break;
                    }
                }
            }
        }
        problems.into_error(self.rows.header.proposed())
    }

    fn number_visit(&mut self, consecutive: bool) -> Result<usize, IoError> {
        let (Some(label), Some(slot)) = (self.rows.row.visit, self.rows.header.slots.visit) else {
            return Ok(0);
        };
        let (number, new) = self.visits.number(label);
        if consecutive && !new {
            let message = format!(
                "visit {} occurs in several places of the file; sort the rows by visit to read it in blocks",
                self.label(label)
            );
            return Err(self.rows.header.cell_error(self.rows.row.line, slot, message));
        }
        Ok(number)
    }

    fn clear(&self, data: &mut Dataset) {
        data.schema.clone_from(&self.schema);
        data.dwell.clone_from(&self.dwell);
        let columns = |table: &mut Vec<Vec<f64>>, count: usize| {
            table.resize_with(count, Vec::new);
            table.iter_mut().for_each(Vec::clear);
        };
        columns(&mut data.joints, self.joints);
        columns(&mut data.approach, self.joints);
        columns(&mut data.channels, self.schema.channels.len());
        data.position.clear();
        data.orientation.clear();
        data.position_sd.clear();
        data.orientation_sd.clear();
        data.target.clear();
        data.visit.clear();
        data.load.clear();
        data.time.clear();
        data.line.clear();
    }

    fn take_back(&self, data: &mut Dataset) {
        for column in data.joints.iter_mut().chain(&mut data.approach).chain(&mut data.channels) {
            column.pop();
        }
        data.position.pop();
        data.orientation.pop();
        data.position_sd.pop();
        data.orientation_sd.pop();
        data.target.pop();
        data.visit.pop();
        data.load.pop();
        data.time.pop();
        data.line.pop();
    }
}

fn reserve(data: &mut Dataset, rows: usize) {
    for column in data.joints.iter_mut().chain(&mut data.approach).chain(&mut data.channels) {
        column.reserve(rows);
    }
    data.position.reserve(rows);
    data.orientation.reserve(rows);
    data.position_sd.reserve(rows);
    data.orientation_sd.reserve(rows);
    data.target.reserve(rows);
    data.visit.reserve(rows);
    data.load.reserve(rows);
    data.time.reserve(rows);
    data.line.reserve(rows);
}
