//! A streamed identification from pass to pass. Blocks may be anywhere: a pass says what to do with one, and takes what they come to.

use super::pass::{Equations, FitPass, JudgePass, Judged, Pass, Sums};
use super::{HeldOut, Streamed, StreamedOptions, sample_rows};
use crate::fit::from_factor;
use crate::{Fit, FitOptions, IdentifyError, Placement, Warning, fit, place, refit};
use std::borrow::Cow;
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel};
use truepose_kinematics::Chain;
use truepose_solvers::accumulator::{Factor, Triangular};
use truepose_solvers::{Gram, Need, Solver};

/// Condition number of the columns up to which a Gram matrix is trusted.
const TRUSTED: f64 = 1e6;

/// Passes on which the model is linearised, at most, and the step (relative, whitened) below which nothing moves.
const ROUNDS: usize = 6;
const STILL: f64 = 1e-6;
/// A pass that gained less than this share of the whitened squares over the one before was the last.
const FLAT: f64 = 1e-6;

/// What is known between two passes.
#[derive(Debug, Clone)]
pub struct StreamedRun {
    sample: Dataset,
    options: StreamedOptions,
    placement: Placement,
    /// The fit of the sample.
    first: Fit,
    at: Vec<f64>,
    gram: bool,
    rounds: usize,
    before: f64,
    /// The fit of all rows, and what leaving out each fold changes, once nothing moves any more.
    done: Option<(Fit, Vec<Vec<f64>>, [usize; 2])>,
}

impl StreamedRun {
    /// Whether a solver can work on sums.
    ///
    /// # Errors
    /// When it has to see all rows at once.
    pub fn supported(solver: &dyn Solver) -> Result<(), IdentifyError> {
        if !solver.supports(Need::Unpenalised) || solver.supports(Need::Outliers) {
            return Err(not_streamed(format!("solver `{}` has to see all rows at once", solver.name())));
        }
        Ok(())
    }

    /// Rows that a sample should have.
    ///
    /// # Errors
    /// When the effects do not fit the robot.
    pub fn wanted(chain: &Chain, effects: &[Box<dyn AnyEffect>]) -> Result<usize, IdentifyError> {
        Ok(sample_rows(ErrorModel::new(chain.clone(), effects.to_vec())?.columns().len()))
    }

    /// Decides the structure on a sample of the rows.
    ///
    /// # Errors
    /// When something cannot be done this way, the model does not fit the data, or a solver refuses.
    pub fn begin(
        chain: &Chain,
        effects: &[Box<dyn AnyEffect>],
        sample: Dataset,
        solver: &dyn Solver,
        options: &StreamedOptions,
    ) -> Result<Self, IdentifyError> {
        StreamedRun::supported(solver)?;
        let declared = ErrorModel::new(chain.clone(), effects.to_vec())?;
        if let Cow::Owned(_) = sample.derived_for(&declared)? {
            return Err(not_streamed("a channel that lags has to see all rows at once".into()));
        }
        let placement = place(chain, &sample)?.checked()?;
        let model = declared.on(placement.chain.clone())?;
        let first = of_sample(&model, &sample, solver, &options.fit)?;
        let at = match options.fit.refine {
            true => first.fitted.coefficients().to_vec(),
            false => vec![0.0; first.fitted.coefficients().len()],
        };
        let options = options.clone();
        let (rounds, before) = (0, f64::INFINITY);
        Ok(StreamedRun { sample, options, placement, first, at, gram: true, rounds, before, done: None })
    }

    /// What to do with all blocks next.
    pub fn pass(&self) -> Pass {
        match &self.done {
            Some((whole, changes, _)) => {
                Pass::Judge(Box::new(JudgePass { fitted: whole.fitted.clone(), changes: changes.clone() }))
            }
            None => Pass::Fit(Box::new(FitPass {
                fitted: self.first.fitted.clone(),
                at: self.at.clone(),
                kept: self.first.reduction.kept.clone(),
                noise: self.first.noise,
                folds: if self.options.folds < 2 { 1 } else { self.options.folds },
                all_digits: !self.gram,
            })),
        }
    }

    /// Takes the sums of a pass.
    ///
    /// # Errors
    /// When a solver refuses.
    pub fn solve(&mut self, sums: &Sums, solver: &dyn Solver) -> Result<(), IdentifyError> {
        let (first, options) = (&self.first, &self.options.fit);
        let most = if options.refine { ROUNDS } else { 1 };
        let Some((factor, mut changes)) = solve(first, &self.at, sums)? else {
            self.gram = false;
            return Ok(());
        };
        self.rounds += 1;
        let (mut whole, step) =
            from_factor(first, &self.sample, solver, options, &self.at, &factor, sums.observations)?;
        // In a flat valley steps need not become short: nothing is gained any more.
        let squares = factor.z.column(0).norm_squared() + factor.rss[0];
        let flat = self.before - squares < FLAT * squares;
        self.before = squares;
        let converged = !options.refine || step < STILL || flat;
        if !converged && self.rounds < most {
            self.at = whole.fitted.coefficients().to_vec();
            return Ok(());
        }
        (whole.rounds, whole.converged) = (self.rounds, converged);
        if !converged {
            whole.warnings.push(Warning::NotConverged { rounds: self.rounds, all: true });
        }
        whole.fitted.domain = sums.domain.clone();
        // From `at` on, and now from the solution on.
        let moved: Vec<f64> =
            whole.fitted.coefficients().iter().zip(&self.at).map(|(c, at)| c - at).collect();
        for change in &mut changes {
            change.iter_mut().zip(&moved).for_each(|(change, moved)| *change -= moved);
        }
        self.done = Some((whole, changes, [sums.rows, sums.visits]));
        Ok(())
    }

    /// Takes the residuals of the last pass.
    ///
    /// # Errors
    /// When no pass for a fit was the last one.
    pub fn finish(self, judged: &Judged) -> Result<Streamed, IdentifyError> {
        let Some((fit, changes, [rows, visits])) = self.done else {
            return Err(not_streamed("there is no fit to judge yet".into()));
        };
        let held_out = (!changes.is_empty()).then(|| HeldOut {
            position: judged.held_position.spread(),
            orientation: judged.held_orientation.spread(),
            fold_rms: judged.folds.iter().map(|fold| fold.spread().rms).collect(),
        });
        Ok(Streamed {
            placement: self.placement,
            fit,
            sampled: self.sample.len(),
            rows,
            visits,
            position: judged.position.spread(),
            orientation: judged.orientation.spread(),
            held_out,
            gram: self.gram,
        })
    }
}

/// The fit of the sample, on which the structure is decided. What can be told apart only because errors have moved the robot (see [`fit`]) is
/// taken in where the sample comes to rest with it and gains more than that many unknowns cost (Schwarz 1978).
fn of_sample(
    model: &ErrorModel,
    sample: &Dataset,
    solver: &dyn Solver,
    options: &FitOptions,
) -> Result<Fit, IdentifyError> {
    let nominal = fit(model, sample, solver, &FitOptions { refine: false, ..options.clone() })?;
    if !options.refine {
        return Ok(nominal);
    }
    let again = refit(nominal.fitted.model(), sample, solver, options, &nominal.reduction, &nominal.prior)?;
    let nominal = Fit { shapes: nominal.shapes, ..again };
    let bent = fit(
        model,
        sample,
        solver,
        &FitOptions { max_iterations: options.max_iterations.min(40), ..options.clone() },
    );
    let squares = |fit: &Fit| match fit.residuals.positions() {
        none if none.count == 0 => fit.residuals.orientations().rms.powi(2),
        some => some.rms.powi(2),
    };
    let m = nominal.observations as f64;
    Ok(match bent {
        Ok(bent) if bent.converged && bent.reduction.rank() > nominal.reduction.rank() => {
            let more = (bent.reduction.rank() - nominal.reduction.rank()) as f64;
            if m * (squares(&nominal) / squares(&bent)).ln() > more * m.ln() { bent } else { nominal }
        }
        _ => nominal,
    })
}

fn not_streamed(why: String) -> IdentifyError {
    IdentifyError::NotStreamed { why }
}

/// The factor of everything, and for each fold what leaving it out changes in the model's coefficients, from `at` on; no changes where there
/// is one fold or some fold cannot be left out. None where Gram matrices have too few digits.
type Solved = Option<(Factor, Vec<Vec<f64>>)>;

fn solve(fit: &Fit, at: &[f64], sums: &Sums) -> Result<Solved, IdentifyError> {
    let grouped = fit.reduction.grouped(at);
    let expand = |x: &[f64]| fit.reduction.expand(x, at.len());
    // The prior's rows on δ = β − β(at), which belong to no fold.
    let prior = fit.prior.rows().map(|rows| {
        let pull = -(&rows * nalgebra::DVector::from_column_slice(&grouped));
        (rows, nalgebra::DMatrix::from_column_slice(pull.len(), 1, pull.as_slice()))
    });
    let mut changes = Vec::new();
    match &sums.equations {
        Equations::Gram(folds) => {
            let rank = fit.reduction.rank();
            let without = |out: Option<usize>| -> Result<Gram, IdentifyError> {
                let mut sum = Gram::new(rank, 1);
                for (_, part) in folds.iter().enumerate().filter(|(k, _)| Some(*k) != out) {
                    sum.merge(part)?;
                }
                Ok(sum)
            };
            let whole = without(None)?;
            let trusted = whole.solve_guarded(0, TRUSTED)?.is_some_and(|solution| solution.rank == rank);
            if !trusted {
                return Ok(None);
            }
            for out in (0..folds.len()).filter(|_| folds.len() > 1) {
                let mut rest = without(Some(out))?;
                if let Some((rows, pull)) = &prior {
                    rest.update(rows, pull)?;
                }
                match rest.solve_guarded(0, TRUSTED)? {
                    Some(solution) if solution.rank == rank => changes.push(expand(solution.x.as_slice())),
                    _ => return Ok(Some((whole.finish()?, Vec::new()))),
                }
            }
            Ok(Some((whole.finish()?, changes)))
        }
        Equations::Triangle(folds) => {
            let without = |out: Option<usize>| -> Result<Factor, IdentifyError> {
                let mut sum = Triangular::new(fit.reduction.rank(), 1);
                for (_, part) in folds.iter().enumerate().filter(|(k, _)| Some(*k) != out) {
                    sum.merge(part)?;
                }
                if let (Some(_), Some((rows, pull))) = (out, &prior) {
                    sum.update(rows, pull)?;
                }
                Ok(sum.into_factor())
            };
            for out in (0..folds.len()).filter(|_| folds.len() > 1) {
                let rest = without(Some(out))?;
                match rest.r.solve_upper_triangular(&rest.z.column(0).into_owned()) {
                    Some(x) if x.iter().all(|v| v.is_finite()) => changes.push(expand(x.as_slice())),
                    _ => {
                        changes.clear();
                        break;
                    }
                }
            }
            Ok(Some((without(None)?, changes)))
        }
    }
}
