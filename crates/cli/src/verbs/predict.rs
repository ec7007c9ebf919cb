//! `truepose predict`: the position of the real robot, from a fit.

use super::reporting::Folder;
use super::sessions::{Part, parts};
use super::{about, beyond, print_json};
use crate::args::Predict;
use crate::extensions::effects;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::terminal;
use crate::verdict::usable;
use crate::watch::Watch;
use rayon::prelude::*;
use std::borrow::Cow;
use std::path::Path;
use truepose_compensate::radius_95;
use truepose_errormodel::{Coverage, Dataset, FittedModel, SESSION};
use truepose_identify::{Residuals, Spread, Tally};
use truepose_io::{
    CsvInfo, MeasurementsOptions, MeasurementsReader, Prediction, PredictionsWriter, Repeated, WholeFiles,
    check_writable, read_fit, read_measurements, write_predictions,
};
use truepose_kinematics::nalgebra::Matrix3;
use truepose_kinematics::{Chain, Conditions};
use truepose_report::{
    OrientationStatistics, PositionStatistics, PredictionView, count, prediction_report, significant,
};

/// Files from this size on, bytes, are read block by block where the model allows it.
const LARGE: u64 = 32 << 20;
/// Rows of a block.
const BLOCK: usize = 16384;
/// Up to so many rows quantiles are exact.
const EXACT: usize = 1 << 20;
/// Rows that one thread takes at a time.
const CHUNK: usize = 256;

/// Runs the verb.
pub fn run(args: &Predict, watch: &Watch) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let folder = Folder::with_head(args.report.as_ref(), "prediction.json", args.certificate.as_ref())?;
    let fitted = usable(&args.fit, read_fit(&args.fit, effects())?, args.accept.accept)?;
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
    let Inside { predicted, beyond, residuals } =
        in_sessions(&fitted, &mut data, &info, args.session.as_deref(), &args.data)?;
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

/// Predictions of all rows, each in the session of its row.
#[derive(Debug, Default)]
pub(crate) struct Inside {
    /// In the order of the rows.
    pub predicted: Vec<Prediction>,
    /// Inputs beyond the data of the fit.
    pub beyond: beyond::Tally,
    /// Of rows that were measured.
    pub residuals: Residuals,
}

/// Predicts every row in its session; `session` is one for all of them. The rows lose their sessions.
pub(crate) fn in_sessions(
    fitted: &FittedModel,
    data: &mut Dataset,
    info: &CsvInfo,
    session: Option<&str>,
    file: &Path,
) -> Result<Inside, Failure> {
    let parts = parts(fitted, data, info, session, file)?;
    let Inside { mut predicted, mut beyond, mut residuals } = Inside::default();
    for part in &parts {
        let here = data.select(&part.rows);
        let inputs = here.derived_for(part.fitted.model()).map_err(about(file))?;
        let coverage = Coverage::new(&part.fitted, &inputs.schema).map_err(about(file))?;
        let (some, of_part) = predict(&part.fitted, &coverage, &inputs);
        beyond.join(&of_part);
        predicted.extend(some);
        let of_part = Residuals::of(&part.fitted, &here)?;
        residuals.position.extend(of_part.position);
        residuals.orientation.extend(of_part.orientation);
    }
    in_order(&parts, &mut predicted);
    in_order(&parts, &mut residuals.position);
    in_order(&parts, &mut residuals.orientation);
    Ok(Inside { predicted, beyond, residuals })
}

/// Brings values that stand session by session into the order of the rows.
fn in_order<T>(parts: &[Part], values: &mut Vec<T>) {
    let rows = parts.iter().flat_map(|part| part.rows.iter().copied());
    let mut numbered: Vec<(usize, T)> = rows.zip(values.drain(..)).collect();
    numbered.sort_by_key(|(row, _)| *row);
    values.extend(numbered.into_iter().map(|(_, value)| value));
}

/// Warnings about targets that were not measured in the data of the fit.
///
/// # Errors
/// When the place of one is not known; names its first line.
pub(crate) fn targets_seen(fitted: &FittedModel, data: &Dataset) -> Result<Vec<String>, String> {
    let mut warnings = Vec::new();
    let mut done = Vec::new();
    for (row, &target) in data.target.iter().enumerate().filter(|_| !fitted.domain.targets.is_empty()) {
        if !done.contains(&target) {
            done.push(target);
            let line = data.line.get(row).map_or(String::new(), |line| format!("line {line}: "));
            warnings.extend(beyond::seen(fitted, target).map_err(|words| format!("{line}{words}"))?);
        }
    }
    Ok(warnings)
}

/// Every row, in order, and what of it lies beyond the data of the fit.
pub(crate) fn predict(
    fitted: &FittedModel,
    coverage: &Coverage<'_>,
    inputs: &Dataset,
) -> (Vec<Prediction>, beyond::Tally) {
    let oriented = beyond::oriented(fitted).is_ok();
    let noise = Matrix3::identity() * fitted.noise.position_sd.powi(2);
    let rows: Vec<usize> = (0..inputs.len()).collect();
    let parts: Vec<(Vec<Prediction>, beyond::Tally)> = rows
        .par_chunks(CHUNK)
        .map(|rows| {
            let mut coverage = coverage.clone();
            let mut conditions = Conditions::default();
            let mut tally = beyond::Tally::default();
            let one = |&row: &usize| {
                inputs.conditions_into(row, &mut conditions);
                let judged = coverage.judge(&conditions, inputs.target[row]);
                tally.add(&judged.beyond);
                let within_95 = match fitted.determines(inputs.target[row]) {
                    true => radius_95(&(judged.covariance + noise)),
                    false => f64::INFINITY,
                };
                Prediction { pose: judged.pose, oriented, within_95, extrapolates: !judged.beyond.is_empty() }
            };
            let predicted = rows.iter().map(one).collect();
            (predicted, tally)
        })
        .collect();
    let (mut all, mut tally) = (Vec::with_capacity(rows.len()), beyond::Tally::default());
    for (predicted, some) in parts {
        all.extend(predicted);
        tally.join(&some);
    }
    (all, tally)
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
        let (predicted, some) = predict(fitted, &coverage, &block);
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
        beyond.warn("row", chain, &inputs.schema.channels);
        if fitted.domain.joints.is_empty() {
            terminal::log(
                "warning: the fit does not record the range of its data: extrapolation is not detected",
            );
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
