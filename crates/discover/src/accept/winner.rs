//! Selection: the best candidate of a screen that passes all tests of the linearised problem.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::{Doubt, Refused, collect, parametric};
use crate::contest::competition::{Contest, contest};
use crate::contest::competitor::{Competitor, outcompeted, with_estimates};
use crate::contest::payload::order_payloads;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::current::{Context, ModelFit};
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;
use crate::significance::sign_flips::NullDistribution;
use crate::statistics::chi_square::gain_of_one;

/// The best competitor that passes all tests; those that fail are added to `refused`, and the next one is
/// tested. `current` is the present model.
pub(crate) fn winner(
    context: &Context<'_>,
    current: &ModelFit,
    (linearisation, screen, null): (&Linearisation<'_>, &Screen, &NullDistribution),
    barred: &[Candidate],
    refused: &mut Vec<Refused>,
) -> Result<Option<Accepted>, DiscoverError> {
    let options = context.options;
    let mut barred: Vec<Candidate> = barred.to_vec();
    for _ in 0..context.budget().contests {
        let Contest { present, mut competitors } = contest(linearisation, screen, &barred, true)?;
        order_payloads(context, current, &mut competitors)?;
        if competitors.is_empty() {
            return Ok(None);
        }
        for (k, best) in competitors.iter().enumerate().take(context.budget().tested) {
            let p = (null.p_value(best.surprisal), parametric(screen, best));
            let evidence = collect(linearisation, &present, best, p, options.seed)?;
            let floor = best.likelihood.noise.floor(linearisation.typical_sd());
            let doubt = if best.score >= present.deviance {
                Some(Doubt::TooSmall)
            } else {
                evidence.doubt((&options.policy, options.alpha), floor, best.candidate.follows_time())
            };
            let Some(doubt) = doubt else {
                return Ok(Some(Accepted {
                    candidate: with_estimates(best),
                    evidence,
                    competitors: outcompeted(&competitors[k + 1..], best, &options.policy),
                    shortlist: screen.shortlist(linearisation),
                }));
            };
            Refused { candidate: best.candidate.clone(), evidence, doubt }.note_in(refused);
            barred.push(best.candidate.clone());
        }
    }
    Ok(None)
}

/// Score statistic with one degree of freedom that is significant at `alpha`.
pub(crate) fn detectable_statistic(null: &NullDistribution, alpha: f64) -> f64 {
    gain_of_one(null.critical(alpha))
}

/// Family-wise p-value of a candidate in place of a finding: `linearisation` is the model without that
/// finding, `others` are the other findings. The null distribution is that of a full screen of this model.
pub(crate) fn family_wise_p(
    context: &Context<'_>,
    linearisation: &Linearisation<'_>,
    others: &[Candidate],
    competitor: &Competitor,
) -> f64 {
    let options = context.options;
    let screen = Screen::new(linearisation, &options.library, others);
    screen.null(options.flips, options.seed).p_value(competitor.surprisal)
}
