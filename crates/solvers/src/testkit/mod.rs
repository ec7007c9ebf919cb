//! The conformance kit: what every solver has to satisfy, checked without another solver.
//!
//! The tests follow from what the solver declares to support. Without a penalty ([`Unpenalised`](Need::Unpenalised)) it
//! has to meet the normal equations Aᵀ W (A x − y) = 0, or, with bounds, the Karush-Kuhn-Tucker conditions; with a penalty
//! at least xᵀ Aᵀ W (A x − y) ≤ 0, which any penalty that grows along a ray from zero implies. The weights are those of the
//! problem, times the row weights that a robust solver reports.

mod cases;
mod optimality;

use crate::{LeastSquares, Need, Solution, Solver, Status};
use cases::{Case, cases};
use optimality::{Demand, stationary};

/// Outcome of one case.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Name of the case.
    pub case: &'static str,
    /// None, or what failed.
    pub failure: Option<String>,
}

/// Runs the kit and returns the outcome of every case.
pub fn examine(solver: &dyn Solver) -> Vec<Outcome> {
    let mut outcomes: Vec<Outcome> =
        cases().iter().map(|case| Outcome { case: case.name, failure: run(solver, case).err() }).collect();
    outcomes.push(Outcome { case: "what is not finite is refused", failure: refuses(solver).err() });
    outcomes.push(Outcome { case: "the same twice, bit for bit", failure: repeats(solver).err() });
    outcomes
}

/// Runs the kit; for tests.
///
/// # Panics
///
/// With the list of failures, if there are any.
#[track_caller]
pub fn check_solver(solver: &dyn Solver) {
    let failures: Vec<String> =
        examine(solver).into_iter().filter_map(|o| o.failure.map(|c| format!("  {}: {c}", o.case))).collect();
    assert!(failures.is_empty(), "solver `{}` fails the kit:\n{}", solver.name(), failures.join("\n"));
}

fn run(solver: &dyn Solver, case: &Case) -> Result<(), String> {
    let problem = case.problem();
    let result = solver.solve(&problem);
    if problem.is_bounded() && !solver.supports(Need::Bounds) {
        return if result.is_err() {
            Ok(())
        } else {
            Err("bounds are not supported, and yet accepted".into())
        };
    }
    if problem.weights.is_some() && !solver.supports(Need::Weights) {
        return if result.is_err() {
            Ok(())
        } else {
            Err("weights are not supported, and yet accepted".into())
        };
    }
    let deficient = case.rank < problem.columns();
    let solution = match result {
        Ok(s) => s,
        Err(_) if deficient && !solver.supports(Need::RankDeficient) => return Ok(()),
        Err(e) => return Err(format!("refused: {e}")),
    };
    if deficient && !solver.supports(Need::RankDeficient) && !solution.status.is_success() {
        return Ok(());
    }
    sane(&problem, &solution)?;
    if solver.supports(Need::RankDeficient) {
        let by_rank = !deficient || solution.status == Status::RankDeficient { rank: case.rank };
        // A penalty may keep fewer directions than the data determine, and may determine what they do not.
        if solver.supports(Need::Unpenalised) && (solution.rank != case.rank || !by_rank) {
            return Err(format!(
                "rank {} with status {:?}, should be {}",
                solution.rank, solution.status, case.rank
            ));
        }
    }
    for (column, a) in problem.a.column_iter().enumerate() {
        if a.iter().all(|v| v.abs() < f64::MIN_POSITIVE) && solution.x[column].abs() >= f64::MIN_POSITIVE {
            return Err(format!("zero column {column} got {}", solution.x[column]));
        }
    }
    let demand = if solver.supports(Need::Unpenalised) { Demand::Stationary } else { Demand::Shrunken };
    stationary(&problem, &solution, demand)?;
    match &case.truth {
        Some(truth) if solver.supports(Need::Outliers) => {
            let error = (&solution.x - truth).amax();
            if error > case.tolerance { Err(format!("misled by wrong rows: off by {error}")) } else { Ok(()) }
        }
        _ => Ok(()),
    }
}

/// Shape, numbers, and that the reported residual is the residual.
fn sane(problem: &LeastSquares<'_>, solution: &Solution) -> Result<(), String> {
    if !solution.status.is_success() {
        return Err(format!("ended with {:?}", solution.status));
    }
    if solution.x.len() != problem.columns() {
        return Err(format!("{} unknowns instead of {}", solution.x.len(), problem.columns()));
    }
    if solution.x.iter().any(|x| !x.is_finite()) {
        return Err("an unknown is not finite".into());
    }
    if solution.rank > problem.columns().min(problem.rows()) {
        return Err(format!("rank {} of a {} × {} matrix", solution.rank, problem.rows(), problem.columns()));
    }
    let scale = crate::dense::norm(problem.y.as_slice()).max(f64::MIN_POSITIVE);
    let residual = crate::dense::norm((problem.residual(&solution.x) / scale).as_slice());
    let reported = solution.info.residual_norm / scale;
    if (residual - reported).abs() > 1e-9 * (1.0 + residual) {
        return Err(format!("reports residual {reported}, has {residual} (relative to y)"));
    }
    Ok(())
}

fn refuses(solver: &dyn Solver) -> Result<(), String> {
    let good = cases::full_rank();
    for bad in [f64::NAN, f64::INFINITY] {
        let (mut a, mut y) = (good.a.clone(), good.y.clone());
        a[(3, 1)] = bad;
        if solver.solve(&LeastSquares::new(&a, &good.y)).is_ok() {
            return Err(format!("accepted {bad} in the design matrix"));
        }
        y[2] = bad;
        if solver.solve(&LeastSquares::new(&good.a, &y)).is_ok() {
            return Err(format!("accepted {bad} in y"));
        }
    }
    for weight in [f64::NAN, -1.0] {
        let mut weights = vec![1.0; good.y.len()];
        weights[5] = weight;
        if solver.solve(&good.problem().with_weights(&weights)).is_ok() {
            return Err(format!("accepted the weight {weight}"));
        }
    }
    let short = good.y.rows(0, 4).into_owned();
    if solver.solve(&LeastSquares::new(&good.a, &short)).is_ok() {
        return Err("accepted a y that is too short".into());
    }
    Ok(())
}

fn repeats(solver: &dyn Solver) -> Result<(), String> {
    let case = cases::full_rank();
    let once = solver.solve(&case.problem()).map_err(|e| e.to_string())?;
    let twice = solver.solve(&case.problem()).map_err(|e| e.to_string())?;
    if once.x == twice.x { Ok(()) } else { Err("two runs differ".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PivotedQr, SolveError};

    /// Wrong in one way each.
    struct Wrong(fn(&mut Solution));

    impl Solver for Wrong {
        fn name(&self) -> &str {
            "wrong"
        }
        fn supports(&self, need: Need) -> bool {
            PivotedQr::default().supports(need)
        }
        fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
            let mut s = PivotedQr::default().solve(problem)?;
            (self.0)(&mut s);
            Ok(s)
        }
    }

    #[track_caller]
    fn detected(by: &str, spoil: fn(&mut Solution)) {
        let outcomes = examine(&Wrong(spoil));
        assert!(outcomes.iter().any(|o| o.case == by && o.failure.is_some()), "{by}: {outcomes:#?}");
    }

    #[test]
    fn mistakes_are_detected() {
        detected("full rank", |s| s.x *= 1.0 + 1e-7);
        detected("full rank", |s| s.info.residual_norm *= 1.001);
        detected("deficient rank", |s| s.status = Status::Converged);
        detected("deficient rank", |s| s.rank += 1);
        detected("zero column", |s| s.x.iter_mut().for_each(|x| *x += if *x == 0.0 { 1.0 } else { 0.0 }));
        detected("badly scaled columns", |s| {
            s.x.iter_mut().for_each(|x| *x *= 1.0 + 1e-6);
        });
        detected("weighted rows", |s| s.x.fill(f64::NAN));
    }
}
