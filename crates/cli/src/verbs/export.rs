//! `truepose export`: the fitted geometry in forms that other controllers take.

use super::sessions::chosen;
use super::{parameters, print_json, target};
use crate::args::{Export, ExportFormat, YamlStyle};
use crate::extensions::effects;
use crate::failure::Failure;
use crate::terminal;
use crate::verdict::usable;
use std::path::Path;
use truepose_compensate::{
    Accuracy, AxisConvention, AxisTableOptions, Comparison, ExportOptions, Exported, JointOrigins,
    ParameterTable, RemainingError, RosStyle, axis_table, error_tables, joint_origins, parameter_table,
};
use truepose_errormodel::{FittedModel, TargetKnown};
use truepose_io::{
    UrdfCorrection, check_writable, corrected_urdf, read_fit, read_kinematics, robot_urdf, write_whole,
};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Coupling, Mimic, Pose};

/// The text of a file, with its statement of accuracy.
pub(crate) struct Written {
    pub text: String,
    left_out: Vec<&'static str>,
    remaining_error: RemainingError,
    comparison: Comparison,
    pub statement: Vec<String>,
}

/// What is written of a fit.
pub(crate) struct Wanted<'a> {
    pub format: ExportFormat,
    /// The URDF that is corrected.
    pub urdf: Option<&'a Path>,
    pub hayati: bool,
    pub entries: usize,
    /// Of `ros-yaml`: the maker's form, a file of it, and the controller's hash.
    pub style: Option<YamlStyle>,
    pub like: Option<&'a Path>,
    pub hash: Option<&'a str>,
}

/// Runs the verb.
pub fn run(args: &Export) -> Result<(), Failure> {
    if args.urdf.is_some() && args.format != ExportFormat::Urdf {
        return Err(Failure::Input("--urdf: only `--format urdf` corrects a URDF".into()));
    }
    let styled = args.format == ExportFormat::RosYaml;
    for (option, given) in
        [("--style", args.style.is_some()), ("--like", args.like.is_some()), ("--hash", args.hash.is_some())]
    {
        if given && !styled {
            return Err(Failure::Input(format!("{option}: only `--format ros-yaml` has it")));
        }
    }
    if args.hash.is_some() && args.style != Some(YamlStyle::Ur) {
        return Err(Failure::Input("--hash: only `--style ur` has a hash".into()));
    }
    check_writable(&args.out)?;
    let fitted = chosen(
        usable(&args.fit, read_fit(&args.fit, effects())?, args.accept.accept)?,
        args.session.as_deref(),
        true,
    )?
    .of_robot();
    let target = target(&fitted, args.target.as_deref())?;
    let options = ExportOptions { target, ..ExportOptions::default() };
    let wanted = Wanted {
        format: args.format,
        urdf: args.urdf.as_deref(),
        hayati: !args.no_hayati,
        entries: args.entries as usize,
        style: args.style,
        like: args.like.as_deref(),
        hash: args.hash.as_deref(),
    };
    let Some(written) = text(&wanted, &fitted, &options)? else {
        return as_described(args, &fitted, &options);
    };
    write_whole(&args.out, written.text.as_bytes())?;
    if args.json {
        let Comparison { nominal, export, model, rows, drawn_from, measured } = written.comparison;
        let rms = |a: Accuracy| serde_json::json!({"aligned_mm": 1e3 * a.aligned, "as_written_mm": 1e3 * a.as_written});
        return print_json(&serde_json::json!({
            "left_out": written.left_out,
            "error_left": {"rms_mm": 1e3 * written.remaining_error.rms, "max_mm": 1e3 * written.remaining_error.max},
            "rms": {
                "nominal": rms(nominal), "export": rms(export), "model": rms(model),
                "rows": rows, "drawn_from": drawn_from, "measured": measured,
            },
        }));
    }
    terminal::print(&format!("written to {}\n", args.out.display()));
    for line in &written.statement[1..] {
        terminal::print(&format!("{line}\n"));
    }
    Ok(())
}

/// The text of a file; none of the parameters as described, which are a table.
pub(crate) fn text(
    wanted: &Wanted<'_>,
    fitted: &FittedModel,
    options: &ExportOptions,
) -> Result<Option<Written>, Failure> {
    if !fitted.chain().is_serial() && wanted.format != ExportFormat::Urdf {
        let why = "the robot branches, and this format holds a chain of joints: use --format urdf";
        return Err(Failure::Input(why.into()));
    }
    Ok(Some(match wanted.format {
        ExportFormat::Urdf => urdf(wanted, fitted, options)?,
        ExportFormat::Dh => axes(wanted, fitted, options, AxisConvention::Dh)?,
        ExportFormat::Mdh => axes(wanted, fitted, options, AxisConvention::Mdh)?,
        ExportFormat::Ros => {
            let origins = joint_origins(fitted, options)?;
            let mut notes = notes(fitted, &origins);
            notes.extend(targets(fitted, &origins.value.targets));
            written(origins.value.to_ros_yaml(&notes), origins, notes)
        }
        ExportFormat::RosYaml => ros_yaml(wanted, fitted, options)?,
        ExportFormat::Iso230 => {
            let tables = error_tables(fitted, options, wanted.entries)?;
            let notes = notes(fitted, &tables);
            written(tables.value.to_csv(fitted.chain(), &notes), tables, notes)
        }
        ExportFormat::Parameters => return Ok(None),
    }))
}

fn written<T>(text: String, exported: Exported<T>, statement: Vec<String>) -> Written {
    let Exported { left_out, remaining_error, comparison, .. } = exported;
    Written { text, left_out, remaining_error, comparison, statement }
}

/// The statement at the top of the file; the terminal shows it without the first line.
fn notes<T>(fitted: &FittedModel, exported: &Exported<T>) -> Vec<String> {
    let mut notes = vec![format!(
        "truepose {}: geometry of `{}` as fitted",
        env!("CARGO_PKG_VERSION"),
        fitted.chain().name()
    )];
    notes.extend(exported.statement());
    notes.extend(couplings(fitted.chain()));
    match fitted.orientation_known() {
        TargetKnown::Measured => {}
        TargetKnown::Declared => {
            notes.push("no orientation was measured: the orientation of the tool is not verified".into());
        }
        TargetKnown::Undetermined => notes.push(
            "no orientation was measured, and the orientation of the tool was unknown: it is not determined"
                .into(),
        ),
    }
    // A line of a comment ends where it ends, for every reader.
    let ends = |c: char| {
        c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{fffe}' | '\u{ffff}')
    };
    notes.iter().map(|note| note.replace(ends, "\u{fffd}")).collect()
}

/// How the variables of the file follow from the controller's values, which the formats cannot hold.
fn couplings(chain: &Chain) -> Vec<String> {
    let name = |joint| &chain.joint(joint).name;
    let words = |c: &Coupling| {
        let (joint, driver) = (name(c.joint), name(c.driver));
        format!(
            "the variable of {joint} contains {:?} times the controller's value of {driver}, besides its own",
            c.factor
        )
    };
    let follows = |m: &Mimic| {
        let (joint, driver, ratio, offset) = (name(m.joint), name(m.driver), m.ratio, m.offset);
        format!(
            "the variable of {joint} is {ratio:?} times that of {driver}, plus {offset:?} (rad, m); it has no value of its own"
        )
    };
    chain.couplings().iter().map(words).chain(chain.mimics().iter().map(follows)).collect()
}

/// Estimated positions of targets on the tool, which the formats cannot hold.
fn targets(fitted: &FittedModel, found: &[Vector3<f64>]) -> Vec<String> {
    let both = fitted.chain().targets().iter().zip(found);
    both.filter(|(declared, found)| !declared.known || declared.position != **found)
        .map(|(declared, found)| {
            let [x, y, z]: [f64; 3] = (*found).into();
            format!("target `{}` is on the tool at xyz {x:?} {y:?} {z:?} m", declared.name)
        })
        .collect()
}

fn axes(
    wanted: &Wanted<'_>,
    fitted: &FittedModel,
    options: &ExportOptions,
    convention: AxisConvention,
) -> Result<Written, Failure> {
    // A robot that is described in this convention keeps the branch of its rows.
    if wanted.hayati
        && let Ok(table) = parameter_table(fitted, options)
    {
        let mut notes = notes(fitted, &table);
        notes.extend(targets(fitted, &positions(&table.value)));
        if let Some(text) = table.value.to_axes_csv(convention, &notes) {
            return Ok(written(text, table, notes));
        }
    }
    let allow = AxisTableOptions { hayati: wanted.hayati, ..AxisTableOptions::default() };
    let table = axis_table(fitted, options, &allow)?;
    let mut notes = notes(fitted, &table);
    notes.extend(targets(fitted, &table.value.targets));
    Ok(written(table.value.to_csv(convention, fitted.chain(), &notes), table, notes))
}

/// Positions of the targets on the tool, m.
fn positions(table: &ParameterTable) -> Vec<Vector3<f64>> {
    table.corrected_robot().targets().iter().map(|target| target.position).collect()
}

/// The kinematics file of a maker's ROS description.
fn ros_yaml(wanted: &Wanted<'_>, fitted: &FittedModel, options: &ExportOptions) -> Result<Written, Failure> {
    let style = match wanted.style {
        Some(YamlStyle::Ur) => RosStyle::Ur,
        Some(YamlStyle::Franka) => RosStyle::Franka,
        Some(YamlStyle::Flexiv) => RosStyle::Flexiv,
        Some(YamlStyle::Xarm) => RosStyle::XArm,
        None => return Err(Failure::Input("--format ros-yaml needs --style".into())),
    };
    let like = match wanted.like {
        Some(file) => Some(read_kinematics(file, style.word())?),
        None => None,
    };
    let origins = joint_origins(fitted, options)?;
    let styled = origins.value.styled(style, fitted.chain(), like.as_ref());
    let styled = styled.map_err(|error| match wanted.like {
        Some(file) => Failure::Input(format!("{}: {error}", file.display())),
        None => Failure::Input(format!("--style {}: {error}", style.word())),
    })?;
    let mut notes = notes(fitted, &origins);
    notes.extend(targets(fitted, &origins.value.targets));
    let text = styled.to_yaml(wanted.hash, &notes);
    notes.extend(styled.remarks);
    Ok(written(text, origins, notes))
}

/// The parameters of the robot's own description.
fn as_described(args: &Export, fitted: &FittedModel, options: &ExportOptions) -> Result<(), Failure> {
    let exported = parameter_table(fitted, options)?;
    let summary = parameters::summary(fitted, &exported.value, &exported.left_out);
    parameters::file(&args.out, &summary)?.finish()?;
    if args.json {
        return print_json(&summary);
    }
    terminal::print(&format!("written to {}\n{summary}", args.out.display()));
    for line in exported.statement().iter().skip(1) {
        terminal::print(&format!("{line}\n"));
    }
    Ok(())
}

fn urdf(wanted: &Wanted<'_>, fitted: &FittedModel, options: &ExportOptions) -> Result<Written, Failure> {
    let origins = joint_origins(fitted, options)?;
    let mut notes = notes(fitted, &origins);
    notes.extend(targets(fitted, &origins.value.targets));
    let JointOrigins { base, joints, tools, .. } = &origins.value;
    if *base != Pose::IDENTITY {
        notes.push(format!("the base link is in the measurement frame at {}", place(base)));
    }
    let nominal = fitted.chain();
    let text = match wanted.urdf {
        None => robot_urdf(&origins.value.to_chain(nominal)?, &notes),
        Some(path) => {
            if tools.len() > 1 {
                for (tool, pose) in nominal.tools().iter().zip(tools) {
                    let (name, frame) = (&tool.name, nominal.frame_word(tool.frame));
                    notes.push(format!("tool `{name}` is behind joint {frame} at {}", place(pose)));
                }
                let origins = joints.iter().map(|joint| joint.pose).collect();
                let behind = Pose::IDENTITY;
                let correction = UrdfCorrection { origins, behind, comment: notes.clone() };
                let text = corrected_urdf(path, nominal, &correction)?;
                return Ok(written(text, self::joint_origins(fitted, options)?, notes));
            }
            let (declared, tool) = (nominal.tool(), &tools[0]);
            let known = declared.known;
            if !known || declared.pose != Pose::IDENTITY {
                let whole = if known { &declared.pose } else { tool };
                notes.push(format!("the tool is behind the tip link at {}", place(whole)));
            }
            let unchanged = !known || *tool == declared.pose;
            let behind = if unchanged { Pose::IDENTITY } else { *tool * declared.pose.inverse() };
            let origins = joints.iter().map(|joint| joint.pose).collect();
            corrected_urdf(path, nominal, &UrdfCorrection { origins, behind, comment: notes.clone() })?
        }
    };
    Ok(written(text, origins, notes))
}

fn place(pose: &Pose) -> String {
    let triple = |v: [f64; 3]| v.map(|x| format!("{x:?}")).join(" ");
    format!("xyz {} m, rpy {} rad", triple(pose.translation.into()), triple(pose.rpy()))
}
