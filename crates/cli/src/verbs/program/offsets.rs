//! Corrections as other values of frames and tools.

use crate::args::Compensate;
use crate::failure::Failure;
use crate::terminal;
use crate::verbs::print_json;
use crate::verbs::reporting::Folder;
use std::path::{Path, PathBuf};
use truepose_io::{WholeFiles, check_writable, offsets_files};
use truepose_report::{count, millimetres, program_report};
use truepose_workflow::program::{Rewritten, offset_numbers};

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
    let names = offset_numbers(made);
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
