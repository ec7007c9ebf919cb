//! `truepose discover`: find effects that the declared model lacks, add them, and test the enlarged model.

use super::campaign::Campaign;
use super::folds::{different, split, split_words};
use super::identified::conforms;
use super::installation::installed;
use super::mistakes::Mistakes;
use super::observers::decided;
use super::reporting::Folder;
use super::{declared, parameters, points, print_json, read_files, robot};
use crate::args::Discover;
use crate::extensions::library;
use crate::failure::Failure;
use crate::progress::Progress as Bar;
use crate::recorded::record_columns;
use crate::terminal;
use crate::verdict::FitVerdict;
use crate::watch::{Kept, Watch};
use std::path::{Path, PathBuf};
use truepose_discover::{
    CompetingFit, Diagnosis, DiscoverError, DiscoverOptions, Nested, Progress, diagnose, nested,
};
use truepose_errormodel::{Dataset, FittedModel, ModelError};
use truepose_identify::{FitOptions, IdentifyError, as_found};
use truepose_io::{
    WholeFiles, check_writable, fit_json, make_folder, read_measurements, write_fit, write_whole,
};
use truepose_report::{DataCheck, DiscoverySettings, DiscoverySummary, NestedSummary, discovery_report};

/// Runs the verb.
pub fn run(args: &Discover, watch: &Watch) -> Result<(), Failure> {
    for out in args.out.iter().chain(&args.parameters) {
        check_writable(out)?;
    }
    let robot_file = Some(&args.measured.robot.robot);
    let folder = Folder::with_head(args.report.as_ref(), "discovery.json", robot_file)?
        .map(|folder| folder.certified(args.certificate.as_ref()))
        .transpose()?;
    if let Some(rivals) = &args.rivals {
        make_folder(rivals)?;
        check_writable(rivals.join("rival.json"))?;
    }
    let chain = robot(&args.measured.robot)?;
    let declared = declared(&args.measured, &chain)?;
    let (mut data, info, warnings) =
        read_measurements(&args.measured.data, &chain, &args.measured.reading()?)?;
    terminal::warn(&warnings);
    if args.positions_only {
        data.orientation.fill(None);
    }
    let (chain, assumed) = installed(chain, &args.measured.robot, &data)?;
    let files_read = (&*args.measured.robot.robot, &*args.measured.data);
    let solver = args.solver.build();
    let fit = FitOptions::default();
    let mut campaign = Campaign::read(files_read, chain, declared, data, &info, (&*solver, &fit))?;
    points::one_point(&campaign.chain, &campaign.data, &info, &args.measured.data)?;
    let mistakes = Mistakes::of(&campaign.chain, &campaign.data, &args.measured.data);
    // At once as well: a search takes a while.
    terminal::warn(mistakes.words.as_slice());
    let mut data_check = campaign.without(&mistakes);
    let vertical = campaign.settle_gravity(files_read.0, (&*solver, &fit))?;
    terminal::warn(vertical.as_slice());
    data_check.suspected.extend(vertical);
    terminal::warn(repeated(&campaign.data, &args.measured.data).as_slice());
    let options_of = |campaign: &Campaign| DiscoverOptions {
        holdout: args.holdout,
        seed: args.seed,
        rotations: args.rotations,
        alpha: args.alpha,
        most: args.most,
        competing_fits: args.rivals.is_some(),
        library: library(),
        fit: campaign.options(&fit),
        ..DiscoverOptions::default()
    };
    let settings = DiscoverySettings {
        seed: args.seed,
        holdout: args.holdout,
        rotations: args.rotations,
        alpha: args.alpha,
    };
    let origin = Origin { solver: args.solver.to_string(), rows: campaign.data.len(), seed: args.seed };
    let search = |campaign: &Campaign| {
        let bar = Bar::spinner(watch);
        let Campaign { chain, effects: declared, data, .. } = campaign;
        let options = options_of(campaign);
        diagnose(chain, declared, data, &*solver, &options, &|step| match step {
            Progress::Interim(so_far) => {
                let (out, origin) = (args.out.as_deref().map(Path::to_path_buf), origin.clone());
                let result = folder.as_ref().map(Folder::result);
                let with = (settings, data_check.clone());
                watch.found(so_far.findings.iter().map(|finding| finding.candidate.words()).collect());
                watch.keep(move |why| incomplete(*so_far, with, &origin, out, result, why));
            }
            step => bar.show(&progress_text(&step)),
        })
        .map_err(|error| refused(args, error))
    };
    let told = campaign.remarks.len();
    let (campaign, found, observers) = decided(campaign, (&*solver, &fit), &search)?;
    terminal::warn(&campaign.remarks[told..]);
    let Campaign { chain, effects: declared, data, .. } = &campaign;
    let options = options_of(&campaign);
    let mut summary = DiscoverySummary::new(&found, settings);
    campaign.discovered(&mut summary, &found, (&*solver, &options.fit))?;
    summary = summary.with_data_check(data_check.clone());
    summary.assumed = assumed;
    summary.observers = observers;
    if let Some(folds) = args.nested {
        // If a limit ends the validation, the completed search is shown and written.
        let whole = (
            summary.clone(),
            args.out.as_deref().map(Path::to_path_buf),
            folder.as_ref().map(Folder::result),
        );
        let (fitted, origin) = (found.fit.fitted.without_order()?, origin.clone());
        watch.keep(move |why| without_validation(whole, fitted, &origin, why));
        let Some(split) = split(usize::from(folds), args.split, args.seed, different(data))? else {
            return Err(Failure::Input(
                "--nested: a single configuration cannot be divided into folds".into(),
            ));
        };
        let judged = match found.runs_of(&split, data) {
            Some(runs) => Nested::of(runs, &options)?,
            None => {
                let bar = Bar::spinner(watch);
                nested(chain, declared, data, &split, &*solver, &options, &|fold, step| {
                    bar.show(&format!("fold {} of {folds}: {}", fold + 1, progress_text(&step)));
                })?
            }
        };
        summary.nested = Some(NestedSummary::new(&judged, split_words(&split)));
    }
    if let Ok(found) = as_found(&found.placement, &found.data, &FitOptions::default()) {
        summary.as_found = Some(found.into());
    }
    if let Some(limit) = args.spec {
        summary = summary.with_specification((limit, args.correction.into()), &found, data)?;
    }
    // Pages are of the whole fit; its file is of the robot alone.
    let mut used = campaign.used(&found.fit.fitted)?;
    FitVerdict::discovered(&summary, found.fit.converged).record(&mut used);
    parameters::record_details(&mut used, &args.measured.robot.robot)?;
    record_columns(&mut used, &info.map);
    if args.parameters.is_some() || args.report.is_some() || args.json {
        summary.parameters = Some(parameters::parameters(&used.clone().of_robot()));
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
            Ok(discovery_report(&summary, &found, data, &info.visit_labels, run)?)
        })?;
    }
    if let Some(out) = &args.out {
        origin.write(&mut used, true);
        files.add(out, fit_json(out, &used)?.as_bytes())?;
    }
    let rivals = match &args.rivals {
        Some(folder) => add_rivals(&mut files, folder, &found.competitors)?,
        None => Vec::new(),
    };
    watch.whole();
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
    rivals.iter().for_each(|line| terminal::log(line));
    lost.map_or(Ok(()), Err)?;
    conforms(summary.specification.as_ref())
}

/// Channels that the search tests as one.
pub(crate) fn repeated(data: &Dataset, file: &Path) -> Option<String> {
    let channels = &data.schema.channels;
    let pairs = data.repeated_channels().into_iter().enumerate().filter_map(|(k, first)| Some((k, first?)));
    let pairs: Vec<(usize, usize)> = pairs.collect();
    let &(k, first) = pairs.first()?;
    let (other, first) = (&channels[k].name, &channels[first].name);
    let more = match pairs.len() - 1 {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    Some(format!(
        "{}: channel `{other}` has the values of `{first}`{more}: equal channels are tested as one, under the first name",
        file.display()
    ))
}

/// An error with the file that it is about, where it is about the data.
fn refused(args: &Discover, error: DiscoverError) -> Failure {
    match error {
        DiscoverError::TooFewPoses { .. }
        | DiscoverError::Identify(
            IdentifyError::NothingMeasured { .. }
            | IdentifyError::Placement { .. }
            | IdentifyError::Model(ModelError::MissingSignal { .. }),
        ) => Failure::Input(format!("{}: {error}", args.measured.data.display())),
        _ => error.into(),
    }
}

/// Bytes of a rival's name, at most: names of joints may be long, and those of files are not.
const LONGEST: usize = 120;

/// Adds one file for each competing hypothesis, named after it; returns what is said of them.
fn add_rivals(
    files: &mut WholeFiles,
    folder: &Path,
    rivals: &[CompetingFit],
) -> Result<Vec<String>, Failure> {
    if rivals.is_empty() {
        let none =
            "no competing hypothesis to write: all findings are distinguishable from their alternatives";
        return Ok(vec![none.into()]);
    }
    let mut said = Vec::new();
    for rival in rivals {
        let plain = |c: char| if c.is_alphanumeric() || c == '_' || c == '.' { c } else { '-' };
        let words = rival.candidate.words();
        let mut name: String = words.chars().map(plain).collect();
        while name.len() > LONGEST {
            name.pop();
        }
        let file = folder.join(format!("{}-{name}.json", rival.finding + 1));
        files.add(&file, fit_json(&file, &rival.fit.fitted.without_order()?)?.as_bytes())?;
        said.push(format!("wrote {}: {words} in place of finding {}", file.display(), rival.finding + 1));
    }
    Ok(said)
}

/// Where a fit comes from.
#[derive(Clone)]
pub(crate) struct Origin {
    pub solver: String,
    pub rows: usize,
    pub seed: u64,
}

impl Origin {
    pub(crate) fn write(&self, fitted: &mut FittedModel, all_rows: bool) {
        let provenance = &mut fitted.provenance;
        provenance.insert("program".into(), concat!("truepose ", env!("CARGO_PKG_VERSION")).into());
        provenance.insert("verb".into(), "discover".into());
        provenance.insert("solver".into(), self.solver.clone().into());
        provenance.insert("rows".into(), self.rows.into());
        provenance.insert("seed".into(), self.seed.into());
        provenance.insert("structure_frozen_then_all_rows".into(), all_rows.into());
    }
}

/// A completed search: its summary, the file of the fit and the file of the result.
type Finished = (DiscoverySummary, Option<PathBuf>, Option<PathBuf>);

/// Shows and writes a completed search whose nested cross-validation was ended; each file whole or not at all.
fn without_validation(
    (mut summary, out, result): Finished,
    mut fitted: FittedModel,
    origin: &Origin,
    why: &str,
) -> Kept {
    summary.incomplete = Some(format!("{why}: the nested cross-validation is not complete"));
    let text = format!("The search is complete; its nested cross-validation is not.\n\n{summary}");
    let mut written = Vec::new();
    if let Some(out) = out {
        origin.write(&mut fitted, true);
        if write_fit(&out, &fitted).is_ok() {
            written.push(out);
        }
    }
    written.extend(result.filter(|result| write_result(result, &summary)));
    Kept { files: written, text }
}

/// Whether the result could be written.
fn write_result(result: &Path, summary: &DiscoverySummary) -> bool {
    serde_json::to_string_pretty(summary)
        .is_ok_and(|text| write_whole(result, (text + "\n").as_bytes()).is_ok())
}

/// Writes the findings so far, marked as incomplete, each file whole or not at all; returns the files.
fn incomplete(
    mut found: Diagnosis,
    (settings, data_check): (DiscoverySettings, DataCheck),
    origin: &Origin,
    out: Option<PathBuf>,
    result: Option<PathBuf>,
    why: &str,
) -> Kept {
    let summary = DiscoverySummary::new(&found, settings).with_data_check(data_check);
    let summary = DiscoverySummary { incomplete: Some(why.into()), ..summary };
    let mut written = Vec::new();
    if let Some(out) = out {
        let fitted = &mut found.fit.fitted;
        origin.write(fitted, false);
        fitted.provenance.insert("incomplete".into(), why.into());
        if fitted.without_order().is_ok_and(|fitted| write_fit(&out, &fitted).is_ok()) {
            written.push(out);
        }
    }
    written.extend(result.filter(|result| write_result(result, &summary)));
    Kept { files: written, text: String::new() }
}

pub(crate) fn progress_text(step: &Progress) -> String {
    match step {
        Progress::Fitting => "fitting the declared model".into(),
        Progress::Screening(0) => "screening all candidates".into(),
        Progress::Screening(found) => format!("screening again with {found} added"),
        Progress::Found(words) => format!("added {words}; fitting"),
        Progress::Interim(_) => "storing the findings so far".into(),
        Progress::Checking => "checking on data that the search did not use".into(),
        Progress::Reconsidering => "testing earlier findings again".into(),
        Progress::Judging => "evaluating on the held-out test set".into(),
    }
}
