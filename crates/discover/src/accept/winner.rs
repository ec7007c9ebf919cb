//! Who wins a screen: the best candidate that passes all tests of the linearised problem.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::{Doubt, Refused, collect, parametric};
use crate::contest::competition::{Contest, contest};
use crate::contest::payload::weighed;
use crate::contest::rival::{Rival, adopted, losers};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::current::{Ground, Working};
use crate::problem::linearisation::Scene;
use crate::screen::candidates::Screen;
use crate::significance::sign_flips::NullDistribution;
use crate::statistics::chi_square::gain_of_one;

/// The best rival that passes all tests; those that fail are noted and the next one is asked.
pub(crate) fn winner(
    ground: &Ground<'_>,
    now: &Working,
    (scene, screen, null): (&Scene<'_>, &Screen, &NullDistribution),
    barred: &[Candidate],
    refused: &mut Vec<Refused>,
) -> Result<Option<Accepted>, DiscoverError> {
    /// Contests that may end without a winner before nobody is asked any more, and how many of each contest are asked.
    const CONTESTS: usize = 4;
    const ASKED: usize = 2;
    let options = ground.options;
    let mut barred: Vec<Candidate> = barred.to_vec();
    for _ in 0..CONTESTS {
        let Contest { present, mut rivals } = contest(scene, screen, &barred, true)?;
        weighed(ground, now, &mut rivals)?;
        if rivals.is_empty() {
            return Ok(None);
        }
        for (k, best) in rivals.iter().enumerate().take(ASKED) {
            let p = (null.p_value(best.surprise), parametric(screen, best));
            let evidence = collect(scene, &present, best, p, options.seed)?;
            let floor = best.likelihood.noise.floor(scene.typical_sd());
            let doubt = if best.score >= present.deviance {
                Some(Doubt::TooSmall)
            } else {
                evidence.doubt(options.alpha, floor, best.candidate.belongs_to_time())
            };
            let Some(doubt) = doubt else {
                return Ok(Some(Accepted {
                    candidate: adopted(best),
                    evidence,
                    rivals: losers(&rivals[k + 1..], best),
                    shortlist: screen.shortlist(scene),
                }));
            };
            Refused { candidate: best.candidate.clone(), evidence, doubt }.note_in(refused);
            barred.push(best.candidate.clone());
        }
    }
    Ok(None)
}

/// The gain of a single unknown that would have passed as no chance.
pub(crate) fn seen_from(null: &NullDistribution, alpha: f64) -> f64 {
    gain_of_one(null.critical(alpha))
}

/// Family-wise p of a candidate for the place of a finding: `scene` is the model without that finding, `others` are the other findings.
pub(crate) fn own_p(context: &Ground<'_>, scene: &Scene<'_>, others: &[Candidate], rival: &Rival) -> f64 {
    let options = context.options;
    let screen = Screen::new(scene, &options.without, others);
    screen.null(options.flips, options.seed).p_value(rival.surprise)
}
