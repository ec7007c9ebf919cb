//! One problem of the generated family under every strategy: one solve timed and weighed alone, then the folds in parallel.

use super::family::{Problem, Recipe, UNKNOWNS};
use super::optimality::{Strategy, violation};
use super::record::Record;
use crate::prelude::*;
use rand::seq::SliceRandom;
use truepose_solvers::{Need, Solution, SolveError};

/// Folds of the cross-validation.
pub const FOLDS: usize = 5;

/// Every strategy on the problem of a recipe.
pub fn trial(sweep: &str, recipe: &Recipe, strategies: &[Strategy]) -> Outcome<Vec<Record>> {
    let problem = Problem::new(recipe);
    let folds = folds(&problem, recipe.seed);
    let oracle = Oracle::new(&problem, &folds)?;
    let all = problem.rows(&(0..recipe.rows).collect::<Vec<_>>());
    let mut records = Vec::new();
    let mut first: Option<Squares> = None;
    for strategy in strategies {
        let bounded = strategy.solver.supports(Need::Bounds);
        let given = all.problem(&problem, bounded);
        let (solved, seconds, bytes) = weighed(&*strategy.solver, &given);
        let mut record = Record {
            condition: recipe.condition,
            noise: recipe.noise,
            outliers: recipe.outliers,
            rows: recipe.rows as f64,
            unknowns: UNKNOWNS as f64,
            seed: recipe.seed as f64,
            oracle: oracle.held_out,
            oracle_parameters: oracle.parameters,
            seconds,
            bytes: bytes as f64,
            ..Record::blank(sweep, strategy.name)
        };
        match &solved {
            Ok(solution) => {
                record.status = status(solution);
                record.iterations = solution.info.iterations as f64;
                record.rank = solution.rank as f64;
                record.parameters = problem.parameter_error(&solution.x);
                let off = violation(strategy.conditions, &all, &problem, solution);
                record.optimality = off.unwrap_or(f64::NAN);
                let squares = held_out(&problem, &folds, &*strategy.solver)?;
                record.held_out = rms_of_folds(&squares);
                record.compare(squares, oracle.rows, &mut first);
            }
            Err(error) => record.status = error.to_string().replace([',', '\n'], ";"),
        }
        records.push(record);
    }
    Ok(records)
}

/// The status in one word.
fn status(solution: &Solution) -> String {
    let word = format!("{:?}", solution.status);
    word.split([' ', '{']).next().unwrap_or_default().to_owned()
}

/// A solve with its wall time and the most bytes that it held at once.
fn weighed(solver: &dyn Solver, problem: &LeastSquares<'_>) -> (Result<Solution, SolveError>, f64, u64) {
    let mut solved = None;
    let begun = Instant::now();
    let counted = allocation_counter::measure(|| solved = Some(solver.solve(problem)));
    let seconds = begun.elapsed().as_secs_f64();
    // `measure` calls its closure once.
    let solved = solved.unwrap_or_else(|| solver.solve(problem));
    (solved, seconds, counted.bytes_max)
}

/// What can be reached by one who knows which rows are wrong.
struct Oracle {
    held_out: f64,
    parameters: f64,
    /// Rows that are not wrong.
    rows: usize,
}

impl Oracle {
    fn new(problem: &Problem, folds: &[Vec<usize>]) -> Result<Self, SolveError> {
        let right = |rows: &mut dyn Iterator<Item = usize>| -> Vec<usize> {
            rows.filter(|&i| !problem.wrong[i]).collect()
        };
        let fit = |rows: &[usize]| -> Result<DVector<f64>, SolveError> {
            let rows = problem.rows(rows);
            Ok(PivotedQr::default().solve(&rows.problem(problem, false))?.x)
        };
        let squares = folds
            .iter()
            .map(|out| {
                let rest = right(&mut folds.iter().filter(|f| f != &out).flatten().copied());
                Ok(squares(problem, out, &fit(&rest)?))
            })
            .collect::<Result<Squares, SolveError>>()?;
        let all = right(&mut (0..problem.y.len()));
        Ok(Oracle {
            held_out: rms_of_folds(&squares),
            parameters: problem.parameter_error(&fit(&all)?),
            rows: all.len(),
        })
    }
}

/// Held-out squares of every fold.
fn held_out(problem: &Problem, folds: &[Vec<usize>], solver: &dyn Solver) -> Result<Squares, SolveError> {
    folds
        .par_iter()
        .map(|out| {
            let rest: Vec<usize> = folds.iter().filter(|f| f != &out).flatten().copied().collect();
            let rows = problem.rows(&rest);
            let solution = solver.solve(&rows.problem(problem, solver.supports(Need::Bounds)))?;
            Ok(squares(problem, out, &solution.x))
        })
        .collect()
}

/// Squares at those of these rows that are not wrong.
fn squares(problem: &Problem, rows: &[usize], x: &DVector<f64>) -> (f64, usize) {
    let right: Vec<usize> = rows.iter().copied().filter(|&i| !problem.wrong[i]).collect();
    let some = problem.rows(&right);
    ((&some.a * x - &some.y).norm_squared(), right.len())
}

/// Visits at random into folds: the rows of each.
fn folds(problem: &Problem, seed: u64) -> Vec<Vec<usize>> {
    let count = problem.visits.last().map_or(0, |last| last + 1);
    let mut order: Vec<usize> = (0..count).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed + 1000));
    let mut fold = vec![0; count];
    order.iter().enumerate().for_each(|(place, &visit)| fold[visit] = place % FOLDS);
    let mut rows = vec![Vec::new(); FOLDS];
    problem.visits.iter().enumerate().for_each(|(row, &visit)| rows[fold[visit]].push(row));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solvers::optimality::strategies;

    #[test]
    fn robust_fits_come_near_the_oracle_and_plain_squares_do_not() {
        let strategies: Vec<Strategy> = strategies()
            .unwrap()
            .into_iter()
            .filter(|s| ["qr", "huber(qr)", "tukey(qr)"].contains(&s.name))
            .collect();
        let recipe = Recipe { condition: 1e2, noise: 0.01, outliers: 0.1, rows: 600, effects: 8, seed: 5 };
        let records = trial("outliers", &recipe, &strategies).unwrap();
        assert!(records[0].ratio() > 1.2, "{:?}", records[0]);
        for robust in &records[1..] {
            assert!(robust.ratio() < 1.10 && robust.p_value < 0.05 && robust.t < 0.0, "{robust:?}");
            assert!(robust.bytes > 600.0 * 24.0 * 8.0 && robust.rank > 23.5);
        }
    }
}
