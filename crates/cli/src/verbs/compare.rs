//! `truepose compare`: solver strategies side by side on one data set.

use super::reporting::Folder;
use super::{print_json, read_files};
use crate::args::Compare;
use crate::extensions::effects;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::terminal;
use crate::watch::Watch;
use truepose_errormodel::ErrorModel;
use truepose_identify::{FitOptions, Folds, compare, place};
use truepose_io::WholeFiles;
use truepose_report::{ComparisonSummary, comparison_report};
use truepose_workflow::{Campaign, FoldsRequest, split, split_words};

/// Runs the verb.
pub fn run(args: &Compare, watch: &Watch) -> Result<(), Failure> {
    let folder = Folder::prepare(args.report.as_ref(), "comparison.json")?;
    let (inputs, warnings) = args.measured.files(args.positions_only).read(effects())?;
    terminal::warn(&warnings);
    let (split, fewer) =
        split(&inputs.data, &FoldsRequest::Count(args.folds, args.split.into()), args.seed, None)?;
    terminal::warn(fewer.as_slice());
    let Some(split) = split else {
        let words = match args.folds {
            0 => "--folds: a comparison needs at least 2 folds".into(),
            _ => format!("{}: one configuration is too few to compare by", args.measured.data.display()),
        };
        return Err(Failure::Input(words));
    };
    let plain = truepose_solvers::PivotedQr::default();
    let options = FitOptions { prior: args.prior, ..FitOptions::default() };
    let (campaign, source) = Campaign::new(inputs, (&plain, &options), true)?;
    source.assumed.iter().for_each(|words| terminal::log(words));
    terminal::warn(&[&campaign.remarks[..], &source.check.suspected].concat());
    let Campaign { chain, effects, data, .. } = &campaign;
    let placed = place(chain, data)?.chain;
    let model = ErrorModel::new(placed, effects.clone())?;
    let folds = Folds::new(data, &split)?;
    let solvers: Vec<_> = args.solvers.iter().map(|spec| (spec.to_string(), spec.build())).collect();
    let progress = Progress::steps(solvers.len(), watch);
    let compared = compare(&model, data, &solvers, &options, &folds, &|name| progress.begin(name));
    drop(progress);
    let summary = ComparisonSummary::new(model.chain().name(), split_words(&split), &compared);
    if let Some(folder) = &folder {
        let inputs = read_files(&args.measured);
        let mut files = WholeFiles::default();
        folder.add(&mut files, &summary, &inputs, |run| Ok(comparison_report(&summary, run)))?;
        files.finish()?;
        terminal::log(&format!("wrote {}", folder.page().display()));
    }
    if args.json {
        return print_json(&summary);
    }
    terminal::print(&summary.to_string());
    Ok(())
}
