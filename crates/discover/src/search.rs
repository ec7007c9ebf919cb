//! The loop's state, and the loop.

use crate::candidate::{Candidate, Change};
use crate::descend::{between_rows, descended, gaps};
use crate::diagnosis::{Refused, Stop, Untestable};
use crate::evidence::{Doubt, Evidence};
use crate::flips::NullDistribution;
use crate::observer::Begin;
use crate::refits::Refits;
use crate::rival::Rival;
use crate::scene::Scene;
use crate::screen::Screen;
use crate::so_far::SoFar;
use crate::winner::{seen_from, winner};
use crate::working::{Ground, Working};
use crate::{DiscoverError, DiscoverOptions, Family, Progress, conclude, merge, reconsider};
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
    pub refits: Option<Refits>,
    /// Candidates that passed the tests and failed as part of the present model.
    barred: Vec<Candidate>,
}

/// What the last screen said: (smallest family-wise p, gain that would have been seen).
pub(crate) type LastWord = (f64, f64);

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
        progress: &Begin<'_>,
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
            progress(Progress::Screening(self.accepted.len()))?;
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
                    progress(Progress::Reconsidering)?;
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
                progress(Progress::Reconsidering)?;
                self.revise(looked_at_again)?;
            }
            progress(Progress::SoFar(Box::new(told.after(self, whole, last)?)))?;
        }
    }

    /// Takes in the best candidate that passes all tests, also as part of the refitted model; none when there is none.
    fn next(
        &mut self,
        now: &Working,
        (scene, screen, null): (&Scene<'_>, &Screen, &NullDistribution),
        progress: &Begin<'_>,
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
            progress(Progress::Found(candidate.words()))?;
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

    pub(crate) fn refuse(&mut self, candidate: Candidate, evidence: Evidence, doubt: Doubt) {
        if !self.refused.iter().any(|r| r.candidate.same_cause(&candidate) && r.doubt == doubt) {
            self.refused.push(Refused { candidate, evidence, doubt });
        }
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
        if found.is_empty() {
            self.now = Arc::clone(&self.first);
            return Ok(());
        }
        let working = self.ground.working_from(found, &[], Some(&self.now.fit))?;
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
    pub(crate) fn take(&mut self, accepted: Accepted) -> Option<usize> {
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
            (self.now, self.refits) = (Arc::clone(&self.first), None);
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
        // What refits said was said of another model.
        (self.now, self.refits) = (Arc::new(working), None);
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
