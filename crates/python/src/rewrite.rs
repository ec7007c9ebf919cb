//! A robot program with compensated points.

use crate::arrays::{rows, vector};
use crate::error::input;
use crate::fit::Fit;
use crate::run::supervised;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;
use truepose_controllers::Dialect;
use truepose_io::CorrectionRow;
use truepose_kinematics::Pose;
use truepose_workflow::program::{ProgramRequest, Rewritten, TaughtFrom, rewrite_program};
use truepose_workflow::{GivenPlace, Place};

/// A frame or a tool: words as on the command line, or its name and x y z roll pitch yaw, m and rad.
#[derive(FromPyObject)]
pub enum Placed {
    #[pyo3(transparent)]
    Words(String),
    #[pyo3(transparent)]
    At((Option<String>, [f64; 6])),
}

fn pose(of: &[f64; 6]) -> Pose {
    let [x, y, z, roll, pitch, yaw] = *of;
    Pose::from_xyz_rpy([x, y, z], [roll, pitch, yaw])
}

fn given(placed: Vec<Placed>) -> PyResult<Vec<GivenPlace>> {
    let one = |placed| match placed {
        Placed::Words(text) => GivenPlace::parse(&text).map_err(input),
        Placed::At((name, at)) => Ok(GivenPlace { name, place: Place::At(pose(&at)) }),
    };
    placed.into_iter().map(one).collect()
}

/// The language of a word.
fn dialect(word: &str) -> PyResult<Dialect> {
    Dialect::ALL.into_iter().find(|dialect| dialect.word() == word).ok_or_else(|| {
        let known: Vec<&str> = Dialect::ALL.iter().map(|dialect| dialect.word()).collect();
        input(format!("unknown language `{word}` (known: {})", known.join(", ")))
    })
}

/// The texts of the program and of the further files that have points of it, their corrections as columns, the summary as JSON, notes, and
/// programs of a folder that are not compensated.
#[pyfunction]
#[pyo3(signature = (fit, file, with_, language, frames, tools, taught, measured, cad, external, work, limit, mark, leave, dry_run, offsets, controller_base, controller_flange, start, payload, channels, ignore_external, turn_axes, pulses))]
#[allow(clippy::too_many_arguments, clippy::type_complexity)]
pub fn rewrite<'py>(
    py: Python<'py>,
    fit: &Fit,
    file: PathBuf,
    with_: Vec<PathBuf>,
    language: Option<String>,
    frames: Vec<Placed>,
    tools: Vec<Placed>,
    taught: Vec<(String, PathBuf, Option<String>)>,
    measured: Vec<String>,
    cad: Vec<String>,
    external: Vec<(String, String)>,
    work: Vec<(String, String)>,
    limit: f64,
    mark: bool,
    leave: Vec<String>,
    dry_run: bool,
    offsets: bool,
    controller_base: Option<[f64; 6]>,
    controller_flange: Option<[f64; 6]>,
    start: Vec<f64>,
    payload: Option<(f64, [f64; 3])>,
    channels: Vec<(String, f64)>,
    ignore_external: bool,
    turn_axes: Vec<usize>,
    pulses: Vec<f64>,
) -> PyResult<(
    Vec<(PathBuf, Bound<'py, PyBytes>)>,
    Bound<'py, PyDict>,
    String,
    Vec<String>,
    Vec<(PathBuf, String)>,
)> {
    if !(limit.is_finite() && limit > 0.0) {
        return Err(input(format!("limit: {limit} is no length above 0, in m")));
    }
    let fitted = (*fit.usable(py)?.one()?).clone().of_robot();
    let of_folder = file.is_dir();
    let request = ProgramRequest {
        with: with_,
        language: language.as_deref().map(dialect).transpose()?,
        frames: given(frames)?,
        tools: given(tools)?,
        frames_file: None,
        taught: taught.into_iter().map(|(name, file, tool)| TaughtFrom { name, file, tool }).collect(),
        measured,
        cad,
        external,
        work,
        limit,
        mark,
        leave,
        dry_run,
        offsets,
        controller_base: controller_base.as_ref().map(pose),
        controller_flange: controller_flange.as_ref().map(pose),
        start,
        payload,
        channels,
        ignore_external,
        turn_axes,
        pulses,
    };
    let made: Rewritten = supervised(py, None, vec![fit.raised.clone()], move |_| {
        rewrite_program(&fitted, &file, &request).map_err(input)
    })?;
    let all = PyDict::new(py);
    let list: Vec<&CorrectionRow> = made.files.iter().flat_map(|part| &part.rows).collect();
    let files = made.files.iter().flat_map(|part| part.rows.iter().map(|_| part.file.clone()));
    all.set_item("file", files.collect::<Vec<_>>())?;
    let texts =
        |of: fn(&CorrectionRow) -> &String| list.iter().map(|row| of(row).clone()).collect::<Vec<_>>();
    all.set_item("point", texts(|row| &row.name))?;
    all.set_item("line", list.iter().map(|row| row.line).collect::<Vec<_>>())?;
    all.set_item("kind", texts(|row| &row.kind))?;
    all.set_item("frame", texts(|row| &row.frame))?;
    all.set_item("tool", texts(|row| &row.tool))?;
    all.set_item("outcome", texts(|row| &row.outcome))?;
    all.set_item("reason", texts(|row| &row.reason))?;
    all.set_item("position", rows(py, list.iter().map(|row| row.desired)))?;
    all.set_item("displacement", rows(py, list.iter().map(|row| row.displacement)))?;
    all.set_item("rotation", vector(py, list.iter().map(|row| row.rotation).collect()))?;
    all.set_item("within_95", vector(py, list.iter().map(|row| row.within_95).collect()))?;
    let summary = serde_json::to_string(&made.view).map_err(input)?;
    let texts = made.files.iter().map(|part| (part.file.clone(), PyBytes::new(py, &part.text)));
    let refused = made.refused.iter().filter(|(_, line, _)| of_folder && *line == 0);
    let refused = refused.map(|(file, _, words)| (file.clone(), words.clone())).collect();
    Ok((texts.collect(), all, summary, [made.warnings, made.notes].concat(), refused))
}
