//! `truepose predict`: where the real robot is, from a fit.

use super::{about, print_json};
use crate::args::Predict;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::terminal;
use std::borrow::Cow;
use truepose_errormodel::{Dataset, EffectRegistry, FittedModel, ModelError};
use truepose_identify::{Residuals, Tally};
use truepose_io::{
    MeasurementsOptions, MeasurementsReader, PredictionsWriter, check_writable, read_fit, read_measurements,
    write_predictions,
};
use truepose_kinematics::{Conditions, Pose};
use truepose_report::{PositionSpread, RotationSpread, count, significant};

/// Files from this size on, bytes, are read block by block where the model allows it.
const LARGE: u64 = 32 << 20;
/// Rows of a block.
const BLOCK: usize = 16384;
/// Up to so many rows quantiles are exact.
const EXACT: usize = 1 << 20;

/// Runs the verb.
pub fn run(args: &Predict) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let fitted = read_fit(&args.fit, &EffectRegistry::builtin())?;
    let options = args.grouped.conditions();
    if let Some(said) = by_blocks(args, &fitted, &options) {
        return said.print(args);
    }
    let (data, info, warnings) = read_measurements(&args.data, fitted.chain(), &options)?;
    terminal::warn(&warnings);
    let predicted = predict(&fitted, &data).map_err(about(&args.data))?;
    write_predictions(&args.out, fitted.chain(), &data, &info, &predicted)?;
    let residuals = Residuals::of(&fitted, &data)?;
    let (position, orientation) = (residuals.positions().into(), residuals.orientations().into());
    Said { rows: data.len(), position, orientation }.print(args)
}

fn predict(fitted: &FittedModel, data: &Dataset) -> Result<Vec<Pose>, ModelError> {
    let inputs = data.derived_for(fitted.model())?;
    let mut predictor = fitted.bind(&inputs.schema)?;
    let mut conditions = Conditions::default();
    let one = |row| {
        inputs.conditions_into(row, &mut conditions);
        predictor.predict(&conditions, data.target[row])
    };
    Ok((0..data.len()).map(one).collect())
}

/// A large file, a block at a time, in memory that does not grow with it. None where the file is small, has to be seen whole (a channel that
/// lags, directions of approach from the order of its visits, visits in several places), or is wrong: then it is read whole.
fn by_blocks(args: &Predict, fitted: &FittedModel, options: &MeasurementsOptions) -> Option<Said> {
    let chain = fitted.chain();
    let mut reader = MeasurementsReader::open(&args.data, chain, options).ok()?;
    let size = reader.progress().1;
    let empty = Dataset { schema: reader.schema().clone(), ..Dataset::default() };
    let known = fitted.bind(reader.schema()).is_ok();
    if size < LARGE || !known || matches!(empty.derived_for(fitted.model()), Err(_) | Ok(Cow::Owned(_))) {
        return None;
    }
    let progress = Progress::bytes(size);
    progress.say("predicting");
    let (visits, targets) = reader.names();
    let mut file = PredictionsWriter::create(&args.out, chain, visits, targets).ok()?;
    let (mut position, mut orientation) = (Tally::keeping(EXACT), Tally::keeping(EXACT));
    let (mut block, mut rows) = (Dataset::default(), 0);
    while reader.read_block(BLOCK, &mut block).ok()? > 0 {
        file.write(&block, reader.block_labels(), &predict(fitted, &block).ok()?).ok()?;
        let residuals = Residuals::of(fitted, &block).ok()?;
        position.add((0..block.len()).filter_map(|row| residuals.distance(row)));
        orientation.add(residuals.orientation.iter().flatten().map(|turn| turn.norm()));
        rows += block.len();
        progress.at(reader.progress().0);
    }
    file.finish().ok()?;
    terminal::warn(&reader.warnings(chain));
    Some(Said { rows, position: position.spread().into(), orientation: orientation.spread().into() })
}

/// What is said of predictions.
struct Said {
    rows: usize,
    position: PositionSpread,
    orientation: RotationSpread,
}

impl Said {
    fn print(&self, args: &Predict) -> Result<(), Failure> {
        let Said { rows, position, orientation } = self;
        if args.json {
            return print_json(&serde_json::json!({
                "rows": rows, "position": position, "orientation": orientation,
            }));
        }
        terminal::print(&format!("{} predicted, written to {}\n", count(*rows, "row"), args.out.display()));
        if position.count > 0 {
            terminal::print(&format!(
                "against the measured positions: RMS {} mm, 95 % {} mm, max {} mm ({})\n",
                significant(position.rms_mm, 4),
                significant(position.p95_mm, 4),
                significant(position.max_mm, 4),
                count(position.count, "row")
            ));
        }
        if orientation.count > 0 {
            terminal::print(&format!(
                "against the measured orientations: RMS {} mrad\n",
                significant(orientation.rms_mrad, 4)
            ));
        }
        Ok(())
    }
}
