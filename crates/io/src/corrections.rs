//! The corrections of a robot program's points as a CSV file.

use crate::commanded::commanded;
use crate::poses::si_unit;
use crate::table::TableWriter;
use crate::{IoError, WholeFile};
use std::io::Read;
use std::path::Path;
use truepose_kinematics::Chain;

/// One point of a program. NaN, and a missing list of joints, make empty cells.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrectionRow {
    /// As the program calls it.
    pub name: String,
    /// Line of the program, from 1.
    pub line: usize,
    /// `pose` or `joints`.
    pub kind: String,
    /// Frame of a pose, in words.
    pub frame: String,
    /// Tool of a pose, in words.
    pub tool: String,
    /// What became of it.
    pub outcome: String,
    /// Why, where it is not corrected.
    pub reason: String,
    /// Desired position of the tool of the measurements, m, measurement frame.
    pub desired: [f64; 3],
    /// How far the point is displaced, m, axes of the robot's base.
    pub displacement: [f64; 3],
    /// How far it is turned, rad.
    pub rotation: f64,
    /// The real robot comes within this of the desired position with 95 %, m.
    pub within_95: f64,
    /// Joints of the nominal robot, controller's values, rad or m.
    pub nominal: Vec<f64>,
    /// Joints of the correction, controller's values, rad or m.
    pub corrected: Vec<f64>,
}

/// The file of a program's corrections, in m and rad, under no name yet.
///
/// # Errors
/// When the file cannot be written.
pub fn corrections_file(
    path: impl AsRef<Path>,
    chain: &Chain,
    rows: &[CorrectionRow],
) -> Result<WholeFile, IoError> {
    let names = ["point", "line", "kind", "frame", "tool", "outcome", "reason"];
    let mut header: Vec<String> = names.map(String::from).to_vec();
    header.extend(["x[m]", "y[m]", "z[m]", "dx[m]", "dy[m]", "dz[m]"].map(String::from));
    header.extend(["rotation[rad]", "within_95[m]"].map(String::from));
    let own = commanded(chain);
    let joints: Vec<String> = own
        .iter()
        .map(|&k| chain.movable()[k])
        .map(|joint| format!("{}[{}]", chain.joint(joint).name, si_unit(chain.joint(joint).kind).word))
        .collect();
    for prefix in ["nominal", "corrected"] {
        header.extend(joints.iter().map(|name| format!("{prefix}_{name}")));
    }
    let mut table = TableWriter::create(path.as_ref(), &header)?;
    for row in rows {
        table.text(&row.name);
        table.integer(row.line as i64);
        for text in [&row.kind, &row.frame, &row.tool, &row.outcome, &row.reason] {
            table.text(text);
        }
        row.desired.iter().chain(&row.displacement).for_each(|&value| table.number(value));
        table.number(row.rotation);
        table.number(row.within_95);
        for list in [&row.nominal, &row.corrected] {
            own.iter().for_each(|&k| table.number(list.get(k).copied().unwrap_or(f64::NAN)));
        }
        table.end_row()?;
    }
    Ok(table.into_file())
}

/// A frame or a tool that has the corrections of its points as another value.
#[derive(Debug, Clone)]
pub struct OffsetRow {
    /// Its name in the program.
    pub name: String,
    /// Whether it is a tool.
    pub tool: bool,
    /// Its new value in the form of the program's language.
    pub numbers: Vec<f64>,
    /// Root mean square of the corrections and of what remains, m.
    pub rms: [f64; 2],
    /// File, name and line of each point with its correction and what remains of it, m.
    pub points: Vec<(String, String, usize, [f64; 2])>,
}

/// The files of offsets, under no names yet: one row a frame, and one row a point.
///
/// # Errors
/// When a file cannot be written.
pub fn offsets_files(
    [frames, points]: [&Path; 2],
    numbers: &[&str],
    rows: &[OffsetRow],
) -> Result<[WholeFile; 2], IoError> {
    let header = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let own = [&["name", "kind"][..], numbers, &["points", "rms_before[m]", "rms_after[m]"]].concat();
    let mut of_frames = TableWriter::create(frames, &header(&own))?;
    let own = ["file", "point", "line", "name", "before[m]", "after[m]"];
    let mut of_points = TableWriter::create(points, &header(&own))?;
    for row in rows {
        of_frames.text(&row.name);
        of_frames.text(if row.tool { "tool" } else { "frame" });
        row.numbers.iter().for_each(|&number| of_frames.number(number));
        of_frames.integer(row.points.len() as i64);
        row.rms.iter().for_each(|&size| of_frames.number(size));
        of_frames.end_row()?;
        for (file, point, line, sizes) in &row.points {
            of_points.text(file);
            of_points.text(point);
            of_points.integer(*line as i64);
            of_points.text(&row.name);
            sizes.iter().for_each(|&size| of_points.number(size));
            of_points.end_row()?;
        }
    }
    Ok([of_frames.into_file(), of_points.into_file()])
}

/// Most bytes of a file that is read whole: programs are far smaller.
const MOST: u64 = 256 << 20;

/// A file's bytes.
///
/// # Errors
/// When it cannot be read, or is larger than 256 MB.
pub fn read_bytes(path: impl AsRef<Path>) -> Result<Vec<u8>, IoError> {
    let path = path.as_ref();
    let file = std::fs::File::open(path).map_err(|error| IoError::read(path, error))?;
    let mut bytes = Vec::new();
    file.take(MOST + 1).read_to_end(&mut bytes).map_err(|error| IoError::read(path, error))?;
    if bytes.len() as u64 > MOST {
        return Err(IoError::file(path, "it is larger than 256 MB"));
    }
    Ok(bytes)
}
