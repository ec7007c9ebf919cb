//! What a program states besides its points.

use super::rows::{Part, short};
use truepose_controllers::{CorrectOptions, Outcome, Reference, Value};
use truepose_errormodel::FittedModel;
use truepose_kinematics::Pose;

/// A line for each.
pub(super) fn statements(
    fitted: &FittedModel,
    parts: &[Part<'_>],
    options: &CorrectOptions,
    payload: Option<f64>,
) -> Vec<String> {
    let mut all = Vec::new();
    all.extend(taught(parts, options));
    all.extend(loads(fitted, parts, payload));
    all
}

/// Frames of corrected points that are not the base, whose origin is not stated.
fn taught(parts: &[Part<'_>], options: &CorrectOptions) -> Option<String> {
    let mut names: Vec<String> = Vec::new();
    for part in parts {
        let points = part.program.points().iter().zip(part.corrections).zip(part.own);
        for ((point, correction), own) in points {
            let Value::Pose { frame, .. } = &point.value else { continue };
            let moved = match frame {
                Reference::Identity | Reference::Excluded(_) => false,
                Reference::Value(pose) => *pose != Pose::IDENTITY,
                Reference::Unknown(_) => options.frame.is_some_and(|pose| pose != Pose::IDENTITY),
                Reference::Named(name) => {
                    let given = options.frames.iter().find(|(other, _)| other.eq_ignore_ascii_case(name));
                    let own = part.program.definitions().get(name).ok().flatten();
                    given.map(|(_, pose)| *pose).or(own).is_none_or(|pose| pose != Pose::IDENTITY)
                }
            };
            let name = frame.words();
            if *own && moved && correction.outcome == Outcome::Corrected && !names.contains(&name) {
                names.push(name);
            }
        }
    }
    let list = match names.len() {
        0 => return None,
        1..=5 => names.join(", "),
        _ => format!("{}, …", names[..5].join(", ")),
    };
    Some(format!(
        "frames are taken as they are ({list}): one that was taught by touching with this robot has the robot's errors in it, and points \
         in it are compensated twice there; measure such a frame, or teach it anew with compensated points"
    ))
}

/// Loads that the program states, where the fit has an effect of the load and none is given.
fn loads(fitted: &FittedModel, parts: &[Part<'_>], payload: Option<f64>) -> Option<String> {
    let known = fitted.domain.payload.as_ref()?;
    if payload.is_some() {
        return None;
    }
    let stated: Vec<String> = parts
        .iter()
        .flat_map(|part| {
            part.program
                .notes()
                .iter()
                .filter(|note| note.load && note.file == 0)
                .map(|note| (part.file, note))
        })
        .take(3)
        .map(|(file, note)| format!("{}, line {}: {}", short(file), note.line, note.words))
        .collect();
    if stated.is_empty() && known.upper - known.lower <= 0.0 {
        return None;
    }
    let words = match stated.is_empty() {
        true => "the program states none".into(),
        false => stated.join("; "),
    };
    Some(format!(
        "the fit has loads from {} kg to {} kg, and the program is compensated without a load, as none is stated (--payload, --com): {words}",
        known.lower, known.upper
    ))
}
