//! `truepose identify`: fit a declared error model, and estimate its accuracy on held-out data.

use super::campaign::Campaign;
use super::folds::{different, split, split_words};
use super::identified::{conforms, refused, require, whole};
use super::installation::{Undeclared, installed};
use super::mistakes::Mistakes;
use super::reporting::Folder;
use super::{declared, parameters, points, print_json, read_files, robot};
use crate::args::{Identify, Measured, Prior};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::recorded::record_columns;
use crate::terminal;
use crate::watch::Watch;
use std::path::Path;
use truepose_errormodel::{Dataset, Visits, configurations};
use truepose_identify::{IdentificationOptions, Split, Step, hold_out, identify};
use truepose_io::{WholeFiles, check_writable, fit_json, read_measurements};
use truepose_report::{IdentificationSummary, identification_report};

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
    let chain = robot(&args.measured.robot)?;
    let effects = declared(&args.measured, &chain)?;
    if args.stream {
        let opened = Undeclared::of(&args.measured.robot)?.opened(&chain)?;
        let chain = opened.map_or(chain, |(chain, words)| {
            terminal::log(&words);
            chain
        });
        return super::stream::identify(args, &chain, &effects, watch);
    }
    let (mut data, info, warnings) =
        read_measurements(&args.measured.data, &chain, &args.measured.reading()?)?;
    terminal::warn(&warnings);
    if args.positions_only {
        data.orientation.fill(None);
    }
    let (chain, assumed) = installed(chain, &args.measured.robot, &data)?;
    let mut options = IdentificationOptions {
        fit: args.fit(),
        split: match &args.fold_by {
            Some(channel) => Some(own_folds(&data, channel)?),
            None => split(args.folds, args.split, args.seed, in_fit(&data, args)?)?,
        },
        repeats: usize::from(args.repeat),
        holdout: args.holdout,
        seed: args.seed,
    };
    let files_read = (&*args.measured.robot.robot, &*args.measured.data);
    let solver = args.solver.build();
    let mut campaign = Campaign::read(files_read, chain, effects, data, &info, (&*solver, &options.fit))?;
    options.fit = campaign.options(&options.fit);
    points::one_point(&campaign.chain, &campaign.data, &info, &args.measured.data)?;
    campaign.without_test_set(args.holdout)?;
    // Shown with the result, or with the error where there is none.
    let mistakes = Mistakes::of(&campaign.chain, &campaign.data, &args.measured.data);
    let mut data_check = match args.fold_by.is_some() {
        true => mistakes.check(), // folds are of all rows
        false => campaign.without(&mistakes),
    };
    data_check.suspected.extend(campaign.settle_gravity(files_read.0, (&*solver, &options.fit))?);
    let Campaign { chain, effects, data, .. } = &campaign;
    let progress = Progress::steps(Step::ALL.len(), watch);
    let found =
        identify(chain, effects, data, &*solver, &options, &|step| progress.begin(progress_text(step)))
            .map_err(|error| {
                terminal::warn(mistakes.words.as_slice());
                refused(args, error)
            })?;
    drop(progress);

    let mut summary = IdentificationSummary::new(
        &found,
        data,
        &info.visit_labels,
        &args.solver.to_string(),
        options.split.as_ref().map(split_words),
    );
    summary = summary.with_data_check(data_check);
    summary.assumed = assumed;
    if let Some(limit) = args.spec {
        summary = summary.with_specification((limit, args.correction.into()), &found, data)?;
    }
    summary = campaign.identified(summary, &found)?;
    // Pages are of the whole fit; its file is of the robot alone.
    let mut used = campaign.used(&found.fit.fitted)?;
    parameters::record_details(&mut used, &args.measured.robot.robot)?;
    record_columns(&mut used, &info.map);
    if args.parameters.is_some() || args.report.is_some() || args.json {
        summary.parameters = Some(parameters::parameters(&used.clone().of_robot()));
    }
    if let Some(placement) = summary.placement.as_mut().filter(|_| !args.json) {
        placement.places = match &summary.parameters {
            Some(parameters) => parameters.found(&placement.found),
            None => parameters::places(&used.clone().of_robot(), &placement.found),
        };
    }
    let mut files = WholeFiles::default();
    // The fit does not depend on whether its parameters can be written.
    let mut lost = None;
    if let Some((path, summary)) = args.parameters.as_ref().zip(summary.parameters.as_ref()) {
        match parameters::file(path, summary) {
            Ok(file) => files.push(file)?,
            Err(failure) => lost = Some(failure),
        }
    }
    if let Some(folder) = &folder {
        let mut inputs = read_files(&args.measured);
        inputs.extend(args.certificate.as_deref());
        folder.add(&mut files, &summary, &inputs, |run| {
            Ok(identification_report(&summary, &found, data, &info.visit_labels, run)?)
        })?;
    }
    if let Some(out) = &args.out {
        whole(&mut used, &summary, args.seed, args.holdout.is_some());
        files.add(out, fit_json(out, &used)?.as_bytes())?;
    }
    files.finish()?;
    if args.json {
        print_json(&summary)?;
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

/// Folds numbered by a channel.
fn own_folds(data: &Dataset, channel: &str) -> Result<Split, Failure> {
    let Some(k) = data.schema.channel(channel) else {
        let known: Vec<&str> = data.schema.channels.iter().map(|c| c.name.as_str()).collect();
        let known = if known.is_empty() {
            "it has none".into()
        } else {
            format!("its channels: {}", known.join(", "))
        };
        return Err(Failure::Input(format!("--fold-by: the data has no channel `{channel}` ({known})")));
    };
    let mut numbers: Vec<f64> = Vec::new();
    let mut of_visit = Vec::new();
    for rows in &Visits::of(data).rows {
        let value = data.channels[k][rows[0]];
        if rows.iter().any(|&row| data.channels[k][row].to_bits() != value.to_bits()) {
            return Err(Failure::Input(format!(
                "--fold-by: `{channel}` changes within a visit (pose measurement); a fold takes whole visits"
            )));
        }
        let place = numbers.iter().position(|n| n.to_bits() == value.to_bits()).unwrap_or_else(|| {
            numbers.push(value);
            numbers.len() - 1
        });
        of_visit.push(place);
    }
    if numbers.len() < 2 {
        return Err(Failure::Input(format!(
            "--fold-by: `{channel}` has a single value; at least two folds are needed"
        )));
    }
    Ok(Split::Given(of_visit))
}

/// Number of configurations that are not in the held-out test set.
fn in_fit(data: &Dataset, args: &Identify) -> Result<usize, Failure> {
    let Some(fraction) = args.holdout else { return Ok(different(data)) };
    let (left, _) = hold_out(data, fraction, args.seed)?;
    let of_visit = configurations(data);
    let mut seen: Vec<usize> = left.iter().map(|&row| of_visit[data.visit[row]]).collect();
    seen.sort_unstable();
    seen.dedup();
    Ok(seen.len())
}

fn progress_text(step: Step) -> &'static str {
    match step {
        Step::Placing => "estimating base, tool and target frames",
        Step::FramesOnly => "fitting base and tool",
        Step::Fitting => "fitting the declared model",
        Step::Validating => "cross-validating",
        Step::Judging => "evaluating repeatability and observability",
    }
}
