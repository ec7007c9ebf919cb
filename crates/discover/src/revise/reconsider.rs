//! Joint reconsideration: every find has to win again with all others in the model.
//!
//! A first find that a later one explains better falls; one that is better told at another place, or in another shape, is
//! swapped. Each find is taken out in turn, what is left is screened, and the contest is held once more.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::{Evidence, collect, parametric};
use crate::accept::model::Model;
use crate::accept::winner::own_p;
use crate::contest::competition::{Contest, contest};
use crate::contest::rival::{Rival, adopted, losers, rival};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::model::current::Ground;
use crate::policy::TIE;
use crate::problem::likelihood::without as lacking;
use crate::problem::linearisation::Scene;
use crate::problem::observation::typical_sd;
use crate::screen::candidates::{Questions, Screen};
use truepose_errormodel::Visits;

/// Takes each of the first `count` findings out in turn and tests it again beside all others; true when something changed.
pub(crate) fn reconsidered(
    context: &Ground<'_>,
    mut model: Model,
    count: usize,
    asked: &Questions,
) -> Result<(Model, bool), DiscoverError> {
    let (mut at, mut iterations) = (0, 0);
    let mut moved = false;
    while at < count.min(model.findings.len()) && iterations < 2 * count {
        iterations += 1;
        let others = model.others(&[at]);
        let Defence { contest, winner, evidence } = without(context, &model, at, (&others, asked))?;
        let mut findings = model.findings.clone();
        let Some(winner) = winner.map(|k| &contest.rivals[k]) else {
            // The others explain it.
            findings.remove(at);
            model = model.refitted(context, findings)?;
            moved = true;
            continue;
        };
        let next = adopted(winner);
        let changed = !same_shape(&next, &findings[at].candidate);
        findings[at].rivals = losers(&contest.rivals, winner);
        let floor = winner.likelihood.noise.floor(typical_sd(&model.current.data));
        let doubt =
            |evidence: &Evidence| evidence.doubt(context.options.alpha, floor, next.belongs_to_time());
        match evidence {
            // Another cause has to pass the same tests as one that comes in from outside.
            Some(evidence) if doubt(&evidence).is_some() => {
                model.findings = findings;
                at += 1;
                continue;
            }
            Some(evidence) => findings[at].evidence = evidence,
            None => {}
        }
        if changed {
            findings[at].candidate = next;
            model = model.refitted(context, findings)?;
            moved = true;
        } else {
            model.findings = findings;
        }
        at += 1;
    }
    Ok((model, moved))
}

/// The contest for the place of a find, and how it ended.
struct Defence {
    contest: Contest,
    /// Number of the rival that has won; none when the others explain the find.
    winner: Option<usize>,
    /// What speaks for the winner, if it is another cause.
    evidence: Option<Evidence>,
}

/// Holds the contest for the place of a finding.
fn without(
    context: &Ground<'_>,
    model: &Model,
    at: usize,
    (others, asked): (&[Candidate], &Questions),
) -> Result<Defence, DiscoverError> {
    let Accepted { candidate, shortlist, .. } = &model.findings[at];
    let options = context.options;
    let held = |scene: &Scene<'_>| {
        let screen = Screen::again(scene, &options.without, (shortlist, others), asked);
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
        let tested = |best: &Rival| {
            // Another cause answers for itself, against the whole search.
            let p = (own_p(context, scene, others, best), parametric(&screen, best));
            collect(scene, &contest.present, best, p, options.seed)
        };
        let evidence = another.map(tested).transpose()?;
        Ok(Defence { contest, winner, evidence })
    };
    let now = &*model.current;
    // A corrected load is in the data itself.
    if !now.found[at].effects().is_empty() {
        let scene = Scene::new(&now.fit, &now.data)?;
        if let Some(scene) = lacking(scene, model.effects_of(context, at))? {
            return held(&scene);
        }
    }
    let fewer = context.working(others.to_vec(), &now.outliers.suspects)?;
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
