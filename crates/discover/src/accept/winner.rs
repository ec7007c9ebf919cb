//! Selection: the best candidate of a screen that passes all tests of the linearised problem.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::{Doubt, Refused, collect};
use crate::contest::competition::{Contest, Contests};
use crate::contest::competitor::{Competitor, outcompeted, with_estimates};
use crate::contest::names::{doubted, name_probabilities};
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
    let mut contests = Contests::new(linearisation, screen, true)?;
    for _ in 0..context.budget().contests {
        let Contest { present, mut competitors } = contests.without(&barred)?;
        order_payloads(context, current, &mut competitors)?;
        if competitors.is_empty() {
            return Ok(None);
        }
        // One that passed, while a name that is more probable beside the surrogates of its channel is still to be tested.
        let mut passed: Option<(&Competitor, Accepted)> = None;
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
                let among_surrogates = evidence.p_surrogates;
                let mut others = outcompeted(&competitors[k + 1..], best, &options.policy);
                if let Some((first, earlier)) = &passed {
                    let doubtful = outcompeted([*first], best, &options.policy).into_iter();
                    let p = earlier.evidence.p_surrogates;
                    others.extend(doubtful.map(|(c, behind)| (c, doubted(behind, p, &options.policy))));
                    others.sort_by(|a, b| a.1.total_cmp(&b.1));
                }
                let accepted = Accepted {
                    candidate: with_estimates(best),
                    evidence,
                    competitors: others,
                    shortlist: contests.shortlist(),
                    instead: Vec::new(),
                };
                if passed.is_some() || !likelier(&accepted, among_surrogates, linearisation) {
                    return Ok(Some(accepted));
                }
                passed = Some((best, accepted));
                continue;
            };
            if passed.is_some() {
                continue;
            }
            Refused { candidate: best.candidate.clone(), evidence, doubt }.note_in(refused);
            barred.push(best.candidate.clone());
        }
        if let Some((_, passed)) = passed {
            return Ok(Some(passed));
        }
    }
    Ok(None)
}

/// Whether the name of a finding is less probable than that of a competing hypothesis, once its channel was held against its surrogates.
/// What reads the order of the poses is none: later poses have the channel.
fn likelier(accepted: &Accepted, among_surrogates: Option<f64>, linearisation: &Linearisation<'_>) -> bool {
    let (data, policy) = (linearisation.data, linearisation.policy);
    let names = name_probabilities((&accepted.candidate, among_surrogates), &accepted.competitors, policy);
    let of_use = |c: &Candidate| c.family.is_named() && !c.is_of_order(data);
    let named = accepted.competitors.iter().zip(&names.each).filter(|((c, _), _)| of_use(c));
    among_surrogates.is_some() && named.map(|(_, p)| *p).fold(0.0, f64::max) > names.own
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
