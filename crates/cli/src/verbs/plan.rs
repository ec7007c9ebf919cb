//! `truepose plan`: further measurements.

use super::plan_options::{goals, options};
use super::reporting::Folder;
use super::told;
use crate::args::{Plan, PlannedTest};
use crate::extensions::effects;
use crate::failure::Failure;
use crate::terminal;
use crate::watch::Watch;
use std::path::Path;
use truepose_errormodel::{DatasetBuilder, FittedModel, Measurement};
use truepose_identify::plan;
use truepose_io::{PlannedVisit, WholeFiles, check_writable, read_fit, write_plan};
use truepose_kinematics::Load;
use truepose_report::{PlanSummary, PlanView, PlannedView, plan_report};
use truepose_workflow::{
    in_session,
    joint_units::{self, in_units, joint_names},
};

/// Runs the verb.
pub fn run(args: &Plan, watch: &Watch) -> Result<(), Failure> {
    if (args.tool || args.targets) && args.test != Some(PlannedTest::Transfer) {
        let option = if args.tool { "--tool" } else { "--targets" };
        return Err(Failure::Input(format!("{option}: belongs to --for transfer")));
    }
    match args.test {
        Some(PlannedTest::Iso9283) => return super::plan_iso9283::run(args, watch),
        Some(PlannedTest::Monitor) => return super::plan_monitor::run(args, watch),
        Some(PlannedTest::Transfer) => return super::plan_transfer::run(args, watch),
        None => {}
    }
    if let Some(robot) = &args.observe {
        return super::plan_observed::run(args, robot, watch);
    }
    check_writable(&args.out)?;
    let file = args.fit.as_ref().ok_or_else(|| Failure::Input("--fit: a fit is needed".into()))?;
    let folder = Folder::with_head(args.report.as_ref(), "plan.json", args.certificate.as_ref())?;
    let registry = effects();
    let fitted = in_session(read_fit(file, registry)?, args.session.as_deref(), true)?;
    let in_session = |fit| in_session(fit, args.session.as_deref(), true);
    let rival = args.rival.as_ref().map(|file| in_session(read_fit(file, registry)?)).transpose()?;
    let goals = goals(args, &fitted)?;
    let options = options(args)?;
    watch.doing("choosing pose measurements");
    let made = plan(&fitted, rival.as_ref(), goals.as_ref(), &options)?;
    let visits: Vec<PlannedVisit> = made
        .visits
        .iter()
        .map(|visit| PlannedVisit {
            joints: visit.conditions.joints.clone(),
            load: visit.conditions.load,
            approach: visit.conditions.approach.clone(),
            why: match visit.why {
                truepose_identify::Why::New => "new",
                truepose_identify::Why::Repeat => "repeat",
            },
            worth: visit.worth,
            observed: Vec::new(),
        })
        .collect();
    let chain = fitted.chain();
    let units = args.units.as_ref().map(|units| joint_units::chosen(chain, &joint_units::si(chain), units));
    write_plan(&args.out, chain, &visits, units.as_deref())?;
    let summary = PlanSummary::new(&made);
    if let Some(folder) = &folder {
        write_page(args, folder, &fitted, &visits, &summary)?;
    }
    told(&summary, args.json, &args.out)
}

/// The page of the plan.
fn write_page(
    args: &Plan,
    folder: &Folder,
    fitted: &FittedModel,
    visits: &[PlannedVisit],
    summary: &PlanSummary,
) -> Result<(), Failure> {
    let chain = fitted.chain();
    let mut rows = DatasetBuilder::new(chain);
    for visit in visits {
        rows.push(Measurement::at(visit.joints.clone()))?;
    }
    let data = rows.finish();
    let pose = |visit: &PlannedVisit| PlannedView {
        joints: in_units(chain, &visit.joints),
        payload_kg: match visit.load {
            Load::Payload(payload) => Some(payload.mass),
            _ => None,
        },
        why: visit.why.into(),
        worth: visit.worth,
    };
    let view = PlanView {
        robot: chain.name().into(),
        summary: summary.clone(),
        joints: joint_names(chain),
        poses: visits.iter().map(pose).collect(),
    };
    let mut files = WholeFiles::default();
    let inputs: Vec<&Path> =
        [args.fit.as_ref(), args.rival.as_ref(), args.at.as_ref(), args.certificate.as_ref()]
            .into_iter()
            .flatten()
            .map(|file| &**file)
            .collect();
    folder.add(&mut files, &view, &inputs, |run| Ok(plan_report(&view, chain, &data, run)))?;
    files.finish()?;
    terminal::log(&format!("wrote {}", folder.page().display()));
    Ok(())
}
