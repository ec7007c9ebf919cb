//! A fit of several installations in one of them.

use crate::error::WorkflowError;
use std::path::Path;
use truepose_errormodel::{Dataset, FittedModel};
use truepose_io::CsvInfo;

/// A part of a table that one installation measured, and the fit there.
#[derive(Debug)]
pub struct Part {
    /// The fit there.
    pub fitted: FittedModel,
    /// Rows of the table, ascending.
    pub rows: Vec<usize>,
}

/// The rows of a table by the sessions of a fit. `session` is what the user chose for all rows.
///
/// # Errors
/// When the session of a row is not one of the fit, or none is named.
pub(crate) fn parts(
    fitted: &FittedModel,
    data: &mut Dataset,
    info: &CsvInfo,
    session: Option<&str>,
    file: &Path,
) -> Result<Vec<Part>, WorkflowError> {
    if fitted.sessions.is_empty() {
        data.set_sessions(None);
        return Ok(vec![Part { fitted: fitted.clone(), rows: (0..data.len()).collect() }]);
    }
    let told = |words: String| WorkflowError::about(file, WorkflowError::Input(words));
    let numbers: Vec<usize> = match (session, info.sessions.len()) {
        (Some(name), _) => vec![number(fitted, name).map_err(WorkflowError::Input)?],
        (None, 0) => return Err(told(unsaid(fitted))),
        (None, _) => {
            let found = info.sessions.iter().enumerate().map(|(k, name)| {
                let line =
                    (0..data.len()).find(|&row| data.session(row) == k).and_then(|row| data.line.get(row));
                let line = line.map_or(String::new(), |line| format!("line {line}: "));
                number(fitted, name).map_err(|words| told(format!("{line}{words}")))
            });
            found.collect::<Result<_, _>>()?
        }
    };
    let mut parts = Vec::new();
    for number in 0..fitted.sessions.len() {
        let of = |row: usize| numbers.get(data.session(row)).or(numbers.first()) == Some(&number);
        let rows: Vec<usize> = (0..data.len()).filter(|&row| of(row)).collect();
        if rows.is_empty() {
            continue;
        }
        for &row in &rows {
            data.target[row] = data.target[row].map(|target| fitted.target_in_session(target, number));
        }
        parts.push(Part { fitted: fitted.in_session(number)?, rows });
    }
    data.set_sessions(None);
    Ok(parts)
}

/// A fit in the session of this name; in the only one, or the first, where none is named and `any` will do.
///
/// # Errors
/// When there is no such session, or there are several and none is named.
pub fn in_session(
    fitted: FittedModel,
    session: Option<&str>,
    any: bool,
) -> Result<FittedModel, WorkflowError> {
    let number = match session {
        Some(name) => number(&fitted, name).map_err(WorkflowError::Input)?,
        None if any || fitted.sessions.len() < 2 => 0,
        None => return Err(WorkflowError::Input(unsaid(&fitted))),
    };
    Ok(fitted.in_session(number)?)
}

fn number(fitted: &FittedModel, name: &str) -> Result<usize, String> {
    let known = || fitted.sessions.iter().map(|session| session.name.as_str());
    known().position(|known| known == name).ok_or_else(|| {
        let known: Vec<&str> = known().collect();
        match known.is_empty() {
            true => format!("the fit has one installation and no session `{name}`"),
            false => format!("the fit has no session `{name}` (its sessions: {})", known.join(", ")),
        }
    })
}

fn unsaid(fitted: &FittedModel) -> String {
    let known: Vec<&str> = fitted.sessions.iter().map(|session| session.name.as_str()).collect();
    format!(
        "the fit has several sessions ({}): say which one it is, in a column `session` or with --session NAME",
        known.join(", ")
    )
}

/// Refuses a table of several sessions where one installation is needed.
///
/// # Errors
/// Then.
pub fn one_installation(info: &CsvInfo, file: &Path) -> Result<(), WorkflowError> {
    match info.sessions.as_slice() {
        [] | [_] => Ok(()),
        several => Err(WorkflowError::Input(format!(
            "{}: it holds {} sessions ({}); this verb takes the rows of one installation",
            file.display(),
            several.len(),
            several.join(", ")
        ))),
    }
}
