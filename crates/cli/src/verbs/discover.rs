//! `truepose discover`: find what a declared model lacks, add it, and prove the gain.

use super::reporting::Folder;
use super::{print_json, read_files, robot, suspected};
use crate::args::Discover;
use crate::failure::Failure;
use crate::progress::Progress as Bar;
use crate::terminal;
use crate::watch;
use std::path::Path;
use truepose_discover::{DiscoverOptions, Progress, RivalFit, diagnose, nested};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{AnyEffect, EffectRegistry};
use truepose_io::{
    MeasurementsOptions, check_writable, make_folder, read_measurements, read_model, write_fit,
};
use truepose_report::{DiscoverySummary, NestedSummary, Settings, discovery_report};

/// Runs the verb.
pub fn run(args: &Discover) -> Result<(), Failure> {
    if let Some(out) = &args.out {
        check_writable(out)?;
    }
    let folder = Folder::prepare(args.report.as_ref(), "discovery.json")?;
    if let Some(rivals) = &args.rivals {
        make_folder(rivals)?;
        check_writable(rivals.join("rival.json"))?;
    }
    let chain = robot(&args.robot)?;
    let declared: Vec<Box<dyn AnyEffect>> = match &args.model {
        Some(model) => read_model(model, &chain, &EffectRegistry::builtin())?,
        None => vec![Box::new(Geometric::default())],
    };
    let (mut data, info, warnings) = read_measurements(&args.data, &chain, &MeasurementsOptions::default())?;
    terminal::warn(&warnings);
    terminal::warn(suspected(&chain, &data, &args.data).as_slice());
    if args.positions_only {
        data.orientation.fill(None);
    }
    let options = DiscoverOptions {
        holdout: args.holdout,
        seed: args.seed,
        flips: args.flips,
        alpha: args.alpha,
        most: args.most,
        rival_fits: args.rivals.is_some(),
        ..DiscoverOptions::default()
    };
    let solver = args.solver.build();
    let bar = Bar::spinner();
    let mut found = diagnose(&chain, &declared, &data, &*solver, &options, &|step| {
        if let Progress::Found(words) = &step {
            watch::found(words);
        }
        bar.say(&word(&step));
    })?;
    drop(bar);
    let settings = Settings { seed: args.seed, holdout: args.holdout, flips: args.flips, alpha: args.alpha };
    let mut summary = DiscoverySummary::new(&found, settings);
    if let Some(folds) = args.nested {
        let Some(split) = super::identify::split(usize::from(folds), args.split, args.seed, &data)? else {
            return Err(Failure::Input("--nested: a single configuration cannot be divided".into()));
        };
        let bar = Bar::spinner();
        let judged = nested(&chain, &declared, &data, &split, &*solver, &options, &|fold, step| {
            bar.say(&format!("fold {} of {folds}: {}", fold + 1, word(&step)));
        })?;
        summary.nested = Some(NestedSummary::new(&judged, super::identify::split_words(&split)));
    }
    if let Some(limit) = args.spec {
        summary = summary.against(limit, &found, &data);
    }
    if args.json {
        print_json(&summary)?;
    } else {
        terminal::print(&summary.to_string());
    }
    if let Some(folder) = &folder {
        let inputs = read_files(&args.robot.robot, &args.data, args.model.as_ref());
        folder.write(&summary, &inputs, |run| {
            Ok(discovery_report(&summary, &found, &data, &info.visit_labels, run)?)
        })?;
    }
    if let Some(out) = &args.out {
        let provenance = &mut found.fit.fitted.provenance;
        provenance.insert("program".into(), concat!("truepose ", env!("CARGO_PKG_VERSION")).into());
        provenance.insert("verb".into(), "discover".into());
        provenance.insert("solver".into(), args.solver.to_string().into());
        provenance.insert("rows".into(), data.len().into());
        provenance.insert("seed".into(), args.seed.into());
        provenance.insert("structure_frozen_then_all_rows".into(), true.into());
        write_fit(out, &found.fit.fitted)?;
        terminal::log(&format!("wrote {}", out.display()));
    }
    if let Some(folder) = &args.rivals {
        write_rivals(folder, &found.rivals)?;
    }
    Ok(())
}

/// One file a rival, named by what it says.
fn write_rivals(folder: &Path, rivals: &[RivalFit]) -> Result<(), Failure> {
    if rivals.is_empty() {
        terminal::log("no rivals to write: nothing else explains the data as well as what was found");
    }
    for rival in rivals {
        let plain = |c: char| if c.is_alphanumeric() || c == '_' || c == '.' { c } else { '-' };
        let words: String = rival.candidate.words().chars().map(plain).collect();
        let file = folder.join(format!("{}-{words}.json", rival.finding + 1));
        write_fit(&file, &rival.fit.fitted)?;
        let words = rival.candidate.words();
        terminal::log(&format!("wrote {}: {words} in place of find {}", file.display(), rival.finding + 1));
    }
    Ok(())
}

fn word(step: &Progress) -> String {
    match step {
        Progress::Fitting => "fitting the declared model".into(),
        Progress::Screening(0) => "screening all candidates".into(),
        Progress::Screening(found) => format!("screening again, {found} found"),
        Progress::Found(words) => format!("found {words}; fitting"),
        Progress::Reconsidering => "looking at earlier finds again".into(),
        Progress::Judging => "judging on the rows that were held out".into(),
    }
}
