//! Where a reader of measurements gets its rows: a file, or a table in memory.

use super::header::Needs;
use super::mapping::ColumnMap;
use super::memory::MemoryTable;
use super::names::Names;
use super::reader::{MeasurementsOptions, MeasurementsReader};
use super::sampled::Sample;
use super::source::Source;
use crate::IoError;
use std::path::Path;
use truepose_errormodel::DwellTolerance;
use truepose_kinematics::Chain;

impl MeasurementsReader {
    /// Opens a file and reads its header.
    ///
    /// # Errors
    /// When the file cannot be read or its header does not make sense.
    pub fn open(
        path: impl AsRef<Path>,
        chain: &Chain,
        options: &MeasurementsOptions,
    ) -> Result<Self, IoError> {
        let needs = Needs { joints: true, measured: options.measured_required, position: false };
        MeasurementsReader::open_for(path.as_ref(), chain, needs, options.dwell, &options.columns)
    }

    /// Reads a table in memory, block by block.
    ///
    /// # Errors
    /// When its headers do not make sense.
    pub fn in_memory(
        table: MemoryTable,
        chain: &Chain,
        options: &MeasurementsOptions,
    ) -> Result<Self, IoError> {
        let needs = Needs { joints: true, measured: options.measured_required, position: false };
        MeasurementsReader::over_for(table, chain, needs, options.dwell, &options.columns)
    }

    pub(crate) fn open_for(
        path: &Path,
        chain: &Chain,
        needs: Needs,
        dwell: DwellTolerance,
        columns: &ColumnMap,
    ) -> Result<Self, IoError> {
        let opened = Source::open(path, &Names { chain, map: columns })?;
        MeasurementsReader::begin(path, opened, chain, needs, dwell, columns)
    }

    pub(crate) fn over_for(
        table: MemoryTable,
        chain: &Chain,
        needs: Needs,
        dwell: DwellTolerance,
        columns: &ColumnMap,
    ) -> Result<Self, IoError> {
        let source = Source::memory(table);
        let name = source.file().to_path_buf();
        MeasurementsReader::begin(
            &name,
            (source, Sample::default(), Vec::new()),
            chain,
            needs,
            dwell,
            columns,
        )
    }
}
