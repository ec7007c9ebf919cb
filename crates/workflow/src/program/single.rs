//! One program, with the further files that have points of it.

use super::folder::rewrite_folder;
use super::offsets;
use super::request::{Files, ProgramRequest};
use super::rewriting::{Rewritten, rewritten};
use super::rows::short;
use crate::error::WorkflowError;
use std::path::Path;
use truepose_errormodel::FittedModel;

/// Rewrites the program of a file with the further files that have points of it, or all programs of a folder, of which each that is refused has line 0
/// in `refused`. `fitted` is that of the robot alone ([`FittedModel::of_robot`]), in one session.
///
/// # Errors
/// When the program cannot be read, a frame is not known, or points cannot be compensated and neither `mark` nor `dry_run` is set.
pub fn rewrite_program(
    fitted: &FittedModel,
    file: &Path,
    request: &ProgramRequest,
) -> Result<Rewritten, WorkflowError> {
    if file.is_dir() {
        return Ok(rewrite_folder(fitted, file, request)?.joined()?.0);
    }
    let own = std::iter::once(file).chain(request.with.iter().map(AsRef::as_ref)).collect();
    let made = rewritten(fitted, &Files { own, tables: Vec::new() }, request)?;
    let mut made = made.ok_or_else(|| {
        WorkflowError::Input(format!(
            "{}: nothing to compensate: no point has a value in the files given; add the file that has them (--with FILE)",
            file.display()
        ))
    })?;
    let unused = made.unused.iter().map(|(_, words)| words.clone()).collect::<Vec<_>>();
    if let Some(words) = unused.iter().find(|words| words.starts_with("--leave")) {
        return Err(WorkflowError::Input(words.clone()));
    }
    made.view.notes.splice(..0, unused.iter().cloned());
    made.notes.splice(..0, unused);
    if request.offsets {
        let name = |file: &Path| short(file);
        offsets::fill(&mut made, &name)?;
    }
    Ok(made)
}
