//! What the program does between reading and writing, for front ends in other languages: the same steps, so that the same bytes come out.

mod campaign;
mod observed;
mod program;

pub use campaign::{Campaign, Fitting, Searched};
pub use observed::plan_observed;
pub use program::{Given, Rewriting, Rewritten, RewrittenFile, rewrite};

use crate::args::ExportFormat;
use crate::failure::Failure;
use crate::library::{Known, ROBOTS};
use crate::recorded;
use crate::verbs::expected::Expected;
use crate::verbs::export::{Wanted, text};
use crate::verbs::installation::Undeclared;
use crate::verbs::mistakes::Mistakes;
use crate::verbs::vertical::settled;
use crate::verbs::{
    beyond, compensate, discover, folds, identified, parameters, predict, sessions, sister, transfer,
};
use crate::verdict::{self, FitVerdict};
use clap::ValueEnum;
use std::path::Path;
use truepose_compensate::{Command, CompensateError, ExportOptions};
use truepose_discover::Progress;
use truepose_errormodel::{AnyEffect, Coverage, Dataset, FittedModel, ModelError};
use truepose_identify::Split;
use truepose_io::{ColumnMap, CsvInfo, ExportUnits, NamedFrame, Poses, Prediction, RobotDetails};
use truepose_kinematics::{Chain, TargetId};
use truepose_report::{
    DataCheck, DiscoverySummary, IdentificationSummary, ParametersSummary, SisterSummary, StreamedSummary,
    TransferSummary,
};
use truepose_solvers::Solver;

/// Records in a fit that `identify` made it with this seed, and what is to be known of it; `held_out` where a test set was drawn first.
pub fn identified(fitted: &mut FittedModel, summary: &IdentificationSummary, seed: u64, held_out: bool) {
    identified::whole(fitted, summary, seed, held_out);
}

/// Records in a fit that `identify --stream` made it, and what is to be known of it.
pub fn streamed(fitted: &mut FittedModel, summary: &StreamedSummary, converged: bool) {
    identified::streamed(fitted, summary, converged);
}

/// Records in a fit that `discover` made it; `all_rows` where its coefficients are those of all rows.
pub fn discovered(fitted: &mut FittedModel, solver: &str, rows: usize, seed: u64, all_rows: bool) {
    discover::Origin { solver: solver.into(), rows, seed }.write(fitted, all_rows);
}

/// Records in a fit what is to be known of it after a completed search.
pub fn verdict_of_search(fitted: &mut FittedModel, summary: &DiscoverySummary, converged: bool) {
    FitVerdict::discovered(summary, converged).record(fitted);
}

/// Records in a transferred fit where it comes from, and whether the arm fits there.
pub fn transferred(made: &mut FittedModel, summary: &TransferSummary, update: bool, rows: usize) {
    transfer::record(made, summary, update, rows);
}

/// Warnings about a fit that is used.
///
/// # Errors
/// When it does not fit its own measurements, or predicts unseen poses worse than base and tool alone, and is not accepted all the same.
pub fn marks(fitted: &FittedModel, accepted: bool) -> Result<Vec<String>, String> {
    verdict::marks(fitted, accepted)
}

/// Records units and frames of a robot's description in a fit.
pub fn record_details(fitted: &mut FittedModel, details: &RobotDetails) {
    parameters::record(fitted, details);
}

/// Records in a fit which column of its data was which; nothing where nothing was said of them.
pub fn record_columns(fitted: &mut FittedModel, map: &ColumnMap) {
    recorded::record_columns(fitted, map);
}

/// The columns of the data of a fit, for other files of the same robot.
pub fn recorded_columns(fitted: &FittedModel) -> ColumnMap {
    recorded::recorded_columns(fitted)
}

/// Units and frames that a fit has recorded.
pub fn recorded_details(fitted: &FittedModel) -> (ExportUnits, Vec<NamedFrame>) {
    (parameters::units(fitted), parameters::recorded_frames(fitted))
}

/// The parameters of a fit in the convention and the units of the robot's description, or why there are none.
pub fn parameters(fitted: &FittedModel) -> ParametersSummary {
    parameters::parameters(&fitted.clone().of_robot())
}

/// How a split makes its folds, in words.
pub fn split_words(split: &Split) -> String {
    folds::split_words(split)
}

/// A step of a discovery, in words.
pub fn progress_words(step: &Progress) -> String {
    discover::progress_text(step)
}

/// The robot of a URDF for measurements of an instrument, with its base and its tool as unknown where that is `undeclared`; and that in words.
/// `None` where nothing is unknown, or no instrument measured.
///
/// # Errors
/// When a pose of the robot is not finite.
pub fn opened(
    chain: &Chain,
    data: &Dataset,
    undeclared: [bool; 2],
) -> Result<Option<(Chain, String)>, String> {
    let [base, tool] = undeclared;
    Undeclared { base, tool }.unknown(chain, data).map_err(|failure| failure.to_string())
}

/// What seems wrong with measurements, in words with this name of the data, and the rows without those in which one mistake is known: none where all
/// are used. As `identify` and `discover` take measured poses of one installation.
pub fn checked(chain: &Chain, data: &Dataset, name: &Path) -> (Option<Dataset>, DataCheck) {
    Mistakes::of(chain, data, name).set_aside(data)
}

/// The same of rows that are all used.
pub fn suspected(chain: &Chain, data: &Dataset, name: &Path) -> DataCheck {
    Mistakes::of(chain, data, name).check()
}

/// The robot with the direction of gravity that its measurements support, and which, in words: for a description that does not state it. `None` where it does not matter.
///
/// # Errors
/// When base and tool cannot be found, or a fit fails.
pub fn vertical(
    (chain, effects): (&Chain, &[Box<dyn AnyEffect>]),
    data: &Dataset,
    fit: Fitting<'_>,
) -> Result<Option<(Chain, String)>, String> {
    settled(chain, effects, data, fit).map_err(|error| error.to_string())
}

/// Channels that a search tests as one, in words; none where all differ.
pub fn repeated_channels(data: &Dataset, name: &str) -> Option<String> {
    discover::repeated(data, Path::new(name))
}

/// Predictions of all rows.
#[derive(Debug)]
pub struct Predicted {
    /// One for each row.
    pub rows: Vec<Prediction>,
    /// Warnings about targets that the data of the fit does not have.
    pub warnings: Vec<String>,
}

/// Predicts every row of a table; a fit of several sessions in the session of each row.
///
/// # Errors
/// When the data lacks a signal of the model or the name of a session, or a target's position is not known.
pub fn predict(fitted: &FittedModel, data: &Dataset, info: &CsvInfo) -> Result<Predicted, String> {
    let warnings = predict::targets_seen(fitted, data)?;
    if fitted.sessions.is_empty() {
        let words = |error: ModelError| error.to_string();
        let inputs = data.derived_for(fitted.model()).map_err(words)?;
        let coverage = Coverage::new(fitted, &inputs.schema).map_err(words)?;
        let rows = predict::predict(fitted, &coverage, &inputs).0;
        return Ok(Predicted { rows, warnings });
    }
    let mut data = data.clone();
    let found = predict::in_sessions(fitted, &mut data, info, None, &info.file);
    Ok(Predicted { rows: found.map_err(Failure::message)?.predicted, warnings })
}

/// A fit of several sessions in one of them; of one installation itself.
///
/// # Errors
/// When the fit has no session of this name.
pub fn in_session(fitted: &FittedModel, name: &str) -> Result<FittedModel, String> {
    sessions::chosen(fitted.clone(), Some(name), false).map_err(Failure::message)
}

/// A fit of several sessions in the first of them; of one installation itself.
///
/// # Errors
/// When the fit cannot be carried there.
pub fn in_first_session(fitted: &FittedModel) -> Result<FittedModel, String> {
    sessions::chosen(fitted.clone(), None, true).map_err(Failure::message)
}

/// A robot from few poses with its sisters as prior ([`truepose_upkeep::fleet`]), as `identify --prior FLEET`.
///
/// # Errors
/// When the fleet is of another robot or model, or the rows are too few.
pub fn sister(
    prior: &FittedModel,
    chain: &Chain,
    data: &Dataset,
    split: &Split,
    solver: &dyn Solver,
) -> Result<(FittedModel, SisterSummary), String> {
    sister::identified(prior, chain, data, split, solver)
}

/// Robots of the library: name, title, and description as a robot file.
pub fn robots() -> impl Iterator<Item = (&'static str, &'static str, &'static str)> {
    ROBOTS.iter().map(|robot| (robot.name, robot.title(), robot.text))
}

/// Names of robots of the library that contain a word, or begin as it does.
pub fn robots_near(word: &str) -> Vec<&'static str> {
    Known::near(word)
}

/// The command for a desired pose, and its expected accuracy.
#[derive(Debug, Clone)]
pub struct Commanded {
    /// The command.
    pub command: Command,
    /// Distance from the desired position within which the point lies with 95 % probability, m.
    pub within_95: f64,
    /// Whether the command is corrected; else it is that of the nominal robot, where that is expected to be more accurate.
    pub corrected: bool,
    /// Inputs beyond the data of the fit, in words; empty: none.
    pub beyond: String,
}

/// Commands for desired poses. `fitted` is that of the robot alone ([`FittedModel::of_robot`]).
///
/// # Errors
/// When a signal that the model needs is missing, or the robot has too many joints.
pub fn command(fitted: &FittedModel, poses: &mut Poses, hold: &[String]) -> Result<Vec<Commanded>, String> {
    let hold = compensate::held(fitted, hold, poses).map_err(|words| format!("hold: {words}"))?;
    let sought = compensate::Sought { hold, ..compensate::Sought::default() };
    let words = |error: CompensateError| error.to_string();
    let (commands, expected) = compensate::commanded(fitted, poses, &sought, &|| ()).map_err(words)?;
    let rows = poses.rows.derived_for(fitted.model()).map_err(|error| error.to_string())?;
    let channels = rows.schema.channels.clone();
    let one = |(command, Expected { within_95, corrected, beyond, .. }): (Command, Expected)| {
        let beyond = beyond::words(&beyond, fitted.chain(), &channels);
        Commanded { command, within_95, corrected, beyond }
    };
    Ok(commands.into_iter().zip(expected).map(one).collect())
}

/// Whether a target's position and, where it is wanted, the tool's orientation are known to a fit; a warning where they were only declared.
///
/// # Errors
/// When one was to be estimated from data that does not determine it.
pub fn known(fitted: &FittedModel, target: Option<TargetId>, oriented: bool) -> Result<Vec<String>, String> {
    let mut warnings: Vec<String> = beyond::seen(fitted, target)?.into_iter().collect();
    if oriented {
        warnings.extend(beyond::oriented(fitted)?);
    }
    Ok(warnings)
}

/// A file of the fitted geometry.
#[derive(Debug, Clone)]
pub struct ExportedText {
    /// Its text.
    pub text: String,
    /// What it is and what it leaves out.
    pub statement: Vec<String>,
}

/// What a file of the fitted geometry is to be.
#[derive(Debug, Clone, Copy)]
pub struct ExportTo<'a> {
    /// `urdf`, `dh`, `mdh`, `ros`, `ros-yaml` or `iso230`.
    pub format: &'a str,
    /// The target at which the remaining error is computed.
    pub target: Option<TargetId>,
    /// A URDF whose joint origins are corrected in place.
    pub urdf: Option<&'a Path>,
    /// Nearly parallel axes may use Hayati's parameter.
    pub hayati: bool,
    /// Values of each joint in `iso230`.
    pub entries: usize,
    /// Of `ros-yaml`: `ur`, `franka`, `flexiv` or `xarm`.
    pub style: Option<&'a str>,
}

/// The fitted geometry as the text of a file.
///
/// # Errors
/// When the format is not known or cannot hold the model, or is less accurate than the nominal geometry.
pub fn export(fitted: &FittedModel, to: ExportTo<'_>) -> Result<ExportedText, String> {
    let ExportTo { target, urdf, hayati, entries, .. } = to;
    let format: ExportFormat = named("format", to.format)?;
    let style = to.style.map(|style| named("style", style)).transpose()?;
    let options = ExportOptions { target, ..ExportOptions::default() };
    let wanted = Wanted { format, urdf, hayati, entries, style, like: None, hash: None };
    match text(&wanted, &fitted.clone().of_robot(), &options).map_err(|failure| failure.message())? {
        Some(written) => Ok(ExportedText { text: written.text, statement: written.statement }),
        None => Err("the parameters as described are a table; see `parameters`".into()),
    }
}

/// A word of an option.
fn named<T: ValueEnum>(what: &str, word: &str) -> Result<T, String> {
    T::from_str(word, false).map_err(|_| {
        let names = T::value_variants().iter().filter_map(ValueEnum::to_possible_value);
        let known: Vec<String> = names.map(|known| known.get_name().to_owned()).collect();
        format!("unknown {what} `{word}` (known: {})", known.join(", "))
    })
}
