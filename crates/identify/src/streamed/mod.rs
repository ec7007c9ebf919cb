//! Identification from data of any length, in memory that does not depend on it.
//!
//! ```text
//! sample ──► place ──► fit: reduction, shapes, noise, prior, c₀
//! passes    G_f = Σ [A r]ᵀ[A r] at c₀, for each fold f of the configurations      ──►  c = c₀ + δ,  δ_f without fold f
//! the last  residuals at c;  held out: r − A (δ_f − δ), both at c                     ──►  statistics
//! ```
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | c₀ | coefficients of the sample's fit; zero for the linear one | p |
//! | A, r | whitened design matrix over the kept columns, residuals | m × r, m |
//! | G_f | [`Gram`], or the triangular factor where that has too few digits | (r + 1)² |
//!
//! What decides *which* unknowns there are (null spaces, groups, shapes, κ, the noise) is taken from a sample of some thousand numbers all
//! over the data; what they *are* comes from all rows. The linear fit takes one step from zero; the refined one begins at the sample's
//! coefficients and goes on, a pass a step, until nothing moves. What has to see all rows at once cannot be done this way: solvers that
//! weigh rows or validate on them, channels that lag, directions of approach that the data does not state, repeats, and the search for what is
//! missing.

mod pass;
mod tally;

pub use tally::Tally;

use crate::fit::from_factor;
use crate::{Fit, FitOptions, IdentifyError, Placement, Spread, Warning, fit, place, refit};
use pass::{Equations, Judged, Sums};
use std::borrow::Cow;
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel};
use truepose_kinematics::Chain;
use truepose_solvers::accumulator::{Factor, Triangular};
use truepose_solvers::{Gram, Need, Solver};

/// Rows of one robot that can be gone through again and again, in blocks.
pub trait Source {
    /// What can go wrong on the way.
    type Error: From<IdentifyError>;

    /// About so many rows from all over the data.
    ///
    /// # Errors
    /// When they cannot be had.
    fn sample(&mut self, rows: usize) -> Result<Dataset, Self::Error>;

    /// Hands on all rows once, block by block, always the same blocks in the same order, no visit cut.
    ///
    /// # Errors
    /// When they cannot be had, or what `take` says. A source that is to be cancelled returns an error of its own between two blocks.
    fn each(
        &mut self,
        take: &mut dyn FnMut(&Dataset) -> Result<(), IdentifyError>,
    ) -> Result<(), Self::Error>;
}

/// What to do besides fitting.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamedOptions {
    /// How to fit.
    pub fit: FitOptions,
    /// Folds of the cross-validation over configurations; none below two.
    pub folds: usize,
}

/// Held-out residuals.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOut {
    /// 3-D distances, m.
    pub position: Spread,
    /// Angles, rad.
    pub orientation: Spread,
    /// RMS of the 3-D distance in each fold, m.
    pub fold_rms: Vec<f64>,
}

/// What was found in data of any length.
#[derive(Debug, Clone)]
pub struct Streamed {
    /// Where base, tool and targets were found, from the sample.
    pub placement: Placement,
    /// The fit of all rows; its residuals are empty.
    pub fit: Fit,
    /// Rows of the sample.
    pub sampled: usize,
    /// Rows.
    pub rows: usize,
    /// Visits.
    pub visits: usize,
    /// 3-D distances of all rows to the fitted model, m.
    pub position: Spread,
    /// Angles, rad.
    pub orientation: Spread,
    /// Cross-validation, where it was asked for and every fold can be left out.
    pub held_out: Option<HeldOut>,
    /// Whether Gram matrices had digits enough.
    pub gram: bool,
}

/// Condition number of the columns up to which a Gram matrix is trusted.
const TRUSTED: f64 = 1e6;

/// Passes on which the model is linearised, at most, and the step (relative, whitened) below which nothing moves.
const ROUNDS: usize = 6;
const STILL: f64 = 1e-6;
/// A pass that gained less than this share of the whitened squares over the one before was the last.
const FLAT: f64 = 1e-6;

/// Rows of a sample for a model of so many unknowns.
pub fn sample_rows(unknowns: usize) -> usize {
    (4 * unknowns).max(1000)
}

/// Identifies a robot from rows that are nowhere whole in memory.
///
/// # Errors
/// When something of it cannot be done this way, the model does not fit the data, or a solver refuses.
pub fn identify_streamed<S: Source>(
    chain: &Chain,
    effects: &[Box<dyn AnyEffect>],
    source: &mut S,
    solver: &dyn Solver,
    options: &StreamedOptions,
) -> Result<Streamed, S::Error> {
    if !solver.supports(Need::Unpenalised) || solver.supports(Need::Outliers) {
        return Err(not_streamed(format!("solver `{}` has to see all rows at once", solver.name())).into());
    }
    let declared = ErrorModel::new(chain.clone(), effects.to_vec()).map_err(IdentifyError::from)?;
    let sample = source.sample(sample_rows(declared.columns().len()))?;
    if let Cow::Owned(_) = sample.derived_for(&declared).map_err(IdentifyError::from)? {
        return Err(not_streamed("a channel that lags has to see all rows at once".into()).into());
    }
    let placement = place(chain, &sample)?;
    let model = declared.on(placement.chain.clone()).map_err(IdentifyError::from)?;
    let first = of_sample(&model, &sample, solver, &options.fit)?;
    let unknowns = first.fitted.coefficients().len();
    let mut at = match options.fit.refine {
        true => first.fitted.coefficients().to_vec(),
        false => vec![0.0; unknowns],
    };

    let folds = if options.folds < 2 { 1 } else { options.folds };
    let rank = first.reduction.rank();
    let most = if options.fit.refine { ROUNDS } else { 1 };
    let mut gram = true;
    let (mut rounds, mut before) = (0, f64::INFINITY);
    let (sums, mut whole, mut changes) = loop {
        rounds += 1;
        let mut sums = Sums::new(rank, folds, !gram);
        source.each(&mut |block| sums.take(&first, &at, block))?;
        let Some((factor, changes)) = solve(&first, &at, &sums)? else {
            gram = false;
            rounds -= 1;
            continue;
        };
        let fitted = from_factor(&first, &sample, solver, &options.fit, &at, &factor, sums.observations)?;
        let (mut whole, step) = fitted;
        // In a flat valley steps need not become short: nothing is gained any more.
        let squares = factor.z.column(0).norm_squared() + factor.rss[0];
        let flat = before - squares < FLAT * squares;
        before = squares;
        let converged = !options.fit.refine || step < STILL || flat;
        if !converged && rounds < most {
            at = whole.fitted.coefficients().to_vec();
            continue;
        }
        (whole.rounds, whole.converged) = (rounds, converged);
        if !converged {
            whole.warnings.push(Warning::NotConverged { rounds });
        }
        break (sums, whole, changes);
    };
    whole.fitted.domain = sums.domain.clone();

    // From `at` on, and now from the solution on.
    let moved: Vec<f64> = whole.fitted.coefficients().iter().zip(&at).map(|(c, at)| c - at).collect();
    for change in &mut changes {
        change.iter_mut().zip(&moved).for_each(|(change, moved)| *change -= moved);
    }
    let mut judged = Judged::new(changes.len());
    source.each(&mut |block| judged.take(&whole, &changes, block))?;
    let held_out = (!changes.is_empty()).then(|| HeldOut {
        position: judged.held_position.spread(),
        orientation: judged.held_orientation.spread(),
        fold_rms: judged.folds.iter().map(|fold| fold.spread().rms).collect(),
    });
    Ok(Streamed {
        placement,
        fit: whole,
        sampled: sample.len(),
        rows: sums.rows,
        visits: sums.visits,
        position: judged.position.spread(),
        orientation: judged.orientation.spread(),
        held_out,
        gram,
    })
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
