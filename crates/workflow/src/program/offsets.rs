//! Corrections as other values of frames and tools.

use super::rewriting::Rewritten;
use crate::error::WorkflowError;
use std::path::Path;
use truepose_controllers::{Dialect, Offset, Orientation, Remaining};
use truepose_io::OffsetRow;
use truepose_report::OffsetView;

fn dialect(made: &Rewritten) -> Option<Dialect> {
    Dialect::ALL.into_iter().find(|one| one.word() == made.view.language)
}

/// Makes the offsets of what was gathered; what none improves is noted.
pub(super) fn fill(made: &mut Rewritten, named: &dyn Fn(&Path) -> String) -> Result<(), WorkflowError> {
    let (found, refused) = std::mem::take(&mut made.gathered).offsets();
    let Some(dialect) = dialect(made).filter(|_| !found.is_empty()) else {
        let none = "nothing is written: no offset of a frame or a tool improves the points".to_owned();
        return Err(WorkflowError::Input([refused, vec![none]].concat().join("\n")));
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

/// The names of the numbers of a frame in a language.
fn numbers(dialect: Dialect) -> &'static [&'static str] {
    match dialect.orientation() {
        Orientation::Abc => &["X", "Y", "Z", "A", "B", "C"],
        Orientation::Quaternion => &["x", "y", "z", "q1", "q2", "q3", "q4"],
        Orientation::Wpr => &["X", "Y", "Z", "W", "P", "R"],
        _ => &["x", "y", "z", "rx", "ry", "rz"],
    }
}

/// The names of the numbers of a frame in the language of a program.
pub fn offset_numbers(made: &Rewritten) -> &'static [&'static str] {
    dialect(made).map_or(&[][..], numbers)
}
