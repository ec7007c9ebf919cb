//! The loop's state, and the loop.

use crate::admissible::{Objection, objection};
use crate::candidate::{Candidate, Change};
use crate::contest::{Contest, contest};
use crate::descend::{between_rows, descended, gaps};
use crate::diagnosis::{Refused, Stop, Untestable};
use crate::evidence::{Doubt, Evidence, collect};
use crate::flips::NullDistribution;
use crate::payload::weighed;
use crate::polish::polished;
use crate::refits::{Refits, compared};
use crate::rival::{Rival, losers};
use crate::scene::Scene;
use crate::screen::Screen;
use crate::so_far::SoFar;
use crate::surprise::gain_of_one;
use crate::working::{Ground, Working};
use crate::{DiscoverError, DiscoverOptions, Family, Progress, conclude, merge, reconsider};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::collections::BTreeMap;
use std::sync::Arc;
use truepose_errormodel::Dataset;
use truepose_identify::Residuals;

/// A find with what speaks for it and who lost against it.
#[derive(Debug, Clone)]
pub(crate) struct Accepted {
    pub candidate: Candidate,
    pub evidence: Evidence,
    /// Who lost against it: how much less likely each makes the data (−2 ln L and what its coefficients cost), the most likely first.
    pub rivals: Vec<(Candidate, f64)>,
    /// Causes without a name that did well when it was found.
    pub shortlist: Vec<Candidate>,
}

/// The loop's state.
pub(crate) struct Search<'a> {
    pub ground: Ground<'a>,
    pub options: &'a DiscoverOptions,
    pub accepted: Vec<Accepted>,
    pub refused: Vec<Refused>,
    /// Causes that this data cannot test on top of the declared model.
    pub untestable: Vec<Untestable>,
    /// How many questions the last whole screen asked of each family.
    pub asked: BTreeMap<Family, usize>,
    pub now: Arc<Working>,
    /// The declared model.
    pub first: Arc<Working>,
    /// How the present model predicts what its refits have not seen, once that was asked.
    refits: Option<Refits>,
    /// Candidates that passed the tests and failed as part of the present model.
    barred: Vec<Candidate>,
}

/// What the last screen said: (smallest family-wise p, gain that would have been seen).
pub(crate) type LastWord = (f64, f64);

/// What a change of the model can be taken back to.
struct Checkpoint {
    accepted: Vec<Accepted>,
    now: Arc<Working>,
    refits: Option<Refits>,
}

impl<'a> Search<'a> {
    /// Before anything was found.
    pub fn new(ground: Ground<'a>, options: &'a DiscoverOptions, first: Working) -> Self {
        let first = Arc::new(first);
        Search {
            ground,
            options,
            accepted: Vec::new(),
            refused: Vec::new(),
            untestable: Vec::new(),
            asked: BTreeMap::new(),
            now: Arc::clone(&first),
            first,
            refits: None,
            barred: Vec::new(),
        }
    }

    /// Adds effects until none is left that passes all tests.
    pub fn run(
        &mut self,
        whole: &conclude::Whole<'_>,
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Result<(Stop, LastWord), DiscoverError> {
        /// With more finds than this they are looked at again only at the end.
        const FEW: usize = 4;
        let mut looked_again = false;
        // Finds whose shapes went down together.
        let mut together_down: Option<Vec<(String, usize)>> = None;
        // Finds that were together before: what takes one out again only for it to come back goes round in circles.
        let mut together: Vec<Vec<(String, usize)>> = Vec::new();
        let mut circling = false;
        let mut rounds = 0;
        let mut told = SoFar::new(&self.now, whole)?;
        loop {
            rounds += 1;
            progress(Progress::Screening(self.accepted.len()));
            let now = Arc::clone(&self.now);
            let scene = Scene::new(&now.fit, &now.data)?;
            let screen = Screen::new(&scene, &self.options.without, &now.found);
            self.asked.clone_from(screen.questions());
            if rounds == 1 {
                self.untestable = conclude::untestable(&scene, &screen);
            }
            let null = screen.null(self.options.flips, self.options.seed);
            let p_value = null.p_value(screen.largest());
            let last = (p_value, seen_from(&null, self.options.alpha));
            let mut stop = None;
            let mut admitted = None;
            if p_value > self.options.alpha {
                stop = Some(Stop::NothingLeft);
            } else if self.accepted.len() >= self.options.most {
                stop = Some(Stop::Limit);
            } else if rounds > 2 * self.options.most {
                stop = Some(Stop::Circling);
            } else {
                admitted = self.next(&now, (&scene, &screen, &null), progress)?;
            }
            if admitted.is_none() {
                let stop = stop.unwrap_or(Stop::NothingConvincing);
                if together_down.as_ref() != Some(&self.finds()) {
                    together_down = Some(self.finds());
                    if self.revise(Self::descend)? {
                        continue;
                    }
                }
                if !looked_again && self.accepted.len() > FEW {
                    // Once, at the end: if that changes something, there may be more to find.
                    looked_again = true;
                    progress(Progress::Reconsidering);
                    let count = self.accepted.len();
                    if self.revise(|search| reconsider::reconsider(search, count))? {
                        continue;
                    }
                }
                self.sift()?;
                return Ok((stop, last));
            }
            circling |= together.contains(&self.finds());
            if self.accepted.len() <= FEW && !circling {
                together.push(self.finds());
                progress(Progress::Reconsidering);
                self.revise(looked_at_again)?;
            }
            progress(Progress::SoFar(Box::new(told.after(self, whole, last)?)));
        }
    }

    /// Takes in the best candidate that passes all tests, also as part of the refitted model; none when there is none.
    fn next(
        &mut self,
        now: &Working,
        (scene, screen, null): (&Scene<'_>, &Screen, &NullDistribution),
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Result<Option<()>, DiscoverError> {
        /// Candidates that may fail as part of the model before nobody is asked any more.
        const FAILURES: usize = 3;
        for _ in 0..FAILURES {
            let barred = self.barred.clone();
            let asked = (scene, screen, null);
            let Some(accepted) = winner(&self.ground, now, asked, self.options, &barred, &mut self.refused)?
            else {
                return Ok(None);
            };
            let candidate = accepted.candidate.clone();
            progress(Progress::Found(candidate.words()));
            let evidence = accepted.evidence.clone();
            let Some(doubt) = self.admit(accepted)? else {
                self.barred.clear();
                return Ok(Some(()));
            };
            self.refuse(candidate.clone(), evidence, doubt);
            self.barred.push(candidate);
        }
        Ok(None)
    }

    /// Takes a candidate into the model, refits it, and takes it out again when that makes the model worse; why, if it does.
    fn admit(&mut self, accepted: Accepted) -> Result<Option<Doubt>, DiscoverError> {
        let before = self.checkpoint();
        let Some(taken) = self.take(accepted) else {
            return Ok(Some(Doubt::NothingNew));
        };
        self.refit()?;
        if let Some(better) = polished(&self.ground, &self.now, taken)? {
            self.accepted[taken].candidate = better;
            self.refit()?;
        }
        let objection = objection(&self.now.fit, &self.now.found[taken], self.effects_of(taken));
        let doubt = match objection {
            Some(objection) => Some(doubt_of(objection)),
            None => self.worse_than(&before, true)?,
        };
        if doubt.is_some() {
            self.restore(before);
        }
        Ok(doubt)
    }

    /// Changes the findings, and takes the change back when it makes the model worse; whether it was kept.
    fn revise(
        &mut self,
        change: impl FnOnce(&mut Self) -> Result<bool, DiscoverError>,
    ) -> Result<bool, DiscoverError> {
        let before = self.checkpoint();
        if !change(self)? {
            return Ok(false);
        }
        if self.worse_than(&before, false)?.is_some() {
            self.restore(before);
            return Ok(false);
        }
        Ok(true)
    }

    /// What speaks against the present model beside an earlier one. An effect that is added has to predict unseen poses better; a revision,
    /// which may also make the model simpler, not worse by more than what counts.
    fn worse_than(&mut self, before: &Checkpoint, gains: bool) -> Result<Option<Doubt>, DiscoverError> {
        /// A training error may grow by so little where the noise of rows and poses is shared out anew.
        const GROWTH: f64 = 1.01;
        let fit = &self.now.fit;
        if before.now.fit.converged && !fit.converged {
            return Ok(Some(Doubt::NotConverged));
        }
        let trained = compared(&before.now.fit.residuals, &fit.residuals, before.now.fit.noise);
        if gains && trained.is_some_and(|trained| trained.position > GROWTH && trained.deviation > 1.0) {
            return Ok(Some(Doubt::WorseFit));
        }
        let seed = self.options.seed;
        let earlier = match &before.refits {
            Some(refits) => refits.clone(),
            None => self.ground.refits(&before.now, seed)?,
        };
        let refits = self.ground.refits(&self.now, seed)?;
        let unseen = compared(&earlier.residuals, &refits.residuals, before.now.fit.noise);
        let worse = unseen.is_none_or(|unseen| if gains { unseen.is_no_gain() } else { unseen.is_loss() });
        if worse || (earlier.converged && !refits.converged) {
            return Ok(Some(Doubt::WorseUnseen));
        }
        self.refits = Some(refits);
        Ok(None)
    }

    /// Drops findings that, with all others in the model, are no longer significant or physical.
    fn sift(&mut self) -> Result<(), DiscoverError> {
        let mut at = 0;
        while at < self.accepted.len() {
            let Some(objection) = objection(&self.now.fit, &self.now.found[at], self.effects_of(at)) else {
                at += 1;
                continue;
            };
            let Accepted { candidate, evidence, .. } = self.accepted.remove(at);
            self.refuse(candidate, evidence, doubt_of(objection));
            self.refit()?;
            at = 0;
        }
        Ok(())
    }

    fn refuse(&mut self, candidate: Candidate, evidence: Evidence, doubt: Doubt) {
        if !self.refused.iter().any(|r| r.candidate.same_cause(&candidate) && r.doubt == doubt) {
            self.refused.push(Refused { candidate, evidence, doubt });
        }
    }

    fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            accepted: self.accepted.clone(),
            now: Arc::clone(&self.now),
            refits: self.refits.clone(),
        }
    }

    fn restore(&mut self, to: Checkpoint) {
        (self.accepted, self.now, self.refits) = (to.accepted, to.now, to.refits);
    }

    /// Family-wise p of a rival for the place of a finding: `scene` is the model without it, `others` are the other findings.
    pub fn own_p(&self, scene: &Scene<'_>, others: &[Candidate], rival: &Rival) -> f64 {
        let screen = Screen::new(scene, &self.options.without, others);
        screen.null(self.options.flips, self.options.seed).p_value(rival.surprise)
    }

    /// The declared model and the present one on the training rows, each row by a refit without its fold.
    pub fn both_refitted(&self) -> Result<[Residuals; 2], DiscoverError> {
        let seed = self.options.seed;
        let first = self.ground.refits(&self.first, seed)?.residuals;
        let now = match &self.refits {
            Some(refits) if refits.residuals.position.len() == first.position.len() => refits.clone(),
            _ => self.ground.refits(&self.now, seed)?,
        };
        Ok([first, now.residuals])
    }

    /// Back to the declared model: all findings, with what spoke for them.
    pub fn withdraw(&mut self) -> Vec<Accepted> {
        self.now = Arc::clone(&self.first);
        self.refits = None;
        std::mem::take(&mut self.accepted)
    }

    /// What was found in a part of the data, fitted to all of it; the declared model as well.
    pub fn go_over_to(&mut self, data: &'a Dataset) -> Result<(), DiscoverError> {
        self.ground.data = data;
        self.refits = None;
        let first = self.ground.working_from(Vec::new(), &[], Some(&self.first.fit))?;
        self.first = Arc::new(first);
        let found = self.now.found.clone();
        let working = match found.is_empty() {
            true => return Ok(self.now = Arc::clone(&self.first)),
            false => self.ground.working_from(found, &[], Some(&self.now.fit))?,
        };
        self.stand_on(working);
        Ok(())
    }

    /// The effects of the model that belong to a finding.
    pub fn effects_of(&self, which: usize) -> std::ops::Range<usize> {
        self.ground.effects_of(&self.now.found, which)
    }

    /// What was found, in any order, and of how many effects each is.
    fn finds(&self) -> Vec<(String, usize)> {
        let of = |a: &Accepted| (a.candidate.words(), a.candidate.effects().len());
        let mut finds: Vec<_> = self.accepted.iter().map(of).collect();
        finds.sort();
        finds
    }

    /// Takes a find in; more of a cause that is known (further periods of one gear) goes to the find that it belongs to. Returns the
    /// find's number; none when the model has it already.
    fn take(&mut self, accepted: Accepted) -> Option<usize> {
        let known = self.accepted.iter().position(|a| a.candidate.same_cause(&accepted.candidate));
        if let Some(known) = known
            && let (Change::Add(effects), Change::Add(more)) =
                (&mut self.accepted[known].candidate.change, &accepted.candidate.change)
        {
            let has = |effect: &dyn truepose_errormodel::AnyEffect| {
                effects.iter().any(|e| e.kind() == effect.kind() && e.parameters() == effect.parameters())
            };
            let new: Vec<_> = more.iter().filter(|effect| !has(&***effect)).cloned().collect();
            if new.is_empty() {
                return None;
            }
            effects.extend(new);
            return Some(known);
        }
        self.accepted.push(accepted);
        Some(self.accepted.len() - 1)
    }

    /// Lets the shapes of all finds go down together; true when something moved.
    fn descend(&mut self) -> Result<bool, DiscoverError> {
        let Some(next) = descended(&self.ground, &self.now.found, &self.now.fit, &self.now.data)? else {
            return Ok(false);
        };
        self.accepted.iter_mut().zip(next).for_each(|(accepted, next)| accepted.candidate = next);
        self.refit()?;
        Ok(true)
    }

    /// What jumped did so between two rows, one does not know when.
    pub fn between_rows(&mut self) -> Result<(), DiscoverError> {
        let next = between_rows(&self.now.found, self.ground.data);
        if next.iter().all(|found| gaps(found).is_empty()) {
            return Ok(());
        }
        self.accepted.iter_mut().zip(next).for_each(|(accepted, next)| accepted.candidate = next);
        self.refit()
    }

    /// Fits the model with everything that was accepted.
    pub fn refit(&mut self) -> Result<(), DiscoverError> {
        let found: Vec<Candidate> = self.accepted.iter().map(|a| a.candidate.clone()).collect();
        if found.is_empty() {
            self.now = Arc::clone(&self.first);
            return Ok(());
        }
        let working = self.ground.working(found, &self.now.outliers.suspects)?;
        self.stand_on(working);
        Ok(())
    }

    /// Goes on from this model.
    fn stand_on(&mut self, working: Working) {
        // Loads move while the model is fitted.
        for (accepted, found) in self.accepted.iter_mut().zip(&working.found) {
            accepted.candidate = found.clone();
        }
        self.now = Arc::new(working);
    }
}

/// Every finding defends its place, and two that one cause explains are merged; whether anything changed.
fn looked_at_again(search: &mut Search<'_>) -> Result<bool, DiscoverError> {
    // The last one has just won.
    let mut changed = reconsider::reconsider(search, search.accepted.len() - 1)?;
    if changed {
        // It won against others than those that are there now.
        reconsider::reconsider(search, search.accepted.len())?;
    }
    if !search.accepted.is_empty() && merge::merge(search, search.accepted.len() - 1)? {
        reconsider::reconsider(search, search.accepted.len())?;
        changed = true;
    }
    Ok(changed)
}

fn doubt_of(objection: Objection) -> Doubt {
    match objection {
        Objection::NotSignificant => Doubt::NotSignificant,
        Objection::NotPhysical => Doubt::NotPhysical,
    }
}

/// The best rival that passes all tests; those that fail are noted and the next one is asked.
fn winner(
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
fn seen_from(null: &NullDistribution, alpha: f64) -> f64 {
    gain_of_one(null.critical(alpha))
}
