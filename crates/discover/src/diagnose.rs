//! The closed loop: fit, find the residual, trace it to an effect that the model lacks, add it, again.

use crate::candidate::{Candidate, Change};
use crate::contest::{Contest, contest};
use crate::descend::{between_rows, descended, gaps};
use crate::diagnosis::{Diagnosis, Refused, Stop, Untestable};
use crate::evidence::{Evidence, collect};
use crate::flips::NullDistribution;
use crate::payload::weighed;
use crate::polish::polished;
use crate::rival::{Rival, losers};
use crate::sample::sample;
use crate::scene::Scene;
use crate::screen::Screen;
use crate::so_far::SoFar;
use crate::surprise::gain_of_one;
use crate::working::{Ground, Working};
use crate::{DiscoverError, DiscoverOptions, Family, conclude, derived, merge, reconsider, wide};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::collections::BTreeMap;
use truepose_errormodel::{AnyEffect, Dataset, Visits};
use truepose_identify::{PriorStrength, hold_out, place};
use truepose_kinematics::Chain;
use truepose_solvers::Solver;

/// Where a discovery is, for a progress bar.
#[derive(Debug, Clone)]
pub enum Progress {
    /// Fitting the declared model.
    Fitting,
    /// Screening all candidates, so many effects having been found.
    Screening(usize),
    /// An effect was added.
    Found(String),
    /// What there is after each find, for whoever interrupts the loop: fitted to the training rows, without rivals.
    SoFar(Box<Diagnosis>),
    /// Looking at earlier finds again.
    Reconsidering,
    /// Judging the result on the rows that were drawn out first.
    Judging,
}

/// A find with what speaks for it and who lost against it.
pub(crate) struct Accepted {
    pub candidate: Candidate,
    pub evidence: Evidence,
    /// Who lost against it: how much less likely each makes the data (−2 ln L and what its coefficients cost), the most likely first.
    pub rivals: Vec<(Candidate, f64)>,
    /// Causes without a name that did well when it was found.
    pub shortlist: Vec<Candidate>,
}

/// Runs the closed loop.
///
/// `declared` are the effects that the user says the robot has; everything else is the residual's to show.
///
/// # Errors
/// When the model does not fit the data, nothing was measured, there are too few visits, or an option is out of its range.
pub fn diagnose(
    chain: &Chain,
    declared: &[Box<dyn AnyEffect>],
    data: &Dataset,
    solver: &dyn Solver,
    options: &DiscoverOptions,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Diagnosis, DiscoverError> {
    options.validate()?;
    // History is made on the whole record, before anything is drawn from it.
    let data = &derived::with_derived(data);
    let rows = hold_out(data, options.holdout, options.seed)?;
    on_split(chain, declared, (data, rows), solver, options, progress)
}

/// Runs the closed loop on given training rows, and judges it on the others.
pub(crate) fn on_split(
    chain: &Chain,
    declared: &[Box<dyn AnyEffect>],
    (data, (train_rows, holdout_rows)): (&Dataset, (Vec<usize>, Vec<usize>)),
    solver: &dyn Solver,
    options: &DiscoverOptions,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Diagnosis, DiscoverError> {
    let train = data.select(&train_rows);
    progress(Progress::Fitting);
    let placement = place(chain, &train)?;
    let part = sample(&train, options.seed);
    let mut ground =
        Ground { chain: &placement.chain, declared, data: &part, solver, fit: options.fit.clone() };
    let mut first = ground.working(Vec::new(), &[])?;
    let relaxed = match ground.fit.prior {
        PriorStrength::Evidence => wide::relaxed(declared, &first.fit),
        _ => None,
    };
    if let Some(relaxed) = &relaxed {
        ground.declared = relaxed;
        first = ground.working(Vec::new(), &first.outliers.suspects)?;
    }
    // How far the declared errors lie from what was expected of them is not for the finds to say.
    if ground.fit.prior == PriorStrength::Evidence {
        ground.fit.prior = PriorStrength::Fixed(first.fit.prior.kappa);
    }
    let need = 12;
    if Visits::of(&train).len() < need {
        let rank = first.fit.reduction.rank();
        return Err(DiscoverError::TooFewVisits { have: Visits::of(&train).len(), rank, need });
    }
    let mut search = Search {
        ground,
        options,
        accepted: Vec::new(),
        refused: Vec::new(),
        untestable: Vec::new(),
        asked: BTreeMap::new(),
        now: first,
    };
    let whole = conclude::Whole { data, train_rows, holdout_rows, placement: placement.clone() };
    let (stopped, last) = search.run(&whole, progress)?;
    progress(Progress::Judging);
    if part.len() < train.len() {
        // What was found in a part of the data is fitted to all of it.
        search.ground.data = &train;
        let found = search.now.found.clone();
        let working = search.ground.working_from(found, &[], Some(&search.now.fit))?;
        search.stand_on(working);
    }
    search.between_rows()?;
    conclude::conclude(search, whole, stopped, last)
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
    pub now: Working,
}

/// What the last screen said: (smallest family-wise p, gain that would have been seen).
pub(crate) type LastWord = (f64, f64);

impl Search<'_> {
    fn run(
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
            let scene = Scene::new(&self.now.fit, &self.now.data)?;
            let screen = Screen::new(&scene, &self.options.without, &self.now.found);
            self.asked.clone_from(screen.questions());
            if rounds == 1 {
                self.untestable = conclude::untestable(&scene, &screen);
            }
            let null = screen.null(self.options.flips, self.options.seed);
            let p_value = null.p_value(screen.largest());
            let last = (p_value, seen_from(&null, self.options.alpha));
            let mut stop = None;
            let mut accepted = None;
            if p_value > self.options.alpha {
                stop = Some(Stop::NothingLeft);
            } else if self.accepted.len() >= self.options.most || rounds > 2 * self.options.most {
                stop = Some(Stop::Limit);
            } else {
                let asked = (&scene, &screen, &null);
                accepted = winner(&self.ground, &self.now, asked, self.options, &mut self.refused)?;
            }
            let Some(accepted) = accepted else {
                let stop = stop.unwrap_or(Stop::NothingConvincing);
                if together_down.as_ref() != Some(&self.finds()) {
                    together_down = Some(self.finds());
                    if self.descend()? {
                        continue;
                    }
                }
                if looked_again || self.accepted.len() <= FEW {
                    return Ok((stop, last));
                }
                // Once, at the end: if that changes something, there may be more to find.
                looked_again = true;
                progress(Progress::Reconsidering);
                if !reconsider::reconsider(self, self.accepted.len())? {
                    return Ok((stop, last));
                }
                continue;
            };
            progress(Progress::Found(accepted.candidate.words()));
            let taken = self.take(accepted);
            self.refit()?;
            if let Some(better) = polished(&self.ground, &self.now, taken)? {
                self.accepted[taken].candidate = better;
                self.refit()?;
            }
            circling |= together.contains(&self.finds());
            if self.accepted.len() <= FEW && !circling {
                together.push(self.finds());
                progress(Progress::Reconsidering);
                // The last one has just won.
                if reconsider::reconsider(self, self.accepted.len() - 1)? {
                    // It won against others than those that are there now.
                    reconsider::reconsider(self, self.accepted.len())?;
                }
                if !self.accepted.is_empty() && merge::merge(self, self.accepted.len() - 1)? {
                    reconsider::reconsider(self, self.accepted.len())?;
                }
            }
            progress(Progress::SoFar(Box::new(told.after(self, whole, last)?)));
        }
    }

    /// What was found, in any order, and of how many effects each is.
    fn finds(&self) -> Vec<(String, usize)> {
        let of = |a: &Accepted| (a.candidate.words(), a.candidate.effects().len());
        let mut finds: Vec<_> = self.accepted.iter().map(of).collect();
        finds.sort();
        finds
    }

    /// Takes a find in; more of a cause that is known (further periods of one gear) goes to the find that it belongs to. Returns the
    /// find's number.
    fn take(&mut self, accepted: Accepted) -> usize {
        let known = self.accepted.iter().position(|a| a.candidate.same_cause(&accepted.candidate));
        if let Some(known) = known
            && let (Change::Add(effects), Change::Add(more)) =
                (&mut self.accepted[known].candidate.change, &accepted.candidate.change)
        {
            effects.extend(more.iter().cloned());
            return known;
        }
        self.accepted.push(accepted);
        self.accepted.len() - 1
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
    fn between_rows(&mut self) -> Result<(), DiscoverError> {
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
        self.now = working;
    }
}

/// The best rival that passes all tests; those that fail are noted and the next one is asked.
fn winner(
    ground: &Ground<'_>,
    now: &Working,
    (scene, screen, null): (&Scene<'_>, &Screen, &NullDistribution),
    options: &DiscoverOptions,
    refused: &mut Vec<Refused>,
) -> Result<Option<Accepted>, DiscoverError> {
    /// Contests that may end without a winner before nobody is asked any more, and how many of each contest are asked.
    const CONTESTS: usize = 4;
    const ASKED: usize = 2;
    let mut barred: Vec<Candidate> = Vec::new();
    for _ in 0..CONTESTS {
        let Contest { present, mut rivals } = contest(scene, screen, &barred, true)?;
        weighed(ground, now, &mut rivals)?;
        if rivals.is_empty() {
            return Ok(None);
        }
        for (k, best) in rivals.iter().enumerate().take(ASKED) {
            let p = (null.p_value(best.surprise), parametric(screen, best));
            let evidence = collect(scene, &present, best, p, options.seed)?;
            let floor = best.likelihood.noise.floor(f64::NAN);
            let doubt = if best.score >= present.deviance {
                Some(crate::evidence::Doubt::TooSmall)
            } else {
                evidence.doubt(options.alpha, floor, best.candidate.family.belongs_to_time())
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
    let asked: usize = screen.candidates.iter().filter(|s| s.score.is_some()).count();
    let law = ChiSquared::new(rival.freedom as f64);
    let single = law.map_or(1.0, |law| law.sf(rival.gain.max(0.0)));
    (single * asked.max(1) as f64).min(1.0)
}

/// The gain of a single unknown that would have passed as no chance.
fn seen_from(null: &NullDistribution, alpha: f64) -> f64 {
    gain_of_one(null.critical(alpha))
}
