//! Request of the rewriting of a program.

use crate::place::GivenPlace;
use std::path::{Path, PathBuf};
use truepose_controllers::Dialect;
use truepose_kinematics::Pose;

/// The files of a program.
#[derive(Debug)]
pub(super) struct Files<'a> {
    /// The program, then those that may have points of it.
    pub own: Vec<&'a Path>,
    /// Those with frames, tools and loads alone: their points stay as they are.
    pub tables: Vec<&'a Path>,
}

/// A frame or tool of a program, and the file of the points at which it was taught.
#[derive(Debug, Clone, PartialEq)]
pub struct TaughtFrom {
    /// Of the frame or tool.
    pub name: String,
    /// The joints at which it was touched.
    pub file: PathBuf,
    /// The tool that touched, where it is named.
    pub tool: Option<String>,
}

/// What a program is rewritten with, m and rad where nothing else is stated.
#[derive(Debug, Clone)]
pub struct ProgramRequest {
    /// Further files with points of the program.
    pub with: Vec<PathBuf>,
    /// Its language; none: by the ending of its name.
    pub language: Option<Dialect>,
    /// Frames of its points.
    pub frames: Vec<GivenPlace>,
    /// Its tools.
    pub tools: Vec<GivenPlace>,
    /// A robot file with `[[frames]]` in place of those that the fit has recorded.
    pub frames_file: Option<PathBuf>,
    /// Frames and tools that were taught by touching with the uncorrected robot.
    pub taught: Vec<TaughtFrom>,
    /// Frames and tools that were measured, by their names.
    pub measured: Vec<String>,
    /// Those of a drawing.
    pub cad: Vec<String>,
    /// Largest correction of a point, m.
    pub limit: f64,
    /// Leaves points unchanged that cannot be compensated, instead of rejecting the program.
    pub mark: bool,
    /// Points that stay as they are, by their names.
    pub leave: Vec<String>,
    /// Leaves all points unchanged.
    pub dry_run: bool,
    /// Makes other values of frames and tools, in place of programs.
    pub offsets: bool,
    /// The controller's base in that of the description.
    pub controller_base: Option<Pose>,
    /// The controller's flange in the last joint's frame of the description.
    pub controller_flange: Option<Pose>,
    /// Joint values before the program, degrees or mm; empty: none.
    pub start: Vec<f64>,
    /// Mass carried, kg, with its centre of gravity in the frame of the measurements' tool, m; none: as the program states.
    pub payload: Option<(f64, [f64; 3])>,
    /// Channels that the model reads, in their units.
    pub channels: Vec<(String, f64)>,
    /// External axes that are joints of the fit: name in the program, joint.
    pub external: Vec<(String, String)>,
    /// Frames on a positioner: name in the program, tool of the fit.
    pub work: Vec<(String, String)>,
    /// External axes that are no joints move nothing.
    pub ignore_external: bool,
    /// Axes of FANUC's three turn numbers; empty: those of six axes.
    pub turn_axes: Vec<usize>,
    /// Pulses per degree (per mm) of each axis, for INFORM; empty: none.
    pub pulses: Vec<f64>,
}

impl Default for ProgramRequest {
    fn default() -> Self {
        ProgramRequest {
            with: Vec::new(),
            language: None,
            frames: Vec::new(),
            tools: Vec::new(),
            frames_file: None,
            taught: Vec::new(),
            measured: Vec::new(),
            cad: Vec::new(),
            limit: 0.01,
            mark: false,
            leave: Vec::new(),
            dry_run: false,
            offsets: false,
            controller_base: None,
            controller_flange: None,
            start: Vec::new(),
            payload: None,
            channels: Vec::new(),
            external: Vec::new(),
            work: Vec::new(),
            ignore_external: false,
            turn_axes: Vec::new(),
            pulses: Vec::new(),
        }
    }
}
