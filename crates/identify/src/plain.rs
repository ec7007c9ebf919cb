//! Least squares and nothing besides: no prior, no estimate of the noise, no look at the structure beyond the data's own rank.
//!
//! ```text
//! min ‖A δ − r‖²   over the columns that the data tells apart;   c ← c + δ, again, until nothing moves
//! ```
//!
//! What [`crate::fit`] does around it is worth its time where a person waits for an answer. Where thousands of fits are compared, or the
//! question is only what the least squares are, this is the short way. The Gram matrix answers as long as it is fit to, and the triangular
//! factor, which keeps all digits, otherwise; or all digits are asked for.

use crate::linearise::{gram, left_over, refined, triangular};
use crate::{IdentifyError, NoiseModel, Residuals};
use nalgebra::DVector;
use truepose_errormodel::{Dataset, ErrorModel, Visits};
use truepose_solvers::{ColumnScale, RankRule, Solution};

/// By which factorisation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Way {
    /// The Gram matrix, up to this condition number of the columns; beyond it, and where the rank is in doubt, the other one.
    Guarded(f64),
    /// All digits: the Gram matrix, refined on the rows, where these show that what it takes for dependent is so
    /// ([`truepose_solvers::accumulator::Gram::solve_refined`]), else the triangular factor.
    Stable(RankRule),
}

impl Default for Way {
    fn default() -> Self {
        Way::Guarded(1e6)
    }
}

/// The least squares.
#[derive(Debug, Clone)]
pub struct Plain {
    /// Coefficients of the model; zero for columns that depend on others.
    pub coefficients: Vec<f64>,
    /// Columns that were kept, ascending.
    pub kept: Vec<usize>,
    /// How often the model was linearised.
    pub rounds: usize,
    /// Whether the Gram matrix alone gave the answer.
    pub guarded: bool,
    /// Whether nothing moved any more in the last round.
    pub converged: bool,
}

/// Condition number of the columns up to which a Gram matrix is refined: each step takes away nine tenths of the error at least.
const TRUSTED: f64 = 1e6;

/// Steps shorter than this, relative to where they lead, are none.
const STILL: f64 = 1e-10;

/// Solves for the coefficients, linearised at most `rounds` times: once is the linear fit.
///
/// # Errors
/// When the model and the data do not fit, or a number is not finite.
pub fn plain(
    model: &ErrorModel,
    data: &Dataset,
    noise: NoiseModel,
    columns: Option<&[usize]>,
    way: Way,
    rounds: usize,
) -> Result<Plain, IdentifyError> {
    let visits = Visits::of(data);
    let mut coefficients = vec![0.0; model.columns().len()];
    let mut kept: Vec<usize> = match columns {
        Some(columns) => columns.to_vec(),
        None => (0..coefficients.len()).collect(),
    };
    let mut guarded = true;
    let (mut round, mut converged) = (0, false);
    while round < rounds.max(1) && !converged {
        round += 1;
        let (solution, by_gram) = step(model, data, &visits, noise, &coefficients, &kept, way)?;
        guarded &= by_gram;
        let mut moved = 0.0;
        for (&column, change) in kept.iter().zip(solution.x.iter()) {
            coefficients[column] += change;
            moved += change * change;
        }
        if round == 1
            && let Some(places) = solution.info.kept
        {
            kept = places.into_iter().map(|place| kept[place]).collect();
        }
        let size: f64 = coefficients.iter().map(|c| c * c).sum();
        converged = moved.sqrt() < STILL * (1.0 + size.sqrt());
    }
    Ok(Plain { coefficients, kept, rounds: round, guarded, converged })
}

fn step(
    model: &ErrorModel,
    data: &Dataset,
    visits: &Visits,
    noise: NoiseModel,
    at: &[f64],
    columns: &[usize],
    way: Way,
) -> Result<(Solution, bool), IdentifyError> {
    let mut rule = RankRule::Default;
    match way {
        Way::Guarded(limit) => {
            let gram = gram(model, data, visits, noise, at, Some(columns))?;
            if let Some(solution) = gram.solve_guarded(0, limit)? {
                return Ok((solution, true));
            }
        }
        Way::Stable(own) => {
            rule = own;
            if let Some(solution) = refined(model, data, visits, noise, at, Some(columns), (TRUSTED, rule))? {
                return Ok((solution, false));
            }
        }
    }
    let triangle = triangular(model, data, visits, noise, at, Some(columns))?;
    let (factor, order) = triangle.into_factor_in_any_order();
    let found = factor.solve_pivoted(0, ColumnScale::Norms, rule)?;
    let mut solution = Solution { x: DVector::zeros(columns.len()), ..found.clone() };
    order.iter().zip(found.x.iter()).for_each(|(&column, x)| solution.x[column] = *x);
    if let Some(kept) = &mut solution.info.kept {
        kept.iter_mut().for_each(|place| *place = order[*place]);
        kept.sort_unstable();
    }
    Ok((solution, false))
}

impl Plain {
    /// Residuals with the first linearisation, `y − y(0) − A c`, or with the exact robot.
    ///
    /// # Errors
    /// When the model and the data do not fit.
    pub fn residuals(
        &self,
        model: &ErrorModel,
        data: &Dataset,
        exact: bool,
    ) -> Result<Residuals, IdentifyError> {
        let zero = vec![0.0; self.coefficients.len()];
        match exact {
            true => left_over(model, data, &self.coefficients, &zero),
            false => left_over(model, data, &zero, &self.coefficients),
        }
    }
}
