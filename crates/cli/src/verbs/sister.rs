//! `truepose identify --prior FLEET`: a robot from few poses, with its sisters as prior.

use super::folds::{different, split};
use super::sessions::one;
use super::{print_json, robot};
use crate::args::Identify;
use crate::extensions::effects;
use crate::failure::Failure;
use crate::terminal;
use crate::verdict::{FLEET, of_fleet};
use std::path::Path;
use truepose_errormodel::{Dataset, ErrorModel, FittedModel};
use truepose_identify::{FitOptions, Folds, Split, fit, place};
use truepose_io::{check_writable, read_fit, read_measurements, write_fit};
use truepose_kinematics::Chain;
use truepose_report::SisterSummary;
use truepose_solvers::Solver;
use truepose_upkeep::sister;

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
    let chain = robot(&args.measured.robot)?;
    let prior = read_fit(file, effects())?;
    let (mut data, info, warnings) =
        read_measurements(&args.measured.data, &chain, &args.measured.reading()?)?;
    terminal::warn(&warnings);
    terminal::warn(&remarks(file, &prior, &data));
    one(&info, &args.measured.data)?;
    if args.positions_only {
        data.orientation.fill(None);
    }
    let Some(split) = split(args.folds.max(2), args.split, args.seed, different(&data))? else {
        return Err(Failure::Input(format!(
            "{}: one configuration is too few",
            args.measured.data.display()
        )));
    };
    let (fitted, summary) = identified(&prior, &chain, &data, &split, &*args.solver.build())
        .map_err(|words| Failure::Input(format!("{}: {words}", args.measured.data.display())))?;
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
    super::identified::require(args, summary.used_mm() * 1e-3, data.len())
}

/// What speaks against a prior: it is no fleet's, or these rows are in it.
fn remarks(file: &Path, prior: &FittedModel, data: &Dataset) -> Vec<String> {
    let mut all = Vec::new();
    if !of_fleet(prior) {
        let words = "is the fit of one robot, and no fleet's prior: its intervals are not the scatter from robot to robot";
        all.push(format!("{}: {words}", file.display()));
    }
    let known = &prior.domain.sample.rows().joints;
    let of = |row: usize| data.joints.iter().map(move |joint| joint[row].to_bits());
    let count = known.first().map_or(0, Vec::len);
    let seen: std::collections::BTreeSet<Vec<u64>> =
        (0..count).map(|k| known.iter().map(|joint| joint[k].to_bits()).collect()).collect();
    let rows = (0..data.len()).filter(|&row| seen.contains(&of(row).collect::<Vec<_>>())).count();
    if rows > 0 {
        all.push(format!(
            "{}: {rows} of these rows are in the data of this fit: held-out figures are not of unseen poses",
            file.display()
        ));
    }
    all
}

/// The robot with its sisters as prior, or alone where they do not help.
pub(crate) fn identified(
    prior: &FittedModel,
    chain: &Chain,
    data: &Dataset,
    split: &Split,
    solver: &dyn Solver,
) -> Result<(FittedModel, SisterSummary), String> {
    let folds = Folds::new(data, split).map_err(|error| error.to_string())?;
    let plain = |rows: &Dataset| -> Option<FittedModel> {
        let placed = place(chain, rows).ok()?.chain;
        let model = ErrorModel::new(placed, prior.model().effects().to_vec()).ok()?;
        Some(fit(&model, rows, solver, &FitOptions::default()).ok()?.fitted)
    };
    let found = sister(prior, chain, data, &folds, &plain).map_err(|error| error.to_string())?;
    let mut fitted = match (found.helps(), plain(data)) {
        (false, Some(alone)) => alone,
        _ => found.made.fitted.clone(),
    };
    // A robot of its own, whatever it was pulled towards.
    fitted.provenance.remove(FLEET);
    fitted.provenance.insert("prior_is_a_fleet".into(), found.helps().into());
    let summary = SisterSummary::new(&found, data);
    Ok((fitted, summary))
}
