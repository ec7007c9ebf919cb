//! Identification of files that are larger than memory: read block by block, several times.

use super::criteria::require;
use super::print_json;
use crate::args::Identify;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::terminal;
use crate::watch::Watch;
use std::path::Path;
use truepose_errormodel::{AnyEffect, Dataset, LANDMARK, SESSION};
use truepose_identify::{IdentifyError, Source, StreamedOptions, identify_streamed};
use truepose_io::{IoError, MeasurementsOptions, MeasurementsReader, sample_measurements, write_fit};
use truepose_kinematics::Chain;
use truepose_report::StreamedSummary;
use truepose_workflow::{about_rows, record_columns, record_streamed};

/// Rows of a block: some megabytes, and work enough for every fold.
const BLOCK: usize = 16384;

/// Runs the verb.
pub fn identify(
    args: &Identify,
    chain: &Chain,
    effects: &[Box<dyn AnyEffect>],
    watch: &Watch,
) -> Result<(), Failure> {
    let data = &args.measured.data;
    if data.metadata().is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return Err(Failure::Input(format!(
            "--stream: reads the data several times, and `{}` can be read only once; leave --stream out",
            data.display()
        )));
    }
    let options = StreamedOptions { fit: args.fit(), folds: args.folds };
    if args.folds == 1 {
        return Err(Failure::Input(
            "--folds: one fold leaves no data to fit; use 2 or more, or 0 for none".into(),
        ));
    }
    let reading = args.measured.files(args.positions_only).reading()?;
    let schema = MeasurementsReader::open(data, chain, &reading)?.schema().clone();
    if let Some(column) = [SESSION, LANDMARK].into_iter().find(|name| schema.channel(name).is_some()) {
        let words = format!("--stream: a column `{}` needs the whole file", column.trim_end_matches('~'));
        return Err(Failure::Input(format!("{}: {words}; leave --stream out", data.display())));
    }
    let solver = args.solver.build();
    let mut file = Table {
        path: &args.measured.data,
        chain,
        reading,
        positions_only: args.positions_only,
        passes: 0,
        watch,
    };
    let mut found =
        identify_streamed(chain, effects, &mut file, &*solver, &options).map_err(|error| match error {
            Wrong::Reading(error) => Failure::from(error),
            Wrong::Identifying(error) => about_rows(data, error).into(),
        })?;
    let summary = StreamedSummary::new(&found, &args.solver.to_string());
    if args.json {
        print_json(&summary)?;
    } else {
        terminal::print(&summary.to_string());
    }
    if let Some(out) = &args.out {
        let converged = found.fit.converged;
        record_streamed(&mut found.fit.fitted, &summary, converged);
        record_columns(&mut found.fit.fitted, &file.reading.columns);
        write_fit(out, &found.fit.fitted)?;
        terminal::log(&format!("wrote {}", out.display()));
    }
    let judged = summary.held_out.unwrap_or(summary.train);
    require(args, judged.rms_mm * 1e-3, judged.count)
}

/// A file of measurements.
struct Table<'a> {
    path: &'a Path,
    chain: &'a Chain,
    reading: MeasurementsOptions,
    positions_only: bool,
    passes: usize,
    watch: &'a Watch,
}

/// What goes wrong with one.
enum Wrong {
    Reading(IoError),
    Identifying(IdentifyError),
}

impl From<IdentifyError> for Wrong {
    fn from(error: IdentifyError) -> Self {
        Wrong::Identifying(error)
    }
}

impl From<IoError> for Wrong {
    fn from(error: IoError) -> Self {
        Wrong::Reading(error)
    }
}

impl Source for Table<'_> {
    type Error = Wrong;

    fn sample(&mut self, rows: usize) -> Result<Dataset, Wrong> {
        let mut sample = sample_measurements(self.path, self.chain, &self.reading, rows)?;
        if self.positions_only {
            sample.orientation.fill(None);
        }
        Ok(sample)
    }

    fn each(&mut self, take: &mut dyn FnMut(&Dataset) -> Result<(), IdentifyError>) -> Result<(), Wrong> {
        let mut reader = MeasurementsReader::open(self.path, self.chain, &self.reading)?;
        self.passes += 1;
        let progress = Progress::bytes(reader.progress().1, self.watch);
        progress.show(if self.passes == 1 { "fitting" } else { "computing residuals" });
        let mut block = Dataset::default();
        while reader.read_block(BLOCK, &mut block)? > 0 {
            if self.positions_only {
                block.orientation.fill(None);
            }
            take(&block)?;
            progress.at(reader.progress().0);
        }
        if self.passes == 1 {
            terminal::warn(&reader.warnings(self.chain));
        }
        Ok(())
    }
}
