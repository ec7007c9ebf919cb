//! Frames and tools that were taught with the uncorrected robot, and what is stated about the others.

use super::request::ProgramRequest;
use super::rows::Part;
use crate::error::WorkflowError;
use crate::recorded::recorded_columns;
use truepose_controllers::{CorrectOptions, Outcome, Reference, Taught, Touched, Value, is_stated};
use truepose_errormodel::FittedModel;
use truepose_io::{MeasurementsOptions, read_measurements};
use truepose_kinematics::Pose;

/// The joints at which frames and tools were touched, from their files; warnings about these are added to `warnings`.
pub(super) fn taught(
    request: &ProgramRequest,
    fitted: &FittedModel,
    warnings: &mut Vec<String>,
) -> Result<Vec<Taught>, WorkflowError> {
    let mut all: Vec<Taught> = Vec::new();
    for from in &request.taught {
        let mut columns = recorded_columns(fitted);
        columns.usual_names.push(("id".into(), "point".into()));
        let options =
            MeasurementsOptions { measured_required: false, columns, ..MeasurementsOptions::default() };
        let (rows, info, found) = read_measurements(&from.file, fitted.chain(), &options)?;
        warnings.extend(found.iter().map(ToString::to_string));
        let one = |row: usize| Touched {
            word: info.ids.get(row).cloned().unwrap_or_default(),
            line: rows.line.get(row).map_or(row + 2, |&line| line as usize),
            joints: rows.joints.iter().map(|column| column[row]).collect(),
            load: rows.schema.load.then(|| rows.load[row]),
        };
        let stated = request.measured.iter().chain(&request.cad);
        if all.iter().map(|other| &other.name).chain(stated).any(|name| *name == from.name) {
            let words = format!("how `{}` was made is stated twice", from.name);
            return Err(WorkflowError::option("taught", words));
        }
        all.push(Taught {
            name: from.name.clone(),
            tool: from.tool.clone(),
            file: from.file.display().to_string(),
            touched: (0..rows.len()).map(one).collect(),
        });
    }
    Ok(all)
}

/// Frames of corrected points that are not the base, and about which nothing is stated.
pub(super) fn open(parts: &[Part<'_>], options: &CorrectOptions) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for part in parts {
        let points = part.program.points().iter().zip(part.corrections).zip(part.own);
        for ((point, correction), own) in points {
            let Value::Pose { frame, .. } = &point.value else { continue };
            let moved = match frame {
                Reference::Identity | Reference::Excluded(_) => false,
                Reference::Value(pose) => *pose != Pose::IDENTITY,
                Reference::Unknown(_) => options.frame.is_some_and(|pose| pose != Pose::IDENTITY),
                Reference::Named(name) if is_stated(name, part.program, options) => false,
                Reference::Named(name) => {
                    let given = options.frames.iter().find(|(other, _)| other.eq_ignore_ascii_case(name));
                    let own = part.program.definitions().get(name).ok().flatten();
                    given.map(|(_, pose)| *pose).or(own).is_none_or(|pose| pose != Pose::IDENTITY)
                }
            };
            let name = match frame {
                Reference::Named(name) => part.program.definitions().last_name(name).to_owned(),
                _ => frame.words(),
            };
            if *own && moved && correction.outcome == Outcome::Corrected && !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names
}

/// A note on them.
pub(super) fn note(names: &[String]) -> Option<String> {
    let list = match names.len() {
        0 => return None,
        1..=5 => names.join(", "),
        _ => format!("{}, …", names[..5].join(", ")),
    };
    Some(format!(
        "frames are taken as they are ({list}): one that was taught by touching with this robot has the robot's errors in it, and points \
         in it are compensated twice there (--taught NAME=FILE with the joints at which it was touched; --measured NAME or --cad NAME where \
         it was not taught)"
    ))
}
