//! `truepose iso9283`: pose accuracy, repeatability and the other figures of the standard.

use super::reporting::Folder;
use super::{print_json, robot, usable_fit};
use crate::args::{FramesFrom, Iso9283, Robot};
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use std::path::Path;
use truepose_acceptance::{Alignment, AssessmentOptions, assess};
use truepose_io::{WholeFiles, read_measurements};
use truepose_report::{AcceptanceSummary, acceptance_report};
use truepose_workflow::{in_session, one_installation};

/// Runs the verb; [`Failure::Criterion`] where a figure does not conform to its limit.
pub fn run(args: &Iso9283, watch: &Watch) -> Result<(), Failure> {
    let folder = Folder::with_head(args.report.as_ref(), "acceptance.json", args.robot.as_ref())?
        .map(|folder| folder.certified(args.certificate.as_ref()))
        .transpose()?;
    // Errors of instrument and log are none of the robot.
    let fitted = match &args.fit {
        Some(file) => {
            Some(in_session(usable_fit(file, &args.accept)?, args.session.as_deref(), false)?.of_robot())
        }
        None => None,
    };
    let (chain, reading) = match (&fitted, &args.robot) {
        (Some(fitted), _) => (fitted.chain().clone(), args.grouped.measured_for(fitted)),
        (None, Some(file)) => {
            let of = Robot {
                robot: file.clone(),
                base: args.base.clone(),
                tip: args.tip.clone(),
                base_known: true,
                tool_known: true,
            };
            (robot(&of)?, args.grouped.measured_on(file)?)
        }
        (None, None) => return Err(Failure::Input("--robot or --fit: one of them is needed".into())),
    };
    let (data, info, warnings) = read_measurements(&args.data, &chain, &reading)?;
    terminal::warn(&warnings);
    one_installation(&info, &args.data)?;
    watch.doing("assessing repeated poses");
    let options = AssessmentOptions {
        alignment: args.align.map(|align| match align {
            FramesFrom::Described => Alignment::Described,
            FramesFrom::BestFit => Alignment::BestFit,
        }),
        common: args.instrument.unwrap_or(0.0),
        path: args.path,
    };
    let found = assess(&chain, fitted.as_ref(), &data, &options)
        .map_err(|error| Failure::Input(format!("{}: {error}", args.data.display())))?;
    let summary = AcceptanceSummary::new(chain.name(), data.len(), &found, &args.spec);
    let mut files = WholeFiles::default();
    if let Some(folder) = &folder {
        let inputs: Vec<&Path> =
            [args.robot.as_ref(), args.fit.as_ref(), Some(&args.data), args.certificate.as_ref()]
                .into_iter()
                .flatten()
                .map(|file| &**file)
                .collect();
        folder.add(&mut files, &summary, &inputs, |run| Ok(acceptance_report(&summary, run)))?;
    }
    files.finish()?;
    if args.json {
        print_json(&summary)?;
    } else {
        terminal::print(&summary.to_string());
    }
    if let Some(folder) = &folder {
        terminal::log(&format!("wrote {}", folder.page().display()));
    }
    if summary.fails() { Err(Failure::Criterion(summary.sentence())) } else { Ok(()) }
}
