//! Calibrations of simulated robots: plants that share no code with the model, constant errors and joint compliance declared.
//!
//! The folds are of configurations; errors are evaluated at rows without outliers, against an oracle that excludes the outliers.

use super::optimality::Strategy;
use super::record::Record;
use crate::prelude::*;
use truepose_identify::{Folds, Split};
use truepose_simulate::{SimulateError, robots};
use truepose_solvers::Need;

/// Configurations measured.
const CONFIGURATIONS: usize = 70;
/// Size of a wrong row, m.
const WRONG: f64 = 2e-3;

/// Rounds of a fit at most with a penalty: what it chooses hardly changes from round to round, and each round chooses
/// anew. Ordinary least squares reduces its steps and needs all iterations; robust fits converge earlier.
const PENALISED: usize = 4;
const ROBUST: usize = 10;

/// Which plants, by name.
pub const PLANTS: [&str; 2] = ["ur10", "heavy"];

/// A plant measured with some wrong rows.
struct Calibration {
    model: ErrorModel,
    data: Dataset,
    wrong: Vec<bool>,
    folds: Folds,
    options: FitOptions,
}

/// Every strategy on the calibration of one plant.
pub fn trial(name: &str, outliers: f64, seed: u64, strategies: &[Strategy]) -> Outcome<Vec<Record>> {
    let calibration = Calibration::new(name, outliers, seed)?;
    let oracle = rms_of_folds(&calibration.held_out(&PivotedQr::default(), true)?);
    let mut records = Vec::new();
    let mut first: Option<Squares> = None;
    for strategy in strategies {
        let mut record = Record {
            outliers,
            rows: (3 * calibration.data.len()) as f64,
            unknowns: calibration.model.columns().len() as f64,
            seed: seed as f64,
            oracle: 1e3 * oracle,
            ..Record::blank(name, strategy.name)
        };
        let all: Vec<usize> = (0..calibration.data.len()).collect();
        let begun = Instant::now();
        let mut fitted = None;
        let counted = allocation_counter::measure(|| fitted = Some(calibration.fit(&*strategy.solver, &all)));
        record.seconds = begun.elapsed().as_secs_f64();
        record.bytes = counted.bytes_max as f64;
        match fitted {
            Some(Ok(fit)) => {
                record.status = if fit.converged { "Converged".into() } else { "MaxIterations".into() };
                record.iterations = fit.rounds as f64;
                record.rank = fit.solution.rank as f64;
                let squares = calibration.held_out(&*strategy.solver, false)?;
                record.held_out = 1e3 * rms_of_folds(&squares);
                let rows = squares.iter().map(|s| s.1).sum();
                record.compare(squares, rows, &mut first);
            }
            Some(Err(error)) => record.status = error.to_string().replace([',', '\n'], ";"),
            None => {}
        }
        records.push(record);
    }
    Ok(records)
}

impl Calibration {
    fn new(name: &str, outliers: f64, seed: u64) -> Outcome<Self> {
        let mut plant = plant(name, seed)?;
        plant.blunders.outlier_share = outliers;
        plant.blunders.outlier_size = WRONG;
        let chain = plant.chain().clone();
        let campaign = Campaign::random(&chain, CONFIGURATIONS, seed)?;
        let seen = plant.observe(&campaign, seed)?;
        let mut wrong = vec![false; seen.data.len()];
        seen.outliers.iter().for_each(|&row| wrong[row] = true);
        // No prior: what is compared is what the solvers do about weak directions.
        let options = FitOptions { prior: PriorStrength::None, ..FitOptions::default() };
        let folds = Folds::new(&seen.data, &Split::Random { folds: super::trial::FOLDS, seed })?;
        Ok(Calibration {
            model: ErrorModel::new(chain, elastic_errors())?,
            data: seen.data,
            wrong,
            folds,
            options,
        })
    }

    fn fit(&self, solver: &dyn Solver, rows: &[usize]) -> Result<Fit, truepose_identify::IdentifyError> {
        let max_iterations = match (solver.supports(Need::Unpenalised), solver.supports(Need::Outliers)) {
            (true, false) => self.options.max_iterations,
            (true, true) => ROBUST,
            (false, _) => PENALISED,
        };
        let options = FitOptions { max_iterations, ..self.options.clone() };
        fit(&self.model, &self.data.select(rows), solver, &options)
    }

    /// Held-out squares of every fold; `without_wrong` leaves wrong rows out of the fits.
    fn held_out(&self, solver: &dyn Solver, without_wrong: bool) -> Outcome<Squares> {
        let visits = Visits::of(&self.data);
        let fold = |row: usize| self.folds.of_visit[self.data.visit[row]];
        let one = |out: usize| -> Outcome<(f64, usize)> {
            let used = |row: &usize| fold(*row) != out && !(without_wrong && self.wrong[*row]);
            let rows: Vec<usize> = (0..self.data.len()).filter(used).collect();
            let fit = self.fit(solver, &rows)?;
            let held: Vec<usize> =
                visits.rows.iter().flatten().copied().filter(|&r| fold(r) == out && !self.wrong[r]).collect();
            let residuals = Residuals::of(&fit.fitted, &self.data.select(&held))?;
            let squares = (0..held.len()).filter_map(|k| residuals.distance(k)).map(|d| d * d);
            Ok((squares.sum(), held.len()))
        };
        (0..self.folds.count).into_par_iter().map(one).collect()
    }
}

fn plant(name: &str, seed: u64) -> Result<Plant, SimulateError> {
    match name {
        "ur10" => robots::ur10_plant(seed),
        _ => robots::heavy_plant(seed),
    }
}
