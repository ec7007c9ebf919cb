//! Comparison of the best candidates of a screen, each with its nonlinear parameters optimised and its noise
//! estimated.
//!
//! The smallest score ([`crate::contest::competitor`]) wins; of the competitors whose scores are not
//! distinguishable from it, the one whose name is the most probable ([`crate::contest::names`]).

use crate::contest::competitor::{Competitor, competitor, plausible};
use crate::contest::look_ahead;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::policy::{Policy, penalty_per_coefficient};
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Linearisation;
use crate::problem::projection::Projection;
use crate::screen::candidates::{Cause, Screen};
use crate::screen::periodogram;
use crate::screen::refine::refined;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;
use truepose_errormodel::Visits;

/// The competitors, the preferred one first, and the likelihood of the present model.
pub(crate) struct Contest {
    pub present: Arc<Likelihood>,
    pub competitors: Vec<Competitor>,
}

/// Compares the best candidates of a screen once, except those that are barred ([`Contests`]).
pub(crate) fn contest(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    barred: &[Candidate],
    more_periods_allowed: bool,
) -> Result<Contest, DiscoverError> {
    Contests::new(linearisation, screen, more_periods_allowed)?.without(barred)
}

/// A cause, and whether its variant with further periods is one of its shapes.
type Shape = (usize, bool);

/// Contests of one screen. What was computed of a cause stays for those that follow without some of the others.
pub(crate) struct Contests<'a> {
    linearisation: &'a Linearisation<'a>,
    screen: &'a Screen,
    visits: Visits,
    present: Arc<Likelihood>,
    causes: Vec<Cause>,
    /// Whether further periods are added to the best transmissions: in a search for a new finding, and in the reconsideration of a transmission.
    more_periods_allowed: bool,
    /// By cause: its refined variants.
    refined: BTreeMap<usize, Vec<Competitor>>,
    /// By cause: its best variant with further periods.
    grown: BTreeMap<usize, Option<Competitor>>,
    /// The competitor with its best components.
    composed: BTreeMap<Shape, Competitor>,
}

impl<'a> Contests<'a> {
    /// Of the causes of a screen.
    pub fn new(
        linearisation: &'a Linearisation<'a>,
        screen: &'a Screen,
        more_periods_allowed: bool,
    ) -> Result<Self, DiscoverError> {
        let visits = Visits::of(linearisation.data);
        let nothing = DMatrix::zeros(linearisation.len(), 0);
        Ok(Contests {
            present: Arc::new(Likelihood::new(linearisation, &nothing, &visits)?),
            causes: screen.causes(linearisation),
            linearisation,
            screen,
            visits,
            more_periods_allowed,
            refined: BTreeMap::new(),
            grown: BTreeMap::new(),
            composed: BTreeMap::new(),
        })
    }

    /// The contest of all causes that are not barred.
    pub fn without(&mut self, barred: &[Candidate]) -> Result<Contest, DiscoverError> {
        let (linearisation, screen) = (self.linearisation, self.screen);
        let is_open =
            |cause: &Cause| !barred.iter().any(|b| b.family == cause.family && b.place == cause.place);
        let open: Vec<usize> = (0..self.causes.len()).filter(|&k| is_open(&self.causes[k])).collect();
        let selected = selected(linearisation, &self.causes, &open, screen.opener());
        let shapes = self.shapes(&selected)?;
        let best = shapes.iter().map(|(_, r)| r.score).fold(f64::INFINITY, f64::min);
        let mut competitors = self.composed(shapes, best)?;
        rank(&mut competitors, linearisation.policy);
        let open: Vec<&Cause> = open.iter().map(|&k| &self.causes[k]).collect();
        look_ahead::join(linearisation, screen, &self.visits, &mut competitors, &open)?;
        let first = look_ahead::first(&competitors, linearisation.policy);
        // None at all where no candidate is plausible.
        if let Some(before) = competitors.get_mut(..=first) {
            before.rotate_right(usize::from(first > 0));
        }
        Ok(Contest { present: Arc::clone(&self.present), competitors })
    }

    /// The best causes without a name, in all their variants: those that may replace a finding when it is reconsidered.
    pub fn shortlist(&self) -> Vec<Candidate> {
        let unnamed = self.causes.iter().filter(|cause| !cause.family.is_named());
        let best = unnamed.take(self.linearisation.budget.shortlist);
        best.flat_map(|cause| &cause.variants).map(|(candidate, ..)| (**candidate).clone()).collect()
    }

    /// Of each of these causes the simplest variant that is not distinguishable from its best one; none where no variant is plausible.
    fn shapes(&mut self, selected: &[usize]) -> Result<Vec<(Shape, Competitor)>, DiscoverError> {
        let (linearisation, screen, visits) = (self.linearisation, self.screen, &self.visits);
        let new: Vec<usize> = selected.iter().copied().filter(|k| !self.refined.contains_key(k)).collect();
        let refined: Vec<Vec<Competitor>> = new
            .par_iter()
            .map(|&k| refined_variants(linearisation, screen, visits, &self.causes[k]))
            .collect::<Result<_, _>>()?;
        self.refined.extend(new.into_iter().zip(refined));
        let mut periodic = Vec::new();
        if self.more_periods_allowed {
            let turns = |k: &usize| {
                let first = self.refined[k].first();
                first.is_some_and(|r| r.candidate.periodic_in(linearisation.chain()).is_some())
            };
            periodic = selected.iter().copied().filter(turns).collect();
            periodic.sort_by(|a, b| least(&self.refined[a]).total_cmp(&least(&self.refined[b])));
            periodic.truncate(linearisation.budget.transmissions);
            let new: Vec<usize> = periodic.iter().copied().filter(|k| !self.grown.contains_key(k)).collect();
            let grown: Vec<Option<Competitor>> = new
                .par_iter()
                .map(|k| with_periods(linearisation, screen, visits, &self.refined[k]))
                .collect::<Result<_, _>>()?;
            self.grown.extend(new.into_iter().zip(grown));
        }
        let shape = |&k: &usize| {
            let grown = if periodic.contains(&k) { self.grown[&k].as_ref() } else { None };
            let simplest = simplest(self.refined[&k].iter().chain(grown), linearisation.policy)?;
            Some(((k, grown.is_some()), simplest.clone()))
        };
        Ok(selected.iter().filter_map(shape).collect())
    }

    /// The competitors, those within reach of the best score with their best components.
    fn composed(
        &mut self,
        shapes: Vec<(Shape, Competitor)>,
        best: f64,
    ) -> Result<Vec<Competitor>, DiscoverError> {
        let (linearisation, screen, visits) = (self.linearisation, self.screen, &self.visits);
        let (all, composed) = (shapes.len(), &self.composed);
        let each: Vec<(Shape, bool, Competitor)> = shapes
            .into_par_iter()
            .map(|(key, r)| {
                let reach = r.score < best + component_reach(&r, linearisation.policy);
                Ok(match composed.get(&key).filter(|_| reach) {
                    Some(known) => (key, reach, known.clone()),
                    None if reach => (key, reach, with_best_components(linearisation, screen, visits, r)?),
                    None => (key, reach, r),
                })
            })
            .collect::<Result<_, DiscoverError>>()?;
        let mut competitors = Vec::with_capacity(all);
        for (key, reach, competitor) in each {
            if reach && !self.composed.contains_key(&key) {
                self.composed.insert(key, competitor.clone());
            }
            competitors.push(competitor);
        }
        Ok(competitors)
    }
}

/// Of the causes that are open, the best ones, the one with the smallest p, and the best one of every named family that has none among them.
fn selected(
    linearisation: &Linearisation<'_>,
    causes: &[Cause],
    open: &[usize],
    opener: Option<(Family, Place)>,
) -> Vec<usize> {
    let penalty = penalty_per_coefficient(linearisation.len());
    let mut selected: Vec<usize> = open.iter().copied().take(linearisation.budget.causes).collect();
    for &k in open.iter().skip(linearisation.budget.causes) {
        let cause = &causes[k];
        let (_, gain, freedom) = &cause.variants[0];
        let known = selected.iter().any(|&other| causes[other].family == cause.family);
        let opens =
            opener.as_ref().is_some_and(|(family, place)| (*family, place) == (cause.family, &cause.place));
        let first_of_family = cause.family.is_named() && !known && gain - penalty * *freedom as f64 > 0.0;
        if opens || first_of_family {
            selected.push(k);
        }
    }
    selected
}

/// The variants of a group, one for each number of coefficients and of nonlinear parameters on a coarse grid, with these optimised: the best
/// value of such a parameter hides the law without it in the screen, though that may predict as well.
fn refined_variants(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    visits: &Visits,
    cause: &Cause,
) -> Result<Vec<Competitor>, DiscoverError> {
    let mut competitors = Vec::new();
    let mut sizes = Vec::new();
    for (candidate, _, freedom) in &cause.variants {
        let size = (*freedom, candidate.scales());
        if sizes.contains(&size) || sizes.len() >= linearisation.budget.variants {
            continue;
        }
        sizes.push(size);
        let variant = refined(linearisation, &screen.projection, candidate);
        competitors.extend(competitor(linearisation, screen, visits, variant)?);
    }
    competitors.extend(richer(linearisation, screen, visits, cause)?);
    Ok(competitors)
}

/// The best richer variants of a group, one for each number of coefficients and of nonlinear parameters: all are compared by their gain,
/// the best ones as competitors.
fn richer(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    visits: &Visits,
    cause: &Cause,
) -> Result<Vec<Competitor>, DiscoverError> {
    let setting = Setting::new(linearisation.chain(), linearisation.data);
    let mut sizes = Vec::new();
    let mut all: Vec<(Candidate, f64)> = Vec::new();
    let penalty = penalty_per_coefficient(linearisation.len());
    // What does not pay for its own unknowns is not made richer.
    let pays = cause.variants.iter().filter(|(_, gain, freedom)| *gain > penalty * *freedom as f64);
    for (variant, _, freedom) in pays {
        let size = (*freedom, variant.scales());
        if sizes.contains(&size) || sizes.len() >= linearisation.budget.richer {
            continue;
        }
        sizes.push(size);
        for more in variant.richer(&setting) {
            if let Some(score) = screen.projection.judge(linearisation, &more) {
                let worth = score.gain - penalty * score.freedom as f64;
                all.push((more, worth));
            }
        }
    }
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all.truncate(linearisation.budget.richer);
    let refined = all.into_iter().map(|(more, _)| refined(linearisation, &screen.projection, &more));
    let competitors = refined.map(|more| competitor(linearisation, screen, visits, more));
    competitors.filter_map(Result::transpose).collect()
}

/// The best of these variants of a transmission with further periods; none where none is significant.
fn with_periods(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    visits: &Visits,
    variants: &[Competitor],
) -> Result<Option<Competitor>, DiscoverError> {
    let best = variants.iter().min_by(|a, b| a.score.total_cmp(&b.score));
    match best.and_then(|best| more_periods(linearisation, &screen.projection, &best.candidate)) {
        Some(candidate) => competitor(linearisation, screen, visits, candidate),
        None => Ok(None),
    }
}

/// The simplest variant of a cause that is not distinguishable from the best one.
fn simplest<'c>(shapes: impl Iterator<Item = &'c Competitor>, policy: &Policy) -> Option<&'c Competitor> {
    let shapes: Vec<&Competitor> = shapes.filter(|r| plausible(r, policy) && r.score.is_finite()).collect();
    let best = shapes.iter().map(|r| r.score).fold(f64::INFINITY, f64::min);
    let tied = shapes.into_iter().filter(|r| r.score < best + policy.variant_ties * policy.tie);
    tied.min_by(|a, b| a.unknowns().cmp(&b.unknowns()).then(a.score.total_cmp(&b.score)))
}

/// Best first; of those that are not distinguishable from the best one, the one with the most probable name, and of those with the same
/// probability the simplest.
fn rank(competitors: &mut [Competitor], policy: &Policy) {
    competitors.sort_by(|a, b| a.score.total_cmp(&b.score));
    let best = least(competitors);
    let tied = competitors.iter().take_while(|r| r.score < best + policy.tie).count();
    let tied = &mut competitors[..tied];
    tied.sort_by(|a, b| {
        let family = a.candidate.hypothesis().rank().cmp(&b.candidate.hypothesis().rank());
        family.then(a.unknowns().cmp(&b.unknowns())).then(a.score.total_cmp(&b.score))
    });
    let likeliest = tied.iter().map(|r| r.name_score(policy)).fold(f64::INFINITY, f64::min);
    if let Some(first) = tied.iter().position(|r| r.name_score(policy) <= likeliest + policy.same_explanation)
    {
        tied[..=first].rotate_right(1);
    }
}

/// Largest distance from the best score at which other sets of components of a competitor are tried.
fn component_reach(competitor: &Competitor, policy: &Policy) -> f64 {
    match competitor.candidate.family.is_named() {
        true => policy.component_reach,
        false => policy.component_reach_unnamed,
    }
}

fn least(competitors: &[Competitor]) -> f64 {
    competitors.iter().map(|r| r.score).fold(f64::INFINITY, f64::min)
}

/// The competitor with the set of components of the smallest score: greedy descent, one component more or
/// fewer at a time.
fn with_best_components(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    visits: &Visits,
    mut current: Competitor,
) -> Result<Competitor, DiscoverError> {
    loop {
        let mut best: Option<Competitor> = None;
        for candidate in current.candidate.neighbours() {
            let Some(other) = competitor(linearisation, screen, visits, candidate)? else { continue };
            if other.score
                < best
                    .as_ref()
                    .map_or(current.score - linearisation.policy.component_margin, |best| best.score)
            {
                best = Some(other);
            }
        }
        match best {
            Some(better) => current = better,
            None => return Ok(current),
        }
    }
}

/// The same transmission with further periods, added by forward selection as long as each is significant on
/// the grid of periods and exceeds its penalty.
fn more_periods(
    linearisation: &Linearisation<'_>,
    present: &Projection,
    candidate: &Candidate,
) -> Option<Candidate> {
    let joint = candidate.periodic_in(linearisation.chain())?;
    let grid = periodogram::grid(linearisation, joint);
    let log_tests = (grid.len().max(2) as f64).ln();
    let threshold =
        2.0 * log_tests + 2.0 * penalty_per_coefficient(linearisation.len()) + linearisation.policy.tie;
    let mut grown = candidate.clone();
    let mut projection = present.with(&linearisation.columns_of(&grown).ok()?)?;
    let mut added = 0;
    while added < linearisation.budget.periods {
        let wave = periodogram::scan(linearisation, &projection, joint, &grid)?;
        let (period, gain, surprisal) = wave.strongest()?;
        // The surprisal among poses has to exceed ln(periods on the grid): Bonferroni's bound at one expected
        // false period, valid while other effects are missing.
        if gain < threshold || surprisal < log_tests {
            break;
        }
        let one = refined(linearisation, &projection, &candidate.at_period(joint, period)?);
        let more = projection.with(&linearisation.columns_of(&one).ok()?);
        if let (Change::Add(effects), Change::Add(more)) = (&mut grown.change, one.change) {
            effects.extend(more);
        }
        added += 1;
        let Some(more) = more else { break };
        projection = more;
    }
    (added > 0).then_some(grown)
}
