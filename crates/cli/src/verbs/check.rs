//! `truepose check`: read files and say what was understood.

use super::{print_json, robot};
use crate::args::Check;
use crate::extensions::effects;
use crate::failure::Failure;
use crate::terminal;
use std::path::Path;
use truepose_errormodel::ErrorModel;
use truepose_io::{CsvInfo, Grouping, MeasurementsOptions};
use truepose_kinematics::{Chain, GravityFrame, JointId, JointKind, ToolId};
use truepose_report::Alignment::{Left, Right};
use truepose_report::{count, significant, table};
use truepose_workflow::{InputFiles, Nominal, check_rows};

/// Runs the verb.
pub fn run(args: &Check) -> Result<(), Failure> {
    let files = InputFiles {
        data: args.data.as_deref().unwrap_or(Path::new("")).to_path_buf(),
        model: args.model.as_ref().map(|file| file.to_path_buf()),
        reading: MeasurementsOptions { measured_required: false, ..args.grouped.measured() },
        ..args.robot.files()
    };
    let (mut chain, inputs) = match args.data {
        Some(_) => {
            let (inputs, warnings) = files.read(effects())?;
            terminal::warn(&warnings);
            (inputs.chain.clone(), Some(inputs))
        }
        None => (robot(&args.robot)?, None),
    };
    let model = match &args.model {
        Some(_) => Some(ErrorModel::new(chain.clone(), files.effects(&chain, effects())?)?),
        None => None,
    };
    let (mut nominal, mut several_points) = (Nominal::of(&chain, None, &[]), Ok(()));
    let data = inputs.as_ref().map(|inputs| inputs.info.clone());
    if let Some(inputs) = inputs {
        let found = check_rows(inputs, model.as_ref())?;
        found.assumed.iter().for_each(|words| terminal::log(words));
        terminal::warn(&found.warnings);
        several_points = found.several_points.map_or(Ok(()), |error| Err(error.into()));
        (chain, nominal) = (found.chain, found.nominal);
    }
    if args.json {
        let mut all = json(&chain, model.as_ref(), data.as_deref());
        all["nominal"] = nominal.json(&chain);
        print_json(&all)?;
        return judged(data.as_deref()).and(several_points);
    }
    terminal::print(&robot_text(&chain));
    if let Some(model) = &model {
        terminal::print(&model_text(model));
    }
    if let Some(info) = &data {
        terminal::print(&data_text(info));
    }
    terminal::print(&nominal.text());
    judged(data.as_deref()).and(several_points)
}

/// Whether a fit would take the data; where it would, what columns without a meaning are perhaps.
fn judged(data: Option<&CsvInfo>) -> Result<(), Failure> {
    let Some(info) = data else { return Ok(()) };
    let (file, proposal) = (info.file.display(), &info.proposal);
    let words = "no measured position, orientation or kind of observation: identify will refuse";
    // A plan or a programme has none either; where columns may be meant, the file is one of measurements.
    if info.unmeasured && proposal.is_empty() {
        terminal::warn(&[format!("{file}: {words}")]);
    } else if info.unmeasured {
        return Err(Failure::Input(format!("{file}: {words}{proposal}")));
    } else if !proposal.is_empty() {
        terminal::warn(&[format!(
            "{file}: some columns are not read, or as channels, that may have a meaning{proposal}"
        )]);
    }
    Ok(())
}

/// Joints, base, tool, targets and gravity.
pub(super) fn robot_text(chain: &Chain) -> String {
    let rows: Vec<Vec<String>> = chain
        .joints()
        .iter()
        .map(|joint| {
            let limits = chain.joint_named(&joint.name).and_then(|id| chain.controller_limits(id));
            let limits = limits.map_or_else(String::new, |(lower, upper)| match joint.kind {
                JointKind::Prismatic => {
                    format!("{} … {} mm", significant(lower * 1e3, 4), significant(upper * 1e3, 4))
                }
                _ => format!(
                    "{} … {} °",
                    significant(lower.to_degrees(), 4),
                    significant(upper.to_degrees(), 4)
                ),
            });
            let mass =
                joint.link.map_or_else(String::new, |link| format!("{} kg", significant(link.mass, 4)));
            let mut cells =
                vec![joint.name.clone(), format!("{:?}", joint.kind).to_lowercase(), limits, mass];
            if !chain.is_serial() {
                let before = chain.joint_named(&joint.name).map(|id: JointId| chain.before(id));
                cells.push(before.map_or_else(String::new, |frame| chain.frame_word(frame).to_owned()));
            }
            cells
        })
        .collect();
    let gravity = chain.gravity();
    let name = |joint| &chain.joint(joint).name;
    let known = |known: bool| if known { "" } else { " (unknown, to be found from data)" };
    let place = |pose: &truepose_kinematics::Pose| {
        let (t, r) = (pose.translation * 1e3, pose.rpy().map(f64::to_degrees));
        format!(
            "xyz {} {} {} mm, rpy {} {} {} °",
            significant(t.x, 5),
            significant(t.y, 5),
            significant(t.z, 5),
            significant(r[0], 4),
            significant(r[1], 4),
            significant(r[2], 4)
        )
    };
    let mut text = format!("robot {}: {}\n", chain.name(), count(chain.movable().len(), "moving joint"));
    let (heads, sides) = (["joint", "type", "limits", "link", "hangs on"], [Left, Left, Left, Right, Left]);
    let columns = if chain.is_serial() { 4 } else { 5 };
    text += &table(&heads[..columns], &sides[..columns], &rows);
    text += &format!(" base {}{}\n", place(&chain.base().pose), known(chain.base().known));
    for (k, tool) in chain.tools().iter().enumerate() {
        let on =
            if chain.is_serial() { String::new() } else { format!(" on {},", chain.frame_word(tool.frame)) };
        let word = chain.frame_word(chain.frame_of_tool(ToolId(k)));
        text += &format!(" {word}{on} {}{}\n", place(&tool.placed.pose), known(tool.placed.known));
    }
    for coupling in chain.couplings() {
        let (joint, driver) = (name(coupling.joint), name(coupling.driver));
        let factor = coupling.factor;
        text +=
            &format!(" {joint} is coupled to {driver}: variable = value + {factor} × value of {driver}\n");
    }
    for mimic in chain.mimics() {
        let (joint, driver) = (name(mimic.joint), name(mimic.driver));
        let (ratio, offset) = (mimic.ratio, mimic.offset);
        let unit = chain.joint(mimic.joint).unit();
        text += &format!(
            " {joint} follows {driver}: value = {ratio} × value of {driver} + {offset} {unit}; it has no column\n"
        );
    }
    for target in chain.targets() {
        let p = target.position * 1e3;
        text += &format!(
            " target {} {} {} {} mm{}\n",
            target.name,
            significant(p.x, 5),
            significant(p.y, 5),
            significant(p.z, 5),
            known(target.known)
        );
    }
    let g = gravity.vector;
    let frame = if gravity.frame == GravityFrame::Base { "base" } else { "measurement" };
    text + &format!(
        " gravity {} {} {} m/s² in the {frame} frame\n",
        significant(g.x, 4),
        significant(g.y, 4),
        significant(g.z, 4)
    )
}

fn model_text(model: &ErrorModel) -> String {
    let mut text = format!("\nmodel: {}\n", count(model.columns().len(), "unknown"));
    for (k, effect) in model.effects().iter().enumerate() {
        text += &format!(" {} ({})\n", effect.kind(), count(model.columns_of(k).len(), "unknown"));
    }
    text
}

fn data_text(info: &CsvInfo) -> String {
    let rows: Vec<Vec<String>> = info
        .columns
        .iter()
        .map(|column| {
            // Names, numbers and directions have no unit.
            let known = column.unit_given || column.unit == "1";
            let unit = if known { column.unit.clone() } else { format!("{} (assumed)", column.unit) };
            let (lower, upper) = column
                .range
                .map_or((String::new(), String::new()), |(a, b)| (significant(a, 6), significant(b, 6)));
            // Cells that are not read are not counted.
            let filled = if column.meaning == "not read" { "–".into() } else { column.filled.to_string() };
            vec![column.name.clone(), unit, filled, lower, upper, column.meaning.clone()]
        })
        .collect();
    let mut text = format!(
        "\ndata {}: {}, {}, {}\n",
        info.file.display(),
        count(info.rows, "row"),
        count(info.visits, "pose measurement"),
        count(info.configurations, "configuration")
    );
    if let Some(grouping) = &info.grouping {
        text += &grouping_text(grouping);
    }
    text += &table(
        &["column", "unit", "filled", "smallest", "largest", "meaning"],
        &[Left, Left, Right, Right, Right, Left],
        &rows,
    );
    text
}

/// How rows are grouped into pose measurements and configurations, and with which tolerance.
fn grouping_text(of: &Grouping) -> String {
    let angle = |v: f64| format!("{}°", significant(v.to_degrees(), 2));
    let um = |v: f64| format!("{} µm", significant(v * 1e6, 2));
    let mut text = if of.numbered {
        " pose measurements as numbered in the file (column `visit`)".to_owned()
    } else {
        format!(
            " no column `visit`: consecutive rows with joints within {} or {} are one pose measurement",
            angle(of.angle),
            um(of.length)
        )
    };
    let most = |turned: f64, slid: f64| {
        let parts = [(turned > 0.0).then(|| angle(turned)), (slid > 0.0).then(|| um(slid))];
        parts.into_iter().flatten().collect::<Vec<_>>().join(" and ")
    };
    if of.flickering > 0 {
        text += &format!(
            "; joint values vary within a dwell by up to {} in {}",
            most(of.flicker_angle, of.flicker_length),
            count(of.flickering, "row")
        );
    }
    if of.parted > 0 {
        let parted = count(of.parted, "pose measurement");
        text += &format!("; {parted} separated from the one before by measured positions alone");
    }
    text += &format!(
        "\n pose measurements with joints within {} or {} (ten times --dwell-tolerance) are repeats of one configuration: ",
        angle(of.repeat_tolerance_angle),
        um(of.repeat_tolerance_length)
    );
    text += &match of.repeats {
        0 => "none".to_owned(),
        repeats => {
            let apart = most(of.repeat_angle, of.repeat_length);
            let apart =
                if apart.is_empty() { "equal joint values".into() } else { format!("up to {apart} apart") };
            format!("{} of {}, {apart}", count(repeats, "repeat"), count(of.repeated, "configuration"))
        }
    };
    text + "\n"
}

fn json(chain: &Chain, model: Option<&ErrorModel>, data: Option<&CsvInfo>) -> serde_json::Value {
    let limits = |name: &str| chain.joint_named(name).and_then(|id| chain.controller_limits(id));
    let joints: Vec<_> = chain
        .joints()
        .iter()
        .map(|j| serde_json::json!({"name": j.name, "type": j.kind, "limits": limits(&j.name), "mass_kg": j.link.map(|l| l.mass)}))
        .collect();
    let columns = data.map(|info| {
        info.columns
            .iter()
            .map(|c| {
                serde_json::json!({"name": c.name, "unit": c.unit, "unit_given": c.unit_given, "meaning": c.meaning,
                    "filled": c.filled, "range": c.range})
            })
            .collect::<Vec<_>>()
    });
    let unknowns = model.map(|m| m.columns().iter().map(|c| c.name.clone()).collect::<Vec<_>>());
    serde_json::json!({
        "robot": {"name": chain.name(), "joints": joints, "targets": chain.targets(), "base": chain.base(), "tool": chain.tool()},
        "model": unknowns,
        "data": data.map(|i| serde_json::json!({"rows": i.rows, "visits": i.visits, "configurations": i.configurations,
            "grouping": i.grouping.map(|g| serde_json::json!({"numbered": g.numbered, "tolerance_rad": g.angle, "tolerance_m": g.length,
                "repeat_tolerance_rad": g.repeat_tolerance_angle, "repeat_tolerance_m": g.repeat_tolerance_length,
                "repeated_configurations": g.repeated, "repeats": g.repeats, "repeat_rad": g.repeat_angle, "repeat_m": g.repeat_length,
                "flickering_rows": g.flickering, "flicker_rad": g.flicker_angle, "flicker_m": g.flicker_length, "parted": g.parted})),
            "columns": columns})),
    })
}
