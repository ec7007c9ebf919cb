//! `truepose discover`: find effects that the declared model lacks, add them, and test the enlarged model.

use super::criteria::conforms;
use super::reporting::Folder;
use super::{print_json, read_files};
use crate::args::Discover;
use crate::extensions::{effects, library};
use crate::failure::Failure;
use crate::progress::{Progress, Shown};
use crate::terminal;
use crate::watch::{Kept, Watch};
use std::path::{Path, PathBuf};
use truepose_discover::{CompetingFit, DiscoverOptions};
use truepose_errormodel::FittedModel;
use truepose_io::{WholeFiles, check_writable, fit_json, make_folder, write_fit, write_whole};
use truepose_report::{DiscoverySummary, discovery_report};
use truepose_workflow::{DiscoverRequest, Interim, NamedSolver, Search, parameters_csv};

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
    let (inputs, warnings) = args.measured.files(args.positions_only).read(effects())?;
    terminal::warn(&warnings);
    let request = DiscoverRequest {
        options: DiscoverOptions {
            holdout: args.holdout,
            seed: args.seed,
            rotations: args.rotations,
            alpha: args.alpha,
            most: args.most,
            competing_fits: args.rivals.is_some(),
            library: library(),
            ..DiscoverOptions::default()
        },
        nested: args.nested.map(|folds| (usize::from(folds), args.split.into())),
        specification: args.spec.map(|limit| (limit, args.correction.into())),
    };
    let solver = NamedSolver { name: args.solver.to_string(), solver: args.solver.build() };
    let written = Written {
        out: args.out.as_deref().map(Path::to_path_buf),
        result: folder.as_ref().map(Folder::result),
    };
    let interim = |so_far: Interim| {
        let written = written.clone();
        watch.found(so_far.found.findings.iter().map(|finding| finding.candidate.words()).collect());
        watch.keep(move |why| {
            let files = written.write(so_far.fitted(why).ok().as_ref(), &so_far.summary(why));
            Kept { files, text: String::new() }
        });
    };
    let shown = Shown::new(Progress::spinner(watch)).with_interim(&interim);
    let search = Search::new(inputs, request, solver, &shown)?;
    let mut made = search.run(&shown)?;
    if args.nested.is_some() {
        // If a limit ends the validation, the completed search is shown and written.
        let (mut summary, fitted, written) = (made.summary.clone(), made.fitted.clone(), written.clone());
        watch.keep(move |why| {
            summary.incomplete = Some(format!("{why}: the nested cross-validation is not complete"));
            let text = format!("The search is complete; its nested cross-validation is not.\n\n{summary}");
            Kept { files: written.write(Some(&fitted), &summary), text }
        });
        search.validate(&mut made, &shown)?;
    }
    drop(shown);
    if args.parameters.is_some() || args.report.is_some() || args.json {
        made.compute_parameters();
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
        let (data, labels) = (&search.campaign_of(&made).data, &search.source.info.visit_labels);
        folder.add(&mut files, summary, &inputs, |run| {
            Ok(discovery_report(summary, &made.found, data, labels, run)?)
        })?;
    }
    if let Some(out) = &args.out {
        files.add(out, fit_json(out, &made.fitted)?.as_bytes())?;
    }
    let rivals = match &args.rivals {
        Some(folder) => add_rivals(&mut files, folder, &made.found.competitors)?,
        None => Vec::new(),
    };
    watch.whole();
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
    rivals.iter().for_each(|line| terminal::log(line));
    lost.map_or(Ok(()), Err)?;
    conforms(summary.specification.as_ref())
}

/// Where the fit and the result of a run go.
#[derive(Clone)]
struct Written {
    out: Option<PathBuf>,
    result: Option<PathBuf>,
}

impl Written {
    /// Writes what there is of a run that was ended, each file whole or not at all; returns the files.
    fn write(self, fitted: Option<&FittedModel>, summary: &DiscoverySummary) -> Vec<PathBuf> {
        let mut written = Vec::new();
        if let Some((out, fitted)) = self.out.zip(fitted)
            && write_fit(&out, fitted).is_ok()
        {
            written.push(out);
        }
        let text = serde_json::to_string_pretty(summary).map(|text| text + "\n").ok();
        if let Some((result, text)) = self.result.zip(text)
            && write_whole(&result, text.as_bytes()).is_ok()
        {
            written.push(result);
        }
        written
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
