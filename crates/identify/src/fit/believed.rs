//! Robust fits begun anew from the visits that they believe.

use super::options::FitOptions;
use super::rounds::{Outcome, State, doubted};
use crate::reduction::Reduction;
use crate::{IdentifyError, Prior, PriorStrength};
use truepose_errormodel::{Dataset, Visits};
use truepose_solvers::{PivotedQr, Solver};

/// A robust fit begun anew from a plain one of the visits that it believes, for as long as these change: noise that wrong visits have blown
/// up makes a prior so tight, and a picture so coarse, that other wrong visits cannot be seen in it.
pub(super) fn without_doubted<'a>(
    state: &mut State<'a>,
    data: &'a Dataset,
    solver: &'a dyn Solver,
    options: &FitOptions,
    reduction: &Reduction,
    mut outcome: Outcome,
) -> Result<Outcome, IdentifyError> {
    const MOST: usize = 3;
    let asked = |state: &State<'_>| match options.prior {
        PriorStrength::None => state.prior.clone(),
        strength => Prior::new(state.fitted_model(), reduction, strength),
    };
    let mut before: Vec<usize> = Vec::new();
    for _ in 0..MOST {
        let doubted = doubted(&outcome, &state.rows_at(&state.coefficients)?.visit);
        if doubted == before {
            break;
        }
        let rows: Vec<usize> =
            (0..data.len()).filter(|&row| doubted.binary_search(&data.visit[row]).is_err()).collect();
        let believed = data.select(&rows);
        let visits = Visits::of(&believed);
        let plain = PivotedQr::default();
        let model = state.fitted_model().clone();
        let mut inner = State::new(&model, &believed, &visits, &plain, options)?;
        inner.prior = asked(state);
        inner.coefficients.clone_from(&state.coefficients);
        let factor = inner.linearise(Some(&reduction.kept))?;
        if factor.rows < reduction.rank() {
            break;
        }
        inner.rounds(reduction, factor)?;
        let kept = state.spoilable();
        state.back_to(inner.spoilable());
        let factor = state.linearise(Some(&reduction.kept))?;
        let begin = state.here(reduction, factor)?;
        let prior = state.prior.clone();
        let (next, taken) = state.follow(solver, prior, reduction, begin)?;
        if !taken || !next.converged() && outcome.converged() {
            state.back_to(kept);
            break;
        }
        let rounds = outcome.rounds + next.rounds;
        (outcome, before) = (next, doubted);
        outcome.rounds = rounds;
    }
    Ok(outcome)
}
