//! Comparison of corrected payloads by whole fits, in which masses and compliances are estimated jointly.

use crate::contest::competitor::{Competitor, with_estimates};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::model::current::{Context, ModelFit};
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Linearisation;
use nalgebra::DMatrix;
use rayon::prelude::*;
use truepose_errormodel::Visits;

/// When a corrected payload leads the competitors, moves that declared level to the front whose refitted
/// model has the smallest −2 ln L: the product of mass and compliance is determined better than either, and
/// the linearised problem holds the compliance.
pub(crate) fn order_payloads(
    context: &Context<'_>,
    current: &ModelFit,
    competitors: &mut [Competitor],
) -> Result<(), DiscoverError> {
    let is_load = |competitor: &Competitor| matches!(competitor.candidate.change, Change::CorrectLoad { .. });
    let levels: Vec<usize> = (0..competitors.len()).filter(|&k| is_load(&competitors[k])).collect();
    if levels.first() != Some(&0) || levels.len() < 2 {
        return Ok(());
    }
    let candidates: Vec<Candidate> = levels.iter().map(|&k| with_estimates(&competitors[k])).collect();
    let deviances: Vec<f64> = candidates
        .into_par_iter()
        .map(|candidate| {
            let mut found = current.found.clone();
            found.push(candidate);
            let with = context.fit_model(found, &current.outliers.suspects)?;
            let linearisation = Linearisation::new(&with.fit, &with.data, context.options)?;
            let nothing = DMatrix::zeros(linearisation.len(), 0);
            Ok(Likelihood::new(&linearisation, &nothing, &Visits::of(&with.data))?.deviance)
        })
        .collect::<Result<_, DiscoverError>>()?;
    let best = (0..levels.len()).min_by(|&a, &b| deviances[a].total_cmp(&deviances[b]));
    if let Some(best) = best.map(|best| levels[best]) {
        competitors[..=best].rotate_right(1);
    }
    Ok(())
}
