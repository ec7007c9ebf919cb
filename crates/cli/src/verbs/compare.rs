//! `truepose compare`: solver strategies side by side on one data set.

use super::campaign::Campaign;
use super::folds::{different, split, split_words};
use super::installation::installed;
use super::mistakes::Mistakes;
use super::reporting::Folder;
use super::{declared, print_json, read_files, robot};
use crate::args::Compare;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::terminal;
use crate::watch::Watch;
use truepose_errormodel::ErrorModel;
use truepose_identify::{FitOptions, Folds, compare, place};
use truepose_io::{WholeFiles, read_measurements};
use truepose_report::{ComparisonSummary, comparison_report};

/// Runs the verb.
pub fn run(args: &Compare, watch: &Watch) -> Result<(), Failure> {
    let folder = Folder::prepare(args.report.as_ref(), "comparison.json")?;
    let chain = robot(&args.measured.robot)?;
    let effects = declared(&args.measured, &chain)?;
    let (mut data, info, warnings) =
        read_measurements(&args.measured.data, &chain, &args.measured.reading()?)?;
    terminal::warn(&warnings);
    if args.positions_only {
        data.orientation.fill(None);
    }
    let (chain, assumed) = installed(chain, &args.measured.robot, &data)?;
    assumed.iter().for_each(|words| terminal::log(words));
    let Some(split) = split(args.folds, args.split, args.seed, different(&data))? else {
        let words = match args.folds {
            0 => "--folds: a comparison needs at least 2 folds".into(),
            _ => format!("{}: one configuration is too few to compare by", args.measured.data.display()),
        };
        return Err(Failure::Input(words));
    };
    let files_read = (&*args.measured.robot.robot, &*args.measured.data);
    let plain = truepose_solvers::PivotedQr::default();
    let options = FitOptions { prior: args.prior, ..FitOptions::default() };
    let campaign = Campaign::read(files_read, chain, effects, data, &info, (&plain, &options))?;
    let Campaign { chain, effects, data, .. } = &campaign;
    terminal::warn(Mistakes::of(chain, data, &args.measured.data).words.as_slice());
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
