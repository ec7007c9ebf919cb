//! Who wins a screen: the best candidate that passes all tests of the linearised problem.

use crate::DiscoverError;
use crate::candidate::{Candidate, Change};
use crate::contest::{Contest, contest};
use crate::diagnosis::Refused;
use crate::evidence::{Doubt, collect};
use crate::flips::NullDistribution;
use crate::options::DiscoverOptions;
use crate::payload::weighed;
use crate::rival::{Rival, losers};
use crate::scene::Scene;
use crate::screen::Screen;
use crate::search::Accepted;
use crate::surprise::gain_of_one;
use crate::working::{Ground, Working};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// The best rival that passes all tests; those that fail are noted and the next one is asked.
pub(crate) fn winner(
    ground: &Ground<'_>,
    now: &Working,
    (scene, screen, null): (&Scene<'_>, &Screen, &NullDistribution),
    options: &DiscoverOptions,
    barred: &[Candidate],
    refused: &mut Vec<Refused>,
) -> Result<Option<Accepted>, DiscoverError> {
    /// Contests that may end without a winner before nobody is asked any more, and how many of each contest are asked.
    const CONTESTS: usize = 4;
    const ASKED: usize = 2;
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
            if !refused.iter().any(|r| r.candidate.same_cause(&best.candidate) && r.doubt == doubt) {
                refused.push(Refused { candidate: best.candidate.clone(), evidence, doubt });
            }
            barred.push(best.candidate.clone());
        }
    }
    Ok(None)
}

/// The candidate with what the contest found out about its change.
pub(crate) fn adopted(rival: &Rival) -> Candidate {
    let mut candidate = rival.candidate.clone();
    candidate.width = Some(rival.within());
    if let Change::CorrectLoad { mass, .. } = &mut candidate.change {
        *mass = (*mass + rival.likelihood.coefficients[0]).max(0.0);
    }
    candidate
}

/// The parametric p of a rival, times the number of questions asked.
pub(crate) fn parametric(screen: &Screen, rival: &Rival) -> f64 {
    let asked = screen.tests();
    let law = ChiSquared::new(rival.freedom as f64);
    let single = law.map_or(1.0, |law| law.sf(rival.gain.max(0.0)));
    (single * asked.max(1) as f64).min(1.0)
}

/// The gain of a single unknown that would have passed as no chance.
pub(crate) fn seen_from(null: &NullDistribution, alpha: f64) -> f64 {
    gain_of_one(null.critical(alpha))
}
