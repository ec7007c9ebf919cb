//! Corrections as tables, pages and JSON have them.

use crate::joint_units::{in_units, joint_names};
use std::path::{Path, PathBuf};
use truepose_compensate::installation;
use truepose_controllers::{Correction, Point, Program, Value};
use truepose_errormodel::FittedModel;
use truepose_io::CorrectionRow;
use truepose_kinematics::nalgebra::Vector3;
use truepose_report::{CorrectionView, ProgramView};

/// A file of the program, with what became of its points.
#[derive(Debug)]
pub(super) struct Part<'a> {
    pub(super) file: &'a Path,
    pub(super) program: &'a Program,
    pub(super) corrections: &'a [Correction],
    /// Points that are the program's: of a further file, those to which a motion goes.
    pub(super) own: &'a [bool],
}

/// Names and lines of a file's points.
#[derive(Debug)]
pub struct Labels {
    pub(super) file: PathBuf,
    pub(super) points: Vec<(String, usize)>,
}

impl Labels {
    pub(super) fn of(part: &Part<'_>) -> Labels {
        let points = part.program.points().iter().map(|point| (point.name.clone(), point.line));
        Labels { file: part.file.into(), points: points.collect() }
    }
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::Pose { .. } => "pose",
        Value::Joints(_) => "joints",
    }
}

/// Frame and tool in words.
fn placed(value: &Value) -> (String, String) {
    match value {
        Value::Pose { frame, tool, .. } => (frame.words(), tool.words()),
        Value::Joints(_) => (String::new(), String::new()),
    }
}

pub(super) fn rows(part: &Part<'_>) -> Vec<CorrectionRow> {
    let one = |(point, correction): (&Point, &Correction)| {
        let (frame, tool) = placed(&point.value);
        CorrectionRow {
            name: point.name.clone(),
            line: point.line,
            kind: kind(&point.value).into(),
            frame,
            tool,
            outcome: correction.outcome.word().into(),
            reason: correction.reason.clone(),
            desired: correction.desired.unwrap_or([f64::NAN; 3]),
            displacement: correction.displacement.unwrap_or([f64::NAN; 3]),
            rotation: correction.rotation.unwrap_or(f64::NAN),
            within_95: correction.within_95.unwrap_or(f64::NAN),
            nominal: correction.nominal.clone().unwrap_or_default(),
            corrected: correction.corrected.clone().unwrap_or_default(),
        }
    };
    let points = part.program.points().iter().zip(part.corrections).zip(part.own);
    points.filter(|(_, own)| **own).map(|(pair, _)| one(pair)).collect()
}

pub(super) fn view(
    fitted: &FittedModel,
    parts: &[Part<'_>],
    dry_run: bool,
    open_frames: Vec<String>,
) -> ProgramView {
    let chain = fitted.chain();
    let turned = installation(fitted).map_or(chain.base().pose, |found| found.base).rotation;
    let variables = |values: &Vec<f64>| {
        let mut joints = values.clone();
        chain.joints_from_controller(&mut joints);
        in_units(chain, &joints)
    };
    let points = parts.iter().flat_map(|part| {
        let file = short(part.file);
        let own = part.program.points().iter().zip(part.corrections).zip(part.own).filter(|(_, own)| **own);
        own.map(move |(pair, _)| (file.clone(), pair))
    });
    let one = |(file, (point, correction)): (String, (&Point, &Correction))| {
        let displacement = correction.displacement.map(|d| d.map(|v| 1e3 * v));
        let moved = displacement.map(|d| (turned * Vector3::from(d)).into());
        let (frame, tool) = placed(&point.value);
        CorrectionView {
            file,
            name: point.name.clone(),
            line: point.line,
            kind: kind(&point.value).into(),
            frame,
            tool,
            outcome: correction.outcome.word().into(),
            reason: correction.reason.clone(),
            at_mm: correction.desired.map(|place| place.map(|v| 1e3 * v)),
            displacement_mm: displacement,
            moved_mm: moved,
            correction_mm: displacement.map(|d| d.iter().map(|v| v * v).sum::<f64>().sqrt()),
            rotation_deg: correction.rotation.map(f64::to_degrees),
            within_95_mm: correction.within_95.map(|v| 1e3 * v),
            joints: correction.nominal.as_ref().map(variables),
        }
    };
    let notes = parts.iter().flat_map(|part| {
        let own = part.program.notes().iter().filter(|note| note.file == 0);
        own.map(|note| {
            let words = format!("{}, line {}: {}: {}", short(part.file), note.line, note.name, note.words);
            if note.missing.is_some() { format!("{words}: it stays as it is") } else { words }
        })
    });
    let first = parts.first();
    ProgramView {
        robot: chain.name().into(),
        program: first.map(|part| short(part.file)).unwrap_or_default(),
        language: first.map(|part| part.program.dialect().word().into()).unwrap_or_default(),
        dry_run,
        open_frames,
        joints: joint_names(chain),
        offsets: Vec::new(),
        notes: notes.collect(),
        points: points.map(one).collect(),
        changed: Vec::new(),
    }
}

/// The name of a file, without its folder.
pub fn short(file: &Path) -> String {
    file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}
