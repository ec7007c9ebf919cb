//! Selection: the best candidate of a screen that passes all tests of the linearised problem.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::{Doubt, Refused, collect};
use crate::contest::competition::{Contest, contest};
use crate::contest::competitor::{Competitor, outcompeted, with_estimates};
use crate::contest::payload::order_payloads;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::current::{Context, ModelFit};
use crate::problem::dependence::BesideWander;
use crate::problem::linearisation::Linearisation;
use crate::problem::projection::Projection;
use crate::screen::candidates::Screen;
use crate::significance::rotation::NullDistribution;

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
    let wander = BesideWander::of(linearisation, options.seed);
    for _ in 0..context.budget().contests {
        let Contest { present, mut competitors } = contest(linearisation, screen, &barred, true)?;
        order_payloads(context, current, &mut competitors)?;
        if competitors.is_empty() {
            return Ok(None);
        }
        for (k, best) in competitors.iter().enumerate().take(context.budget().tested) {
            let p = own_p_value(linearisation, null, best, options.alpha);
            let evidence = collect((linearisation, &wander), (screen, &present), best, p, options)?;
            let floor = linearisation.floor(best.likelihood.noise);
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

/// Family-wise p of a competitor. Where it is above α under the noise of the present model, which has the effect in its residual, the noise
/// is that of the model with the competitor: a second test, in favour of the competitor, whose p counts [`crate::policy::Policy::second_look_tests`] times.
fn own_p_value(
    linearisation: &Linearisation<'_>,
    null: &NullDistribution,
    competitor: &Competitor,
    alpha: f64,
) -> f64 {
    let p = null.p_value(competitor.surprisal);
    if p <= alpha {
        return p;
    }
    let again = Projection::under(linearisation, competitor.likelihood.noise);
    let surprisal = again.judge(linearisation, &competitor.candidate).map_or(0.0, |score| score.surprisal);
    p.min(linearisation.policy.second_look_tests * null.p_value(surprisal))
}
