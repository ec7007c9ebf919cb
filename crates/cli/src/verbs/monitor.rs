//! `truepose monitor`: whether a robot has changed since it was calibrated.

use super::reporting::Folder;
use super::{print_json, usable_fit};
use crate::args::Monitor;
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use std::path::Path;
use truepose_identify::Residuals;
use truepose_io::{
    LookRecord, MonitorHistory, WholeFiles, check_writable, file_digest, read_measurements, write_whole,
};
use truepose_report::{LookView, MonitorSummary, Verdict, history_page, monitor_report};
use truepose_upkeep::{Installation, MonitorOptions, monitor};
use truepose_workflow::{in_session, one_installation};

/// Runs the verb; [`Failure::Changed`] where the robot has changed.
pub fn run(args: &Monitor, watch: &Watch) -> Result<(), Failure> {
    for file in [args.history.as_deref(), args.page.as_deref()].into_iter().flatten() {
        check_writable(file)?;
    }
    let folder = Folder::prepare(args.report.as_ref(), "monitor.json")?
        .map(|folder| folder.certified(args.certificate.as_ref()))
        .transpose()?;
    let fitted = in_session(usable_fit(&args.fit, &args.accept)?, args.session.as_deref(), args.base)?;
    let (_, digest) = file_digest(&args.fit)?;
    // Read while the file is locked ([`super::files::locked`]): what another run adds comes before or after all of this.
    let mut history = match &args.history {
        Some(file) if file.exists() => MonitorHistory::read(file, &digest)?,
        _ => MonitorHistory::new(digest),
    };
    // What comes through a pipe cannot be read again.
    let data_sha256 = if args.data.is_file() { file_digest(&args.data)?.1 } else { String::new() };
    once(&history, &data_sha256, args)?;
    let (data, info, warnings) =
        read_measurements(&args.data, fitted.chain(), &args.grouped.measured_for(&fitted))?;
    terminal::warn(&warnings);
    one_installation(&info, &args.data)?;
    watch.doing("looking for changes");
    let installation = Installation { base: args.base, tool: args.tool, targets: args.targets };
    let options = MonitorOptions { alpha: args.alpha, looks: history.looks.len(), installation };
    let seen = monitor(&fitted, &data, options)
        .map_err(|error| Failure::Input(format!("{}: {error}", args.data.display())))?;
    let mut summary = MonitorSummary::new(fitted.chain().name(), &seen, history.looks.len() + 1, args.alpha);
    summary.date.clone_from(&args.date);
    if let Some(limit) = args.spec {
        summary = summary.with_specification(limit, &data, &Residuals::of(&fitted, &data)?);
    }
    history.looks.push(LookRecord {
        data: args.data.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        data_sha256,
        date: args.date.clone(),
        rows: seen.rows,
        poses: seen.poses,
        rms_mm: summary.rms_mm,
        expected_rms_mm: summary.expected_rms_mm,
        p_value: seen.p_value,
        level: seen.level,
        changed: seen.changed,
        suspect: seen.changes.first().filter(|_| seen.changed).map(|change| change.what.clone()),
    });
    if let Some(file) = &args.history {
        history.write(file)?;
    }
    let looks: Vec<LookView> = history.looks.iter().map(view).collect();
    if let Some(file) = &args.page {
        write_whole(file, history_page(&summary, &looks).as_bytes())?;
    }
    if let Some(folder) = &folder {
        let inputs: Vec<&Path> = [Some(&args.fit), Some(&args.data), args.certificate.as_ref()]
            .into_iter()
            .flatten()
            .map(|file| &**file)
            .collect();
        let mut files = WholeFiles::default();
        folder.add(&mut files, &summary, &inputs, |run| Ok(monitor_report(&summary, &looks, run)))?;
        files.finish()?;
    }
    if args.json {
        print_json(&summary)?;
    } else {
        terminal::print(&summary.to_string());
    }
    let page = folder.as_ref().map(Folder::page);
    for file in [args.history.as_deref(), args.page.as_deref(), page.as_deref()].into_iter().flatten() {
        terminal::log(&format!("wrote {}", file.display()));
    }
    match &summary.specification {
        _ if seen.changed => Err(Failure::Changed),
        Some(of) if of.verdict == Verdict::Fail => Err(Failure::Criterion(of.sentence())),
        _ => Ok(()),
    }
}

/// Refuses measurements that the history has already: a check of the same numbers is no further one.
fn once(history: &MonitorHistory, sha256: &str, args: &Monitor) -> Result<(), Failure> {
    let same = |look: &LookRecord| !sha256.is_empty() && look.data_sha256 == sha256;
    let Some(k) = history.looks.iter().position(same) else { return Ok(()) };
    let words = match history.looks[k].data.as_str() {
        "" => String::new(),
        name => format!(" (`{name}`)"),
    };
    Err(Failure::Input(format!(
        "{}: check {} of the history{words} is of these measurements; measure again, or leave --history out",
        args.data.display(),
        k + 1
    )))
}

/// A look as the page shows it.
fn view(look: &LookRecord) -> LookView {
    LookView {
        data: look.data.clone(),
        date: look.date.clone(),
        poses: look.poses,
        rms_mm: look.rms_mm,
        expected_rms_mm: look.expected_rms_mm,
        p_value: look.p_value,
        level: look.level,
        changed: look.changed,
        suspect: look.suspect.clone(),
    }
}
