//! Results of each verb for a robot, compared with the truth at other configurations.
//!
//! | figure | of |
//! | --- | --- |
//! | nominal | the robot as described, base, tool and targets fitted to the rows that were measured |
//! | constants | `identify` with the default model (`geometric`), pivoted QR; `predict` of its fit is the same |
//! | tukey, huber, ridge | `identify --solver …` |
//! | discover | `discover`; `predict` of its fit is the same |
//! | export | geometry of the fit of `discover` as a controller takes it; base, tool and targets fitted to the rows before they were spoiled |
//! | written | the same as it is in the file |

use super::executed::{Fits, execute};
use super::record::{Figure, Record};
use super::robots::Robot;
use crate::prelude::*;
use truepose_compensate::{ExportOptions, corrected_chain};
use truepose_discover::{Diagnosis, DiscoverOptions, FoldRun, diagnose, nested};
use truepose_errormodel::effects::{AllTargets, Where};
use truepose_identify::{IdentificationOptions, Split, identify, place};

/// Folds of `discover --nested`.
const FOLDS: usize = 5;

/// A verb besides `identify`, which always runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Verb {
    Identify,
    Solvers,
    Discover,
    Export,
    Compensate,
}

/// All verbs that are requested.
pub fn run(robot: &Robot, verbs: &[Verb]) -> Record {
    let mut record = blank(robot);
    let mut fits = Fits::default();
    let options = FitOptions::default();
    if let Some(found) =
        record.attempt("installation", || installation(&robot.described, &robot.data, &options))
    {
        note(&mut record, robot, Figure::Nominal, &found);
        fits.nominal = Some(found);
    }
    let begun = Instant::now();
    if let Some(found) = record.attempt("identify", || identified(robot, &robot.data, "qr")) {
        note(&mut record, robot, Figure::Constants, &found);
        fits.constants = Some(found);
    }
    record.set(Figure::SecondsIdentify, begun.elapsed().as_secs_f64());
    if let Some(clean) = &robot.clean
        && let Some(found) = record.attempt("clean", || identified(robot, clean, "qr"))
    {
        note(&mut record, robot, Figure::Clean, &found);
    }
    if verbs.contains(&Verb::Solvers) {
        for (solver, figure) in
            [("tukey(qr)", Figure::Tukey), ("huber(qr)", Figure::Huber), ("ridge(map)", Figure::Ridge)]
        {
            if let Some(found) = record.attempt(solver, || identified(robot, &robot.data, solver)) {
                note(&mut record, robot, figure, &found);
            }
        }
    }
    if verbs.contains(&Verb::Discover) {
        let (begun, spent) = (Instant::now(), process());
        let found = record.attempt("discover", || discovered(robot));
        record.set(Figure::SecondsDiscover, begun.elapsed().as_secs_f64());
        record.set(Figure::Processors, process() - spent);
        if let Some(found) = found {
            let words = found.findings.iter().map(|finding| finding.candidate.words());
            record.finds = words.collect::<Vec<_>>().join("; ");
            note(&mut record, robot, Figure::Discover, &found.fit.fitted);
            fits.discover = Some(found.fit.fitted);
        }
    }
    if verbs.contains(&Verb::Export)
        && let Some(fitted) = fits.discover.as_ref().or(fits.constants.as_ref())
        && let Some(chain) = record.attempt("export", || exported(fitted))
    {
        if let Some(found) = record.attempt("export", || bare(&chain)) {
            note(&mut record, robot, Figure::Written, &found);
        }
        // What is spoiled in the record would say nothing about the geometry.
        let data = robot.clean.as_ref().unwrap_or(&robot.data);
        if let Some(found) = record.attempt("export", || installation(&chain, data, &options)) {
            note(&mut record, robot, Figure::Export, &found);
        }
    }
    if verbs.contains(&Verb::Compensate) {
        execute(robot, &fits, &mut record);
    }
    record
}

/// The whole loop inside of each fold, against the declared model in the same folds.
pub fn run_nested(robot: &Robot) -> Record {
    let mut record = blank(robot);
    let (begun, spent) = (Instant::now(), process());
    let judged = record.attempt("nested", || {
        let (split, solver) = (Split::Random { folds: FOLDS, seed: 0 }, PivotedQr::default());
        let options = DiscoverOptions::default();
        Ok(nested(&robot.described, &constant_errors(), &robot.data, &split, &solver, &options, &|_, _| ())?)
    });
    record.set(Figure::SecondsNested, begun.elapsed().as_secs_f64());
    record.set(Figure::Processors, process() - spent);
    if let Some(judged) = judged {
        record.set(Figure::NestedBefore, 1e3 * judged.before.rms);
        record.set(Figure::NestedAfter, 1e3 * judged.after.rms);
        let words = |run: &FoldRun| run.findings.join("; ");
        record.finds = judged.runs.iter().map(words).collect::<Vec<_>>().join(" | ");
    }
    record
}

fn blank(robot: &Robot) -> Record {
    let unknown = [
        ("base", !robot.described.base().known),
        ("tool", !robot.described.tool().known),
        ("targets", robot.described.targets().iter().any(|target| !target.known)),
        ("turns", robot.data.orientation.iter().any(Option::is_some)),
    ];
    let given: Vec<&str> = unknown.iter().filter(|(_, so)| *so).map(|(word, _)| *word).collect();
    Record {
        number: robot.number,
        seed: super::robots::seed(robot.number),
        make: robot.make.word(),
        hidden: robot.hidden.word(),
        style: robot.style.word(),
        spoil: robot.spoil.word(),
        poses: robot.poses,
        rows: robot.data.len(),
        targets: robot.described.targets().len(),
        given: given.join("+"),
        noise_mm: 1e3 * robot.noise,
        figures: BTreeMap::new(),
        finds: String::new(),
        refused: Vec::new(),
    }
}

/// RMS distance between predicted and true positions of the targets, mm.
fn note(record: &mut Record, robot: &Robot, figure: Figure, fitted: &FittedModel) {
    let verb = format!("predict for {figure:?}");
    let residuals = record.attempt(&verb, || Ok(Residuals::of(fitted, &robot.truth)?));
    if let Some(residuals) = residuals {
        record.set(figure, 1e3 * residuals.positions().rms);
    }
}

/// Base, tool and targets fitted, and nothing of the arm: the stage `frames_only` of an identification.
fn installation(chain: &Chain, data: &Dataset, options: &FitOptions) -> Outcome<FittedModel> {
    let placed = place(chain, data)?.chain;
    let mut frames = vec![Where::Frame(FrameId::BASE), Where::Frame(placed.tool_frame())];
    if !placed.targets().is_empty() {
        frames.push(Where::Targets(AllTargets::All));
    }
    let errors = Geometric { frames: Some(frames), components: None };
    Ok(fitted(&placed, &[Box::new(errors)], data, options)?.fitted)
}

fn identified(robot: &Robot, data: &Dataset, solver: &str) -> Outcome<FittedModel> {
    let solver = solver.parse::<SolverSpec>()?.build();
    let options = IdentificationOptions::default();
    let found = identify(&robot.described, &constant_errors(), data, &*solver, &options, &|_| ())?;
    Ok(found.fit.fitted)
}

fn discovered(robot: &Robot) -> Outcome<Diagnosis> {
    let (solver, options) = (PivotedQr::default(), DiscoverOptions::default());
    Ok(diagnose(&robot.described, &constant_errors(), &robot.data, &solver, &options, &|_| ())?)
}

/// A robot without any error.
fn bare(chain: &Chain) -> Outcome<FittedModel> {
    let model = ErrorModel::new(chain.clone(), Vec::new())?;
    Ok(FittedModel::new(model, Vec::new(), DMatrix::zeros(0, 0))?)
}

/// The geometry that `export` writes, as a robot: the one place where this study uses it.
fn exported(fitted: &FittedModel) -> Outcome<Chain> {
    Ok(corrected_chain(fitted, &ExportOptions::default())?.value)
}
