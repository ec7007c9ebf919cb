//! One program, with the further files that have points of it.

use super::asked::{Asked, Files};
use super::offsets;
use super::rewriting::{Rewritten, rewritten};
use super::rows::short;
use crate::failure::Failure;
use std::path::Path;
use truepose_errormodel::FittedModel;

/// Rewrites the program of a file, and the further files that have points of it. `fitted` is that of the robot alone, in one session.
pub(crate) fn rewrite(fitted: &FittedModel, file: &Path, asked: &Asked<'_>) -> Result<Rewritten, Failure> {
    let own = std::iter::once(file).chain(asked.own.with.iter().map(AsRef::as_ref)).collect();
    let made = rewritten(fitted, &Files { own, tables: Vec::new() }, asked)?;
    let mut made = made.ok_or_else(|| {
        Failure::Input(format!(
            "{}: nothing to compensate: no point has a value in the files given; add the file that has them (--with FILE)",
            file.display()
        ))
    })?;
    let unused = made.unused.iter().map(|(_, words)| words.clone()).collect::<Vec<_>>();
    if let Some(words) = unused.iter().find(|words| words.starts_with("--leave")) {
        return Err(Failure::Input(words.clone()));
    }
    made.view.notes.splice(..0, unused.iter().cloned());
    made.notes.splice(..0, unused);
    if asked.own.offsets {
        let name = |file: &Path| short(file);
        offsets::fill(&mut made, &name)?;
    }
    Ok(made)
}
