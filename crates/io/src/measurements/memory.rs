//! A table in memory: columns under the names that a CSV's header has, `x[mm]` and so on.
//!
//! A NaN and a missing text are an empty cell. Rows count from one, and the names are line 0, as in a Parquet file: `data:7: column `x[mm]` (3): …`
//! is the seventh row.

use super::row::RowReader;
use super::taken::Cell;
use crate::IoError;
use std::path::{Path, PathBuf};

/// A column of a table in memory.
#[derive(Debug, Clone, PartialEq)]
pub enum MemoryColumn {
    /// NaN: empty.
    Numbers(Vec<f64>),
    /// Texts, each stored once.
    Texts {
        /// The texts.
        words: Vec<String>,
        /// Which of them a row has; none: empty.
        rows: Vec<Option<u32>>,
    },
}

impl MemoryColumn {
    fn len(&self) -> usize {
        match self {
            MemoryColumn::Numbers(numbers) => numbers.len(),
            MemoryColumn::Texts { rows, .. } => rows.len(),
        }
    }
}

/// Measurements or poses in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct MemoryTable {
    name: PathBuf,
    names: Vec<String>,
    columns: Vec<MemoryColumn>,
    rows: usize,
}

impl MemoryTable {
    /// Columns with their headers. `name` stands in messages where the name of a file would.
    ///
    /// # Errors
    /// When columns differ in length, or a row has a text that is not there.
    pub fn new(
        name: impl Into<PathBuf>,
        columns: impl IntoIterator<Item = (String, MemoryColumn)>,
    ) -> Result<Self, IoError> {
        let name = name.into();
        let (names, columns): (Vec<String>, Vec<MemoryColumn>) = columns.into_iter().unzip();
        let rows = columns.first().map_or(0, MemoryColumn::len);
        for (k, (header, column)) in names.iter().zip(&columns).enumerate() {
            let wrong = |message: String| {
                let (file, header) = (name.clone(), super::cells::shown(header));
                Err(IoError::Cell { file, line: 0, name: header, number: k + 1, message })
            };
            if column.len() != rows {
                return wrong(format!("has {} rows, and `{}` has {rows}", column.len(), names[0]));
            }
            if let MemoryColumn::Texts { words, rows } = column
                && rows.iter().flatten().any(|&word| word as usize >= words.len())
            {
                return wrong("has a row with a text that is not there".into());
            }
        }
        Ok(MemoryTable { name, names, columns, rows })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The headers.
    pub fn names(&self) -> &[String] {
        &self.names
    }
}

/// A table in memory, row by row.
#[derive(Debug)]
pub(crate) struct MemoryRows {
    table: MemoryTable,
    used: usize,
}

impl MemoryRows {
    pub fn new(table: MemoryTable) -> Self {
        MemoryRows { table, used: 0 }
    }

    /// The names of the columns as the header of a CSV.
    pub fn header(&self) -> Vec<u8> {
        let quoted = |name: &String| format!("\"{}\"", name.replace('"', "\"\""));
        self.table.names.iter().map(quoted).collect::<Vec<_>>().join(",").into_bytes()
    }

    pub fn file(&self) -> &Path {
        &self.table.name
    }

    /// Numbers of rows take the place of bytes.
    pub fn size(&self) -> u64 {
        self.table.rows as u64
    }

    pub fn handed_out(&self) -> u64 {
        self.used as u64
    }

    /// Goes on behind this row.
    pub fn jump(&mut self, to: u64) {
        self.used = usize::try_from(to).unwrap_or(usize::MAX).saturating_add(1).min(self.table.rows);
    }

    /// Reads the next row.
    pub fn row(&mut self, into: &mut RowReader) -> Result<Option<usize>, IoError> {
        let at = self.used;
        if at == self.table.rows {
            return Ok(None);
        }
        self.used += 1;
        let columns = &self.table.columns;
        into.take(self.used as u64, |k| match &columns[k] {
            MemoryColumn::Numbers(numbers) if numbers[at].is_nan() => Cell::Empty,
            MemoryColumn::Numbers(numbers) => Cell::Number(numbers[at]),
            MemoryColumn::Texts { words, rows } => match rows[at] {
                Some(word) => Cell::Text(words[word as usize].as_bytes()),
                None => Cell::Empty,
            },
        })?;
        Ok(Some(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MeasurementsOptions, measurements_in_memory, read_measurements};
    use truepose_kinematics::samples;

    const NAMES: [&str; 10] = [
        "d1[mm]",
        "d2[mm]",
        "d3[mm]",
        "theta[deg]",
        "roll[deg]",
        "pitch[mrad]",
        "x[mm]",
        "y[mm]",
        "z[in]",
        "target",
    ];

    fn table(cells: &[[f64; 9]], targets: &[Option<u32>]) -> MemoryTable {
        let numbers = |k: usize| MemoryColumn::Numbers(cells.iter().map(|row| row[k]).collect());
        let words = vec!["P1".to_string(), "P2".to_string(), "P9".to_string()];
        let texts = MemoryColumn::Texts { words, rows: targets.to_vec() };
        let columns = (0..9).map(numbers).chain([texts]);
        MemoryTable::new("data", NAMES.map(String::from).into_iter().zip(columns)).unwrap()
    }

    #[test]
    fn a_table_and_a_file_are_the_same_data() {
        let cells = [[1., 2., 3., 91.25, 1., 2., 0.1, f64::NAN, 3.], [2., 2., 3., 17.3, 1., 2., 0.7, 2., 4.]];
        let chain = samples::pps();
        let (data, info, _) =
            measurements_in_memory(table(&cells, &[Some(1), None]), &chain, &MeasurementsOptions::default())
                .unwrap();
        let text = format!("{}\n1,2,3,91.25,1,2,0.1,,3,P2\n2,2,3,17.3,1,2,0.7,2,4,\n", NAMES.join(","));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("d.csv");
        std::fs::write(&path, text).unwrap();
        let (mut read, other, _) = read_measurements(&path, &chain, &MeasurementsOptions::default()).unwrap();
        read.line = vec![1, 2];
        assert_eq!(format!("{data:?}"), format!("{read:?}"));
        assert_eq!((info.rows, info.visits, info.columns), (other.rows, other.visits, other.columns));
    }

    #[test]
    fn a_bad_cell_is_named_with_its_row_and_column() {
        let chain = samples::pps();
        let wrong = |column: usize, value: f64, target: u32| {
            let mut cells = [[1., 2., 3., 4., 1., 2., 1., 2., 3.]; 3];
            cells[1][column] = value;
            let table = table(&cells, &[None, Some(target), None]);
            measurements_in_memory(table, &chain, &MeasurementsOptions::default()).unwrap_err().to_string()
        };
        assert_eq!(
            wrong(3, f64::NAN, 0),
            "data:2: column `theta[deg]` (4): is empty; every row needs all joint values"
        );
        assert!(wrong(6, f64::INFINITY, 0).starts_with("data:2: column `x[mm]` (7): is not a finite number"));
        assert!(wrong(6, 1.0, 2).starts_with("data:2: column `target` (10): the robot has no target `P9`"));
    }

    #[test]
    fn columns_of_different_length_are_refused() {
        let columns = [("a".to_string(), vec![1.0]), ("b".to_string(), vec![1.0, 2.0])];
        let columns = columns.map(|(name, numbers)| (name, MemoryColumn::Numbers(numbers)));
        let said = MemoryTable::new("data", columns).unwrap_err().to_string();
        assert_eq!(said, "data:0: column `b` (2): has 2 rows, and `a` has 1");
    }
}
