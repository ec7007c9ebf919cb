//! The fitted geometry in forms that other controllers take.

use crate::error::WorkflowError;
use crate::provenance::PROGRAM;
use std::path::Path;
use truepose_compensate::{
    AxisConvention, AxisTableOptions, Comparison, ExportOptions, Exported, JointOrigins, ParameterTable,
    RemainingError, RosStyle, axis_table, error_tables, joint_origins, parameter_table,
};
use truepose_errormodel::{FittedModel, TargetKnown};
use truepose_io::{UrdfCorrection, corrected_urdf, read_kinematics, robot_urdf};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Coupling, Mimic, Pose};

/// The form of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportFormat {
    /// URDF: a new one, or one whose joint origins are corrected.
    Urdf,
    /// A table of axes after Denavit and Hartenberg.
    Dh,
    /// The same, modified.
    Mdh,
    /// Joint origins as YAML.
    Ros,
    /// The kinematics file of a maker's ROS description.
    RosYaml,
    /// Tables of component errors after ISO 230-1.
    Iso230,
}

impl ExportFormat {
    /// All, with their words.
    pub const WORDS: [(&str, ExportFormat); 6] = [
        ("urdf", ExportFormat::Urdf),
        ("dh", ExportFormat::Dh),
        ("mdh", ExportFormat::Mdh),
        ("ros", ExportFormat::Ros),
        ("ros-yaml", ExportFormat::RosYaml),
        ("iso230", ExportFormat::Iso230),
    ];

    /// That of a word.
    ///
    /// # Errors
    /// When there is none; names those that there are.
    pub fn named(word: &str) -> Result<Self, WorkflowError> {
        let known = Self::WORDS.iter().find(|(known, _)| *known == word);
        known.map(|(_, format)| *format).ok_or_else(|| {
            let words = Self::WORDS.map(|(word, _)| word).join(", ");
            WorkflowError::option("format", format!("unknown `{word}` (known: {words})"))
        })
    }
}

/// The text of a file, with its statement of accuracy.
#[derive(Debug, Clone)]
pub struct ExportedText {
    /// The text.
    pub text: String,
    /// Effects that the format cannot hold.
    pub left_out: Vec<&'static str>,
    /// Error that remains because of them.
    pub remaining_error: RemainingError,
    /// Accuracy of the nominal robot, of the file and of the model.
    pub comparison: Comparison,
    /// What it is and what it leaves out; the first line names the program.
    pub statement: Vec<String>,
}

/// What is written of a fit.
#[derive(Debug, Clone, Copy)]
pub struct ExportRequest<'a> {
    /// The form.
    pub format: ExportFormat,
    /// A URDF whose joint origins are corrected in place.
    pub urdf: Option<&'a Path>,
    /// Whether nearly parallel axes may use Hayati's parameter.
    pub hayati: bool,
    /// Values of each joint in the tables of ISO 230-1.
    pub entries: usize,
    /// The maker's form of [`ExportFormat::RosYaml`].
    pub style: Option<RosStyle>,
    /// A file of that form, whose other entries are kept.
    pub like: Option<&'a Path>,
    /// The hash of the controller, in that file.
    pub hash: Option<&'a str>,
}

/// The fitted geometry as the text of a file; `fitted` is that of the robot alone.
///
/// # Errors
/// When the format cannot hold the robot, a file cannot be read, or the text is less accurate than the nominal geometry.
pub fn export(
    wanted: &ExportRequest<'_>,
    fitted: &FittedModel,
    options: &ExportOptions,
) -> Result<ExportedText, WorkflowError> {
    if !fitted.chain().is_serial() && wanted.format != ExportFormat::Urdf {
        let why = "the robot branches, and this format holds a chain of joints: use --format urdf";
        return Err(WorkflowError::Input(why.into()));
    }
    Ok(match wanted.format {
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
    })
}

fn written<T>(text: String, exported: Exported<T>, statement: Vec<String>) -> ExportedText {
    let Exported { left_out, remaining_error, comparison, .. } = exported;
    ExportedText { text, left_out, remaining_error, comparison, statement }
}

/// The statement at the top of the file; the terminal shows it without the first line.
fn notes<T>(fitted: &FittedModel, exported: &Exported<T>) -> Vec<String> {
    let mut notes = vec![format!("{PROGRAM}: geometry of `{}` as fitted", fitted.chain().name())];
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
    wanted: &ExportRequest<'_>,
    fitted: &FittedModel,
    options: &ExportOptions,
    convention: AxisConvention,
) -> Result<ExportedText, WorkflowError> {
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
fn ros_yaml(
    wanted: &ExportRequest<'_>,
    fitted: &FittedModel,
    options: &ExportOptions,
) -> Result<ExportedText, WorkflowError> {
    let Some(style) = wanted.style else {
        return Err(WorkflowError::option("style", "the format ros-yaml needs one"));
    };
    let like = match wanted.like {
        Some(file) => Some(read_kinematics(file, style.word())?),
        None => None,
    };
    let origins = joint_origins(fitted, options)?;
    let styled = origins.value.styled(style, fitted.chain(), like.as_ref());
    let styled = styled.map_err(|error| match wanted.like {
        Some(file) => WorkflowError::about(file, error),
        None => WorkflowError::option("style", format!("{}: {error}", style.word())),
    })?;
    let mut notes = notes(fitted, &origins);
    notes.extend(targets(fitted, &origins.value.targets));
    let text = styled.to_yaml(wanted.hash, &notes);
    notes.extend(styled.remarks);
    Ok(written(text, origins, notes))
}

fn urdf(
    wanted: &ExportRequest<'_>,
    fitted: &FittedModel,
    options: &ExportOptions,
) -> Result<ExportedText, WorkflowError> {
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
