//! Corrections as other values of frames and tools.

use super::rows::{Part, short};
use crate::args::Compensate;
use crate::failure::Failure;
use crate::terminal;
use crate::verbs::print_json;
use std::path::PathBuf;
use truepose_controllers::{CorrectOptions, Correction, Offset, Orientation, Program, Remaining, offsets};
use truepose_io::{OffsetRow, WholeFiles, check_writable, offsets_files};
use truepose_report::{count, millimetres};

/// The offsets of a program's points; what none improves is noted.
pub(super) fn rows(
    parts: &[Part<'_>],
    programs: &[Program],
    corrections: &[Vec<Correction>],
    options: &CorrectOptions,
    notes: &mut Vec<String>,
) -> Result<Vec<OffsetRow>, Failure> {
    let (found, refused) = offsets(&programs[..parts.len()], corrections, options)
        .map_err(|error| Failure::Input(error.to_string()))?;
    if found.is_empty() {
        let none = "nothing is written: no offset of a frame or a tool improves the points".to_owned();
        return Err(Failure::Input([refused, vec![none]].concat().join("\n")));
    }
    notes.extend(refused);
    let point = |at: &Remaining| {
        let part = &parts[at.point.0];
        let point = &part.program.points()[at.point.1];
        (short(part.file), point.name.clone(), point.line, [at.before, at.after])
    };
    let one = |offset: &Offset| OffsetRow {
        name: offset.name.clone(),
        tool: offset.tool,
        numbers: offset.numbers(&programs[0]),
        rms: offset.rms(),
        points: offset.points.iter().map(point).collect(),
    };
    Ok(found.iter().map(one).collect())
}

/// Writes their tables.
pub(super) fn write(
    args: &Compensate,
    rows: &[OffsetRow],
    notes: &[String],
    language: &str,
) -> Result<(), Failure> {
    let mut points = args.out.as_os_str().to_owned();
    points.push(".points.csv");
    let points = PathBuf::from(points);
    check_writable(&points)?;
    let language = truepose_controllers::Dialect::ALL.into_iter().find(|one| one.word() == language);
    let names = match language.map(|language| language.orientation()) {
        Some(Orientation::Abc) => &["X", "Y", "Z", "A", "B", "C"][..],
        Some(Orientation::Quaternion) => &["x", "y", "z", "q1", "q2", "q3", "q4"],
        Some(Orientation::Wpr) => &["X", "Y", "Z", "W", "P", "R"],
        _ => &["x", "y", "z", "rx", "ry", "rz"],
    };
    let mut files = WholeFiles::default();
    for file in offsets_files([&args.out, &points], names, rows)? {
        files.push(file)?;
    }
    for line in notes {
        terminal::log(&format!("note: {line}"));
    }
    files.finish()?;
    if args.json {
        let one = |row: &OffsetRow| {
            serde_json::json!({
                "name": row.name, "kind": if row.tool { "tool" } else { "frame" }, "value": row.numbers, "points": row.points.len(),
                "rms_before_mm": 1e3 * row.rms[0], "rms_after_mm": 1e3 * row.rms[1],
            })
        };
        return print_json(&rows.iter().map(one).collect::<Vec<_>>());
    }
    for row in rows {
        let [before, after] = row.rms.map(millimetres);
        terminal::print(&format!(
            "{} {}: {}: {before} RMS before, {after} with the value in {}\n",
            if row.tool { "tool" } else { "frame" },
            row.name,
            count(row.points.len(), "point"),
            args.out.display()
        ));
    }
    Ok(())
}
