//! Corrections as other values of frames and tools.

use super::rewriting::Rewritten;
use crate::args::Compensate;
use crate::failure::Failure;
use crate::terminal;
use crate::verbs::print_json;
use crate::verbs::reporting::Folder;
use std::path::{Path, PathBuf};
use truepose_controllers::{Dialect, Offset, Orientation, Remaining};
use truepose_io::{OffsetRow, WholeFiles, check_writable, offsets_files};
use truepose_report::{OffsetView, count, millimetres, program_report};

fn dialect(made: &Rewritten) -> Option<Dialect> {
    Dialect::ALL.into_iter().find(|one| one.word() == made.view.language)
}

/// Makes the offsets of what was gathered; what none improves is noted.
pub(super) fn fill(made: &mut Rewritten, named: &dyn Fn(&Path) -> String) -> Result<(), Failure> {
    let (found, refused) = std::mem::take(&mut made.gathered).offsets();
    let Some(dialect) = dialect(made).filter(|_| !found.is_empty()) else {
        let none = "nothing is written: no offset of a frame or a tool improves the points".to_owned();
        return Err(Failure::Input([refused, vec![none]].concat().join("\n")));
    };
    made.view.notes.extend(refused.iter().cloned());
    made.notes.extend(refused);
    let point = |at: &Remaining| {
        let labels = &made.labels[at.point.0];
        let (name, line) = labels.points[at.point.1].clone();
        (named(&labels.file), name, line, [at.before, at.after])
    };
    let one = |offset: &Offset| OffsetRow {
        name: offset.name.clone(),
        tool: offset.tool,
        numbers: offset.numbers(dialect),
        rms: offset.rms(),
        points: offset.points.iter().map(point).collect(),
    };
    made.offsets = found.iter().map(one).collect();
    let names = numbers(dialect);
    let shown = |row: &OffsetRow| OffsetView {
        name: row.name.clone(),
        kind: if row.tool { "tool" } else { "frame" }.into(),
        value: names.iter().zip(&row.numbers).map(|(name, value)| ((*name).into(), *value)).collect(),
        points: row.points.len(),
        rms_before_mm: 1e3 * row.rms[0],
        rms_after_mm: 1e3 * row.rms[1],
    };
    made.view.offsets = made.offsets.iter().map(shown).collect();
    Ok(())
}

fn numbers(dialect: Dialect) -> &'static [&'static str] {
    match dialect.orientation() {
        Orientation::Abc => &["X", "Y", "Z", "A", "B", "C"],
        Orientation::Quaternion => &["x", "y", "z", "q1", "q2", "q3", "q4"],
        Orientation::Wpr => &["X", "Y", "Z", "W", "P", "R"],
        _ => &["x", "y", "z", "rx", "ry", "rz"],
    }
}

/// Where what remains at each point is written.
pub(super) fn points_of(out: &Path) -> PathBuf {
    let mut points = out.as_os_str().to_owned();
    points.push(".points.csv");
    points.into()
}

/// Writes their tables, and the page.
pub(super) fn write(
    args: &Compensate,
    made: &Rewritten,
    page: Option<&Folder>,
    inputs: &[&Path],
) -> Result<(), Failure> {
    let points = points_of(&args.out);
    check_writable(&points)?;
    let names = dialect(made).map_or(&[][..], numbers);
    let mut files = WholeFiles::default();
    for file in offsets_files([&args.out, &points], names, &made.offsets)? {
        files.push(file)?;
    }
    if let Some(page) = page {
        page.add(&mut files, &made.view, inputs, |run| Ok(program_report(&made.view, run)))?;
    }
    for line in &made.notes {
        terminal::log(&format!("note: {line}"));
    }
    files.finish()?;
    if let Some(page) = page {
        terminal::log(&format!("wrote {}", page.page().display()));
    }
    if args.json {
        return print_json(&made.view.offsets);
    }
    for row in &made.offsets {
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
