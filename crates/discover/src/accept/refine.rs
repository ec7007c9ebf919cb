//! Nonlinear parameters of a new finding, optimised with the finding in the model.
//!
//! The screen optimised period, change point or time constant under a noise estimate that contained the
//! effect. Here each of them is optimised again near its value, under the noise of the model with the
//! finding, with all other columns of the model and of the finding projected out (variable projection, Golub
//! and Pereyra 1973).

use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::current::{Context, ModelFit};
use crate::problem::likelihood::without;
use crate::problem::linearisation::Linearisation;
use crate::problem::projection::Projection;
use crate::screen::refine::refined;
use rayon::prelude::*;

/// The finding with its nonlinear parameters optimised again; none when it has none, or the statistic does not grow.
pub(crate) fn refined_in_model(
    context: &Context<'_>,
    current: &ModelFit,
    which: usize,
) -> Result<Option<Candidate>, DiscoverError> {
    let mut parts: Vec<Candidate> = current.found[which]
        .effects()
        .iter()
        .map(|effect| current.found[which].with_effects(vec![effect.clone()]))
        .collect();
    if !parts.iter().any(Candidate::is_refinable) {
        return Ok(None);
    }
    let own = context.effects_of(&current.found, which);
    let Some(mut linearisation) =
        without(Linearisation::new(&current.fit, &current.data, context.options)?, own)?
    else {
        return Ok(None);
    };
    linearisation.noise = current.fit.noise.into();
    let present = Projection::new(&linearisation);
    let mut gained = false;
    for _ in 0..if parts.len() > 1 { context.budget().sweeps } else { 1 } {
        let better: Vec<Option<Candidate>> = (0..parts.len())
            .into_par_iter()
            .map(|k| -> Result<Option<Candidate>, DiscoverError> {
                if !parts[k].is_refinable() {
                    return Ok(None);
                }
                let others: Vec<_> =
                    (0..parts.len()).filter(|&l| l != k).flat_map(|l| parts[l].effects().to_vec()).collect();
                let with =
                    if others.is_empty() { None } else { present.with(&linearisation.columns(&others)?) };
                let projection = with.as_ref().unwrap_or(&present);
                let gain = |candidate: &Candidate| {
                    projection.judge(&linearisation, candidate).map_or(f64::NEG_INFINITY, |score| score.gain)
                };
                let better = refined(&linearisation, projection, &parts[k]);
                Ok((gain(&better) > gain(&parts[k])).then_some(better))
            })
            .collect::<Result<_, _>>()?;
        for (part, better) in parts.iter_mut().zip(better) {
            if let Some(better) = better {
                part.change = better.change;
                gained = true;
            }
        }
    }
    let effects = parts.iter().flat_map(|part| part.effects().to_vec()).collect();
    Ok(gained.then(|| current.found[which].with_effects(effects)))
}
