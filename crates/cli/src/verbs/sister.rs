//! `truepose identify --prior FLEET`: a robot from few poses, with its sisters as prior.

use super::criteria::require;
use super::print_json;
use crate::args::Identify;
use crate::extensions::effects;
use crate::failure::Failure;
use crate::terminal;
use std::path::Path;
use truepose_io::{check_writable, read_fit, write_fit};
use truepose_workflow::{FoldsRequest, Inputs, identify_sister, one_installation, prior_remarks, split};

/// Runs the verb.
pub fn run(args: &Identify, file: &Path) -> Result<(), Failure> {
    let unread = [
        ("--model", args.measured.model.is_some()),
        ("--report", args.report.is_some()),
        ("--parameters", args.parameters.is_some()),
        ("--holdout", args.holdout.is_some()),
        ("--spec", args.spec.is_some()),
        ("--stream", args.stream),
    ];
    if let Some((option, _)) = unread.into_iter().find(|(_, given)| *given) {
        let words = format!("{option}: cannot be used with a fleet as prior; the model is that of the fleet");
        return Err(Failure::Input(words));
    }
    if let Some(out) = &args.out {
        check_writable(out)?;
    }
    let prior = read_fit(file, effects())?;
    let (Inputs { chain, data, info, .. }, warnings) =
        args.measured.files(args.positions_only).read(effects())?;
    terminal::warn(&warnings);
    terminal::warn(&prior_remarks(file, &prior, &data));
    one_installation(&info, &args.measured.data)?;
    let folds = FoldsRequest::Count(args.folds.max(2), args.split.into());
    let (split, fewer) = split(&data, &folds, args.seed, None)?;
    terminal::warn(fewer.as_slice());
    let Some(split) = split else {
        return Err(Failure::Input(format!(
            "{}: one configuration is too few",
            args.measured.data.display()
        )));
    };
    let (fitted, summary) = identify_sister(&prior, &chain, &data, &split, &*args.solver.build())
        .map_err(|error| Failure::Input(format!("{}: {error}", args.measured.data.display())))?;
    if let Some(out) = &args.out {
        write_fit(out, &fitted)?;
    }
    if args.json {
        print_json(&summary)?;
    } else {
        terminal::print(&summary.to_string());
    }
    if let Some(out) = &args.out {
        terminal::log(&format!("wrote {}", out.display()));
    }
    require(args, summary.used_mm() * 1e-3, data.len())
}
