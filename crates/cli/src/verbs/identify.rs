//! `truepose identify`: fit a declared error model, and estimate its accuracy on held-out data.

use super::criteria::{conforms, require};
use super::reporting::Folder;
use super::{print_json, read_files};
use crate::args::{Identify, Measured, Prior};
use crate::extensions::effects;
use crate::failure::Failure;
use crate::progress::{Progress, Shown};
use crate::terminal;
use crate::watch::Watch;
use std::path::Path;
use truepose_identify::Step;
use truepose_io::{WholeFiles, check_writable, fit_json};
use truepose_report::identification_report;
use truepose_workflow::{
    FoldsRequest, IdentifyRequest, InputFiles, NamedSolver, Undeclared, identify, parameters_csv,
};

/// Runs the verb.
pub fn run(args: &Identify, watch: &Watch) -> Result<(), Failure> {
    if let Prior::Fleet(file) = &args.prior {
        return super::sister::run(args, file);
    }
    for out in args.out.iter().chain(&args.parameters) {
        check_writable(out)?;
    }
    let robot_file = Some(&args.measured.robot.robot);
    let folder = Folder::with_head(args.report.as_ref(), "identification.json", robot_file)?
        .map(|folder| folder.certified(args.certificate.as_ref()))
        .transpose()?;
    let files_read = args.measured.files(args.positions_only);
    if args.stream {
        return streamed(args, &files_read, watch);
    }
    let (inputs, warnings) = files_read.read(effects())?;
    terminal::warn(&warnings);
    let request = IdentifyRequest {
        folds: match &args.fold_by {
            Some(channel) => FoldsRequest::Channel(channel.clone()),
            None => FoldsRequest::Count(args.folds, args.split.into()),
        },
        repeats: usize::from(args.repeat),
        holdout: args.holdout,
        seed: args.seed,
        fit: args.fit(),
        specification: args.spec.map(|limit| (limit, args.correction.into())),
    };
    let solver = NamedSolver { name: args.solver.to_string(), solver: args.solver.build() };
    let shown = Shown::new(Progress::steps(Step::ALL.len(), watch));
    let mut made = identify(inputs, &request, &solver, &shown)?;
    drop(shown);

    if args.parameters.is_some() || args.report.is_some() || args.json {
        made.compute_parameters();
    }
    if !args.json {
        made.compute_places();
    }
    let summary = &made.summary;
    let mut files = WholeFiles::default();
    // The fit does not depend on whether its parameters can be written.
    let mut lost = None;
    if let Some((path, summary)) = args.parameters.as_ref().zip(summary.parameters.as_ref()) {
        match parameters_csv(path, summary) {
            Ok(file) => files.push(file)?,
            Err(error) => lost = Some(error),
        }
    }
    if let Some(folder) = &folder {
        let mut inputs = read_files(&args.measured);
        inputs.extend(args.certificate.as_deref());
        // Pages are of the whole fit; its file is of the robot alone.
        folder.add(&mut files, summary, &inputs, |run| {
            let labels = &made.source.info.visit_labels;
            Ok(identification_report(summary, &made.found, &made.campaign.data, labels, run)?)
        })?;
    }
    if let Some(out) = &args.out {
        files.add(out, fit_json(out, &made.fitted)?.as_bytes())?;
    }
    files.finish()?;
    if args.json {
        print_json(summary)?;
    } else {
        terminal::print(&summary.to_string());
        if let Some((_, parameters)) = args.parameters.as_ref().zip(summary.parameters.as_ref()) {
            terminal::print(&parameters.to_string());
        }
    }
    let page = folder.as_ref().map(Folder::page);
    let parameters = args.parameters.as_deref().filter(|_| lost.is_none());
    for file in [page.as_deref(), args.out.as_deref(), parameters].into_iter().flatten() {
        terminal::log(&format!("wrote {}", file.display()));
    }
    if summary.lacks_an_effect() {
        terminal::log(&next(args));
    }
    lost.map_or(Ok(()), Err)?;
    conforms(summary.specification.as_ref())?;
    let Some(last) = summary.stages.last() else { return Ok(()) };
    let judged = last.test_set.or(last.held_out).unwrap_or(last.train);
    require(args, judged.rms_mm * 1e-3, judged.count)
}

/// A file that is read block by block.
fn streamed(args: &Identify, files: &InputFiles, watch: &Watch) -> Result<(), Failure> {
    let (chain, warnings) = files.chain()?;
    terminal::warn(&warnings);
    let effects = files.effects(&chain, effects())?;
    let opened = Undeclared::of(&files.robot, files.known)?.opened(&chain)?;
    let chain = opened.map_or(chain, |(chain, words)| {
        terminal::log(&words);
        chain
    });
    super::stream::identify(args, &chain, &effects, watch)
}

/// The command that looks for the effect that is lacking.
fn next(args: &Identify) -> String {
    let Measured { robot, data, model, .. } = &args.measured;
    let file = |option: &str, path: &Path| {
        let path = path.display().to_string();
        let quote = if path.contains(char::is_whitespace) { "\"" } else { "" };
        format!(" --{option} {quote}{path}{quote}")
    };
    let model = model.as_ref().map_or_else(String::new, |model| file("model", model));
    format!(
        "next, to find it: truepose discover{}{}{model} --out discovered.json --report report (with the same options for reading)",
        file("robot", &robot.robot),
        file("data", data)
    )
}
