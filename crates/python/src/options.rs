//! Options as Python gives them.

use crate::arrays::Given1;
use crate::error::input;
use pyo3::prelude::*;
use truepose_errormodel::Dataset;
use truepose_identify::{PriorStrength, Split};
use truepose_solvers::{Solver, SolverSpec};
use truepose_workflow::{FoldsRequest, NamedSolver, SplitKind};

/// A solver by its text, and the text as the program writes it.
pub fn solver(text: &str) -> PyResult<(Box<dyn Solver>, String)> {
    let spec: SolverSpec = text.parse().map_err(|error| input(format!("solver: {error}")))?;
    Ok((spec.build(), spec.to_string()))
}

/// The same for the workflow.
pub fn named_solver(text: &str) -> PyResult<NamedSolver> {
    let (solver, name) = solver(text)?;
    Ok(NamedSolver { name, solver })
}

/// `evidence`, `none`, or a factor above zero.
pub fn prior(of: &Bound<'_, PyAny>) -> PyResult<PriorStrength> {
    if let Ok(factor) = of.extract::<f64>() {
        return match factor.is_finite() && factor > 0.0 {
            true => Ok(PriorStrength::Fixed(factor)),
            false => Err(input("prior: a factor has to be above 0")),
        };
    }
    match of.extract::<String>().as_deref() {
        Ok("evidence") => Ok(PriorStrength::VarianceGroups),
        Ok("none") => Ok(PriorStrength::None),
        _ => Err(input("prior: expected \"evidence\", \"none\" or a number above 0")),
    }
}

/// How configurations are divided into folds; none for none.
pub fn split(data: &Dataset, folds: usize, kind: &str, seed: u64) -> PyResult<Option<Split>> {
    let folds = FoldsRequest::Count(folds, SplitKind::named(kind).map_err(input)?);
    Ok(truepose_workflow::split(data, &folds, seed, None).map_err(input)?.0)
}

/// Folds that a label of each row numbers.
pub fn groups(data: &Dataset, labels: &Given1<'_, i64>) -> PyResult<Split> {
    let labels = labels.as_array();
    if labels.len() != data.len() {
        return Err(input(format!("groups has {} labels, and the data {} rows", labels.len(), data.len())));
    }
    let visits = data.visit.iter().max().map_or(0, |last| last + 1);
    let mut of_visit: Vec<Option<i64>> = vec![None; visits];
    for (row, (&visit, &label)) in data.visit.iter().zip(labels).enumerate() {
        if of_visit[visit].replace(label).is_some_and(|other| other != label) {
            return Err(crate::error::at_row(
                row as u64 + 1,
                "groups",
                "changes within a visit (pose measurement); a fold takes whole visits",
            ));
        }
    }
    let mut known: Vec<i64> = Vec::new();
    let folds = of_visit.into_iter().flatten().map(|label| {
        known.iter().position(|&other| other == label).unwrap_or_else(|| {
            known.push(label);
            known.len() - 1
        })
    });
    let folds: Vec<usize> = folds.collect();
    if known.len() < 2 {
        return Err(input("groups has a single value; at least two folds are needed"));
    }
    Ok(Split::Given(folds))
}
