//! Joint reconsideration: every find has to win again with all others in the model.
//!
//! A first find that a later one explains better falls; one that is better told at another place, or in another shape, is
//! swapped. Each find is taken out in turn, what is left is screened, and the contest is held once more.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::{Evidence, collect, parametric};
use crate::contest::competition::{Contest, contest};
use crate::contest::rival::{Rival, adopted, losers, rival};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::policy::TIE;
use crate::problem::likelihood::without as lacking;
use crate::problem::linearisation::Scene;
use crate::problem::observation::typical_sd;
use crate::screen::candidates::Screen;
use crate::search::Search;
use truepose_errormodel::Visits;

/// Takes each of the first `count` finds out in turn and lets it defend its place; true when something changed.
pub(crate) fn reconsider(search: &mut Search<'_>, count: usize) -> Result<bool, DiscoverError> {
    let (mut at, mut rounds) = (0, 0);
    let mut moved = false;
    while at < count.min(search.accepted.len()) && rounds < 2 * count {
        rounds += 1;
        let others: Vec<Candidate> = search
            .accepted
            .iter()
            .enumerate()
            .filter(|(k, _)| *k != at)
            .map(|(_, a)| a.candidate.clone())
            .collect();
        let Defence { contest, winner, evidence } = without(search, at, &others)?;
        let Some(winner) = winner.map(|k| &contest.rivals[k]) else {
            // The others explain it.
            search.accepted.remove(at);
            search.refit()?;
            moved = true;
            continue;
        };
        let mine = &search.accepted[at].candidate;
        let next = adopted(winner);
        let rivals = losers(&contest.rivals, winner);
        let changed = !same_shape(&next, mine);
        search.accepted[at].rivals = rivals;
        if let Some(evidence) = evidence {
            // Another cause has to answer the same questions as whoever comes in from outside.
            let floor = winner.likelihood.noise.floor(typical_sd(&search.now.data));
            if evidence.doubt(search.options.alpha, floor, next.belongs_to_time()).is_some() {
                at += 1;
                continue;
            }
            search.accepted[at].evidence = evidence;
        }
        if changed {
            search.accepted[at].candidate = next;
            search.refit()?;
            moved = true;
        }
        at += 1;
    }
    Ok(moved)
}

/// The contest for the place of a find, and how it ended.
struct Defence {
    contest: Contest,
    /// Number of the rival that has won; none when the others explain the find.
    winner: Option<usize>,
    /// What speaks for the winner, if it is another cause.
    evidence: Option<Evidence>,
}

/// Holds the contest for the place of a find.
fn without(search: &Search<'_>, at: usize, others: &[Candidate]) -> Result<Defence, DiscoverError> {
    let Accepted { candidate, shortlist, .. } = &search.accepted[at];
    let held = |scene: &Scene<'_>| {
        let screen = Screen::again(scene, &search.options.without, (shortlist, others), &search.asked);
        // The periods of a gear were found while less was known: it may look for them again.
        let mut contest = contest(scene, &screen, others, candidate.family == Family::Transmission)?;
        // The find as it stands defends its place, and its shape.
        if let Some(own) = rival(scene, &screen, &Visits::of(scene.data), candidate.clone())? {
            let same = contest.rivals.iter().position(|r| r.candidate.same_cause(candidate));
            match same {
                Some(k) if contest.rivals[k].score < own.score => {}
                Some(k) => contest.rivals[k] = own,
                None => contest.rivals.push(own),
            }
        }
        let winner = winner(&contest, candidate);
        let another = winner.map(|k| &contest.rivals[k]).filter(|r| !r.candidate.same_cause(candidate));
        let asked = |best: &Rival| {
            // Another cause answers for itself, against the whole search.
            let p = (search.own_p(scene, others, best), parametric(&screen, best));
            collect(scene, &contest.present, best, p, search.options.seed)
        };
        let evidence = another.map(asked).transpose()?;
        Ok(Defence { contest, winner, evidence })
    };
    let Search { ground, now, .. } = search;
    // A corrected load is in the data itself.
    if !now.found[at].effects().is_empty() {
        let scene = Scene::new(&now.fit, &now.data)?;
        if let Some(scene) = lacking(scene, ground.effects_of(&now.found, at))? {
            return held(&scene);
        }
    }
    let fewer = ground.working(others.to_vec(), &now.outliers.suspects)?;
    held(&Scene::new(&fewer.fit, &fewer.data)?)
}

/// Who wins: another cause has to be clearly better, the same cause may change its shape. None when nobody is worth its unknowns.
fn winner(contest: &Contest, mine: &Candidate) -> Option<usize> {
    let rivals = &contest.rivals;
    let worth = |&k: &usize| rivals[k].score < contest.present.deviance;
    let still = rivals.iter().position(|r| r.candidate.same_cause(mine));
    let best = Some(0).filter(|_| !rivals.is_empty()).filter(worth).or(still.filter(worth))?;
    Some(still.filter(|&k| rivals[k].score < rivals[best].score + TIE).unwrap_or(best))
}

/// Whether both change the model in the same way.
fn same_shape(a: &Candidate, b: &Candidate) -> bool {
    let parameters = |c: &Candidate| -> Vec<_> {
        c.effects().iter().map(|e| (e.kind(), e.parameters().to_string())).collect()
    };
    a.same_cause(b) && parameters(a) == parameters(b)
}
