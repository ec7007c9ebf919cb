//! Robot programs with compensated points.

use crate::args::{GivenPlace, Place, RobotProgram, TaughtFrom, parse_given};
use crate::failure::Failure;
use crate::verbs::program::{Asked, rewrite as rewritten, whole};
use std::path::{Path, PathBuf};
use truepose_controllers::Dialect;
use truepose_errormodel::FittedModel;
use truepose_io::CorrectionRow;
use truepose_kinematics::Pose;
use truepose_report::ProgramView;

/// A frame or a tool of a program.
#[derive(Debug, Clone, PartialEq)]
pub enum Given {
    /// As on the command line: `base`, `UF1=900mm,0mm,50mm,0,0,90`.
    Words(String),
    /// Its name in the program, if any, and where it is, m.
    At(Option<String>, Pose),
}

/// Options of a program's rewriting; in m and rad.
#[derive(Debug, Clone)]
pub struct Rewriting {
    /// Further files of the program.
    pub with: Vec<PathBuf>,
    /// Its language: krl, rapid, fanuc, urscript, inform or val3; none: by the ending of its name.
    pub language: Option<String>,
    /// Frames of its points.
    pub frames: Vec<Given>,
    /// Its tools.
    pub tools: Vec<Given>,
    /// Frames and tools that were taught by touching: name, file of the joints, tool that touched.
    pub taught: Vec<(String, PathBuf, Option<String>)>,
    /// Frames and tools that were measured.
    pub measured: Vec<String>,
    /// Those of a drawing.
    pub cad: Vec<String>,
    /// External axes that are joints of the fit: name in the program, joint.
    pub external: Vec<(String, String)>,
    /// Frames on a positioner: name in the program, tool of the fit.
    pub work: Vec<(String, String)>,
    /// Largest correction of a point, m.
    pub limit: f64,
    /// Leaves points unchanged that cannot be compensated.
    pub mark: bool,
    /// Points that stay as they are, by their names.
    pub leave: Vec<String>,
    /// Leaves all points unchanged.
    pub dry_run: bool,
    /// Makes other values of frames and tools, in the view, in place of programs.
    pub offsets: bool,
    /// The controller's base in that of the description.
    pub controller_base: Option<Pose>,
    /// The controller's flange in the last joint's frame of the description.
    pub controller_flange: Option<Pose>,
    /// Joint values before the program, degrees or mm; empty: none.
    pub start: Vec<f64>,
    /// Mass carried, kg, with its centre of gravity in the frame of the measurements' tool, m.
    pub payload: Option<(f64, [f64; 3])>,
    /// Channels that the model reads.
    pub channels: Vec<(String, f64)>,
    /// External axes move nothing.
    pub ignore_external: bool,
    /// Axes of FANUC's three turn numbers.
    pub turn_axes: Vec<usize>,
    /// Pulses per degree (per mm) of each axis, for INFORM.
    pub pulses: Vec<f64>,
}

/// One file of a program with compensated points.
#[derive(Debug)]
pub struct RewrittenFile {
    /// Where it was read.
    pub file: PathBuf,
    /// Its new text, in the encoding of the original.
    pub text: Vec<u8>,
    /// One row for each of its points.
    pub rows: Vec<CorrectionRow>,
}

/// A program with compensated points.
#[derive(Debug)]
pub struct Rewritten {
    /// The program, then the further files that have points of it.
    pub files: Vec<RewrittenFile>,
    /// All points for pages and JSON.
    pub view: ProgramView,
    /// What is to be known of it.
    pub notes: Vec<String>,
    /// Programs of a folder that are not compensated, and why.
    pub refused: Vec<(PathBuf, String)>,
}

/// Rewrites the program of a file, or all programs of a folder. `fitted` is in one session.
///
/// # Errors
/// When the program cannot be read, a frame is not known, or points cannot be compensated and neither `mark` nor `dry_run` is set.
pub fn rewrite(fitted: &FittedModel, file: &Path, options: &Rewriting) -> Result<Rewritten, String> {
    let language = options.language.as_deref().map(|word| {
        Dialect::ALL.into_iter().find(|dialect| dialect.word() == word).ok_or_else(|| {
            let known: Vec<&str> = Dialect::ALL.iter().map(|dialect| dialect.word()).collect();
            format!("unknown language `{word}` (known: {})", known.join(", "))
        })
    });
    let own = RobotProgram {
        program: Some(file.into()),
        with: options.with.iter().map(Into::into).collect(),
        language: language.transpose()?,
        taught: options.taught.iter().map(|(name, file, tool)| from(name, file, tool.as_deref())).collect(),
        measured: options.measured.clone(),
        cad: options.cad.clone(),
        limit: options.limit,
        mark: options.mark,
        leave: options.leave.clone(),
        dry_run: options.dry_run,
        offsets: options.offsets,
        controller_base: options.controller_base,
        controller_flange: options.controller_flange,
        start: options.start.clone(),
        payload: options.payload.map(|(mass, _)| mass),
        com: options.payload.map(|(_, com)| com),
        channel: options.channels.clone(),
        external: options.external.clone(),
        work: options.work.clone(),
        ignore_external: options.ignore_external,
        turn_axes: options.turn_axes.clone(),
        pulses: options.pulses.clone(),
    };
    let (frame, tcp) = (places(&options.frames)?, places(&options.tools)?);
    let asked = Asked { own: &own, frame: &frame, tcp: &tcp, frames: None };
    let fitted = fitted.clone().of_robot();
    let made = if file.is_dir() { whole(&fitted, file, &asked) } else { rewritten(&fitted, file, &asked) };
    let made = made.map_err(Failure::message)?;
    let refused = made.refused.into_iter().filter(|(_, line, _)| file.is_dir() && *line == 0);
    let refused = refused.map(|(file, _, words)| (file, words)).collect();
    let files = made.files.into_iter();
    let files = files.map(|part| RewrittenFile { file: part.file, text: part.text, rows: part.rows });
    Ok(Rewritten { files: files.collect(), view: made.view, notes: made.notes, refused })
}

fn from(name: &str, file: &Path, tool: Option<&str>) -> TaughtFrom {
    TaughtFrom { name: name.into(), file: file.into(), tool: tool.map(Into::into) }
}

fn places(given: &[Given]) -> Result<Vec<GivenPlace>, String> {
    let one = |given: &Given| match given {
        Given::Words(text) => parse_given(text),
        Given::At(name, pose) => Ok(GivenPlace { name: name.clone(), place: Place::At(*pose) }),
    };
    given.iter().map(one).collect()
}
