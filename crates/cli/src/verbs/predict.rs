//! `truepose predict`: the position of the real robot, from a fit.

use super::reporting::Folder;
use super::{print_json, usable_fit};
use crate::args::Predict;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::terminal;
use crate::watch::Watch;
use std::borrow::Cow;
use std::path::Path;
use truepose_errormodel::{Coverage, Dataset, FittedModel, SESSION};
use truepose_identify::{Residuals, Spread, Tally};
use truepose_io::{
    MeasurementsOptions, MeasurementsReader, PredictionsWriter, Repeated, WholeFiles, check_writable,
    read_measurements, write_predictions,
};
use truepose_kinematics::Chain;
use truepose_report::{
    OrientationStatistics, PositionStatistics, PredictionView, count, prediction_report, significant,
};
use truepose_workflow::{Predicted, beyond, predict, predict_rows, targets_seen};

/// Files from this size on, bytes, are read block by block where the model allows it.
const LARGE: u64 = 32 << 20;
/// Rows of a block.
const BLOCK: usize = 16384;
/// Up to so many rows quantiles are exact.
const EXACT: usize = 1 << 20;

/// Runs the verb.
pub fn run(args: &Predict, watch: &Watch) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let folder = Folder::with_head(args.report.as_ref(), "prediction.json", args.certificate.as_ref())?;
    let fitted = usable_fit(&args.fit, &args.accept)?;
    let options = args.grouped.conditions_for(&fitted);
    // The page shows every row.
    if folder.is_none()
        && fitted.sessions.is_empty()
        && let Some(done) = by_blocks(args, &fitted, &options, watch)
    {
        return done;
    }
    let (mut data, info, warnings) = read_measurements(&args.data, fitted.chain(), &options)?;
    terminal::warn(&warnings);
    let warnings = targets_seen(&fitted, &data)
        .map_err(|words| Failure::Input(format!("{}: {words}", args.data.display())))?;
    terminal::warn(&warnings);
    let sessions = data.sessions().map(<[f64]>::to_vec);
    let Predicted { predicted, beyond, residuals } =
        predict(&fitted, &mut data, &info, args.session.as_deref(), &args.data)?;
    let (position, orientation) = (residuals.positions(), residuals.orientations());
    if let Some(folder) = &folder {
        let view = PredictionView {
            robot: fitted.chain().name().into(),
            rows: data.len(),
            extrapolating: beyond.beyond(),
            position: (position.count > 0).then(|| position.into()),
            within_95_mm: predicted
                .iter()
                .map(|p| 1e3 * beyond::bounded(p.within_95).unwrap_or(f64::NAN))
                .collect(),
            error_mm: (0..data.len()).map(|row| residuals.distance(row).map(|d| 1e3 * d)).collect(),
        };
        let mut files = WholeFiles::default();
        let inputs: Vec<&Path> = [Some(&args.fit), Some(&args.data), args.certificate.as_ref()]
            .into_iter()
            .flatten()
            .map(|file| &**file)
            .collect();
        folder.add(&mut files, &view, &inputs, |run| Ok(prediction_report(&view, run)))?;
        files.finish()?;
        terminal::log(&format!("wrote {}", folder.page().display()));
    }
    let unbounded = predicted.iter().filter(|p| p.within_95 == f64::INFINITY).count();
    terminal::warn(beyond::unbounded(unbounded, "row").as_slice());
    data.set_sessions(sessions);
    write_predictions(&args.out, fitted.chain(), &data, &info, &predicted)?;
    Outcome { rows: data.len(), position, orientation, beyond }.print(args, &fitted, &data)
}

/// A large file, a block at a time, in memory that does not grow with it. None where the file is small, has to be read whole (a channel that
/// lags, directions of approach from the order of its visits, visits in several places), or is wrong: then it is read whole.
fn by_blocks(
    args: &Predict,
    fitted: &FittedModel,
    options: &MeasurementsOptions,
    watch: &Watch,
) -> Option<Result<(), Failure>> {
    let chain = fitted.chain();
    // A pipe can be read only once, and has no size.
    if !args.data.is_file() {
        return None;
    }
    let mut reader = MeasurementsReader::open(&args.data, chain, options).ok()?;
    let size = reader.progress().1;
    let empty = Dataset { schema: reader.schema().clone(), ..Dataset::default() };
    let known = fitted.bind(reader.schema()).is_ok() && reader.schema().channel(SESSION).is_none();
    if size < LARGE || !known || matches!(empty.derived_for(fitted.model()), Err(_) | Ok(Cow::Owned(_))) {
        return None;
    }
    let coverage = Coverage::new(fitted, reader.schema()).ok()?;
    let progress = Progress::bytes(size, watch);
    progress.show("predicting");
    let (visits, targets) = reader.names();
    let repeated = Repeated { ids: reader.has_ids(), visits, targets, sessions: false };
    let mut file = PredictionsWriter::create(&args.out, chain, repeated).ok()?;
    let (mut position, mut orientation) = (Tally::keeping(EXACT), Tally::keeping(EXACT));
    let (mut block, mut rows) = (Dataset::default(), 0);
    let (mut beyond, mut warnings, mut unbounded) = (beyond::Tally::default(), Vec::new(), 0);
    while reader.read_block(BLOCK, &mut block).ok()? > 0 {
        for warning in targets_seen(fitted, &block).ok()? {
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
        let (predicted, some) = predict_rows(fitted, &coverage, &block);
        beyond.join(&some);
        unbounded += predicted.iter().filter(|p| p.within_95 == f64::INFINITY).count();
        file.write(&block, (reader.block_labels(), reader.block_ids()), &predicted).ok()?;
        let residuals = Residuals::of(fitted, &block).ok()?;
        position.add((0..block.len()).filter_map(|row| residuals.distance(row)));
        orientation.add(residuals.orientation.iter().flatten().map(|turn| turn.norm()));
        rows += block.len();
        progress.at(reader.progress().0);
    }
    file.finish().ok()?;
    terminal::warn(&reader.warnings(chain));
    terminal::warn(&warnings);
    terminal::warn(beyond::unbounded(unbounded, "row").as_slice());
    let outcome = Outcome { rows, position: position.spread(), orientation: orientation.spread(), beyond };
    Some(outcome.print(args, fitted, &empty))
}

/// Statistics of predictions for the terminal.
struct Outcome {
    rows: usize,
    position: Spread,
    orientation: Spread,
    beyond: beyond::Tally,
}

impl Outcome {
    fn print(&self, args: &Predict, fitted: &FittedModel, inputs: &Dataset) -> Result<(), Failure> {
        let Outcome { rows, beyond, .. } = self;
        let chain: &Chain = fitted.chain();
        terminal::warn(beyond.warning("row", chain, &inputs.schema.channels).as_slice());
        if fitted.domain.joints.is_empty() {
            terminal::warn(&[beyond::NO_RANGE]);
        }
        // An orientation that the fit does not determine is not compared.
        let known = beyond::oriented(fitted);
        let orientation = if known == Ok(None) { self.orientation } else { Spread::default() };
        match &known {
            Err(words) => terminal::log(&format!("warning: {words}; the cells of the orientation are empty")),
            Ok(Some(words)) if self.orientation.count > 0 => {
                terminal::log(&format!("warning: orientations are not compared: {words}"));
            }
            _ => {}
        }
        let (position, orientation): (PositionStatistics, OrientationStatistics) =
            (self.position.into(), orientation.into());
        if args.json {
            return print_json(&serde_json::json!({
                "rows": rows, "position": position, "orientation": orientation, "extrapolating": beyond.beyond(),
            }));
        }
        terminal::print(&format!("{} predicted, written to {}\n", count(*rows, "row"), args.out.display()));
        if position.count > 0 {
            terminal::print(&format!(
                "error against the measured positions: RMS {} mm, 95th percentile {} mm, max {} mm ({})\n",
                significant(position.rms_mm, 3),
                significant(position.p95_mm, 3),
                significant(position.max_mm, 3),
                count(position.count, "row")
            ));
        }
        if orientation.count > 0 {
            terminal::print(&format!(
                "error against the measured orientations: RMS {} mrad\n",
                significant(orientation.rms_mrad, 3)
            ));
        }
        Ok(())
    }
}
