//! What the command line asks of a program.

use crate::args::{GivenPlace, RobotProgram};
use std::path::Path;

/// The files of a program.
#[derive(Debug)]
pub(super) struct Files<'a> {
    /// The program, then those that may have points of it.
    pub own: Vec<&'a Path>,
    /// Those with frames, tools and loads alone: their points stay as they are.
    pub tables: Vec<&'a Path>,
}

/// What a program is rewritten with.
#[derive(Debug)]
pub(crate) struct Asked<'a> {
    /// The options that only programs have.
    pub own: &'a RobotProgram,
    /// Frames of the program.
    pub frame: &'a [GivenPlace],
    /// Tools of the program.
    pub tcp: &'a [GivenPlace],
    /// File with `[[frames]]` in place of those that the fit has recorded.
    pub frames: Option<&'a Path>,
}
