//! All rows, after a search that saw a sample of them.
//!
//! ```text
//! c ← c + (Σ AᵀA + WᵀW)⁻¹ (Σ Aᵀr − WᵀW c)          the fit of all rows, from that of some
//! s_g = Σ X_gᵀ r,   SS_g = ‖T_gᵀ s_g‖² n/N          the screen: T_g from the sample, s_g from all rows
//! ```
//!
//! The effect that N rows can show is √(N/n) times smaller than that of a sample of n. The columns of a candidate beside the model, and so the
//! distribution of the smallest p, are known from the sample well enough; its score is not. So every candidate is screened on all rows, and the
//! best of them are compared, refined and tested on all rows, each pass in blocks of whole poses, in memory that does not grow with the data
//! but for the data itself. All quantities are whitened with the noise of the fit.
//!
//! A finding is relevant here if it predicts unseen rows: the lower bounds of [`crate::accept::evidence`] on its size are those of a sample.

pub(crate) mod all_rows;
pub(crate) mod blocks;
mod comparison;
mod confirmed;
mod derived;
mod details;
pub(crate) mod gross;
#[cfg(test)]
mod oracle;
mod proof;
mod scores;
mod seen;
mod sums;
mod waves;
mod white;

use crate::accept::accepted::Accepted;
use crate::accept::admit::doubt_of;
use crate::accept::evidence::{Doubt, Refused};
use crate::accept::model::Model;
use crate::accept::outcome::{LastScreen, Outcome};
use crate::census::all_rows::AllRows;
use crate::census::blocks::Blocks;
use crate::census::comparison::{Compared, Known, compared};
use crate::census::confirmed::confirmed;
use crate::census::gross::gross;
use crate::census::proof::evidence;
use crate::census::scores::screened;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::admissible::objection;
use crate::model::current::{Context, ModelFit};
use crate::model::prepared::{emptied, found_in, with_found};
use crate::observer::Begin;
use crate::problem::linearisation::Linearisation;
use crate::progress::Progress;
use crate::screen::candidates::Screen;
use crate::significance::rotation::NullDistribution;
use crate::termination::Termination;
use std::borrow::Cow;
use truepose_errormodel::Dataset;
use truepose_identify::{Fit, Residuals};

/// What a census is made with.
pub(crate) struct Census<'a> {
    /// The sample that was searched: it decides which unknowns a model has.
    sample: &'a Context<'a>,
    /// As many rows as are fitted and judged at once.
    fitted: &'a Context<'a>,
    blocks: Blocks,
}

/// What a screen led to.
enum Step {
    Added(Box<AllRows>),
    Ended(Termination),
}

impl<'a> Census<'a> {
    /// Of all training rows but gross ones, after a search of a sample of them.
    pub fn new(
        (sample, fitted): (&'a Context<'a>, &'a Context<'a>),
        train: Cow<'_, Dataset>,
        searched: &Outcome,
    ) -> Result<Self, DiscoverError> {
        let ModelFit { found, fit, .. } = &*searched.model.current;
        let train = found_in(train, found).into_owned();
        let far = gross(&Residuals::of(&fit.fitted, &train)?, &train);
        let blocks = Blocks::new(emptied(train, &far)).under(searched.joints.map(|joints| joints.noise()));
        Ok(Census { sample, fitted, blocks })
    }

    /// The outcome of a search with what only all rows show; its model is that of the sample with their coefficients.
    pub fn of(&self, outcome: Outcome, progress: &Begin<'_>) -> Result<Outcome, DiscoverError> {
        let (options, blocks) = (self.sample.options, &self.blocks);
        let mut outcome = outcome;
        let most = outcome.model.findings.len() + self.sample.budget().census;
        let sample = with_found(self.sample.data, &outcome.model.current.found);
        let mut barred: Vec<Candidate> = Vec::new();
        let mut known: Option<NullDistribution> = None;
        let mut all = AllRows::of(&outcome.model.current.fit, blocks, options)?;
        loop {
            progress(Progress::Screening(outcome.model.findings.len()))?;
            let linearisation = blocks.linearised(&all.fit, &sample, options)?;
            let mut screen = Screen::new(&linearisation, &options.library, &outcome.model.current.found);
            let null = match known.take() {
                Some(null) => null,
                None => screen.null(&linearisation, options.rotations, options.seed)?,
            };
            screened(&mut screen, &linearisation, (&all, blocks), options)?;
            confirmed((&mut screen, &linearisation), &null, (&all, blocks), options)?;
            let p_value = null.p_value(screen.largest());
            outcome.last = LastScreen { p_value, detectable_gain: null.detectable(options.alpha, all.count) };
            let step = match outcome.model.findings.len() < most {
                // A candidate that is barred changes neither model nor scores: the next one is compared.
                true => {
                    let mut compared = Known::default();
                    loop {
                        let screened = (&linearisation, &screen, &null);
                        let refused = (&mut barred, &mut compared);
                        if let Some(step) = self.step(&mut outcome, refused, screened, &all, progress)? {
                            break step;
                        }
                    }
                }
                false if p_value > options.alpha => Step::Ended(Termination::NothingLeft),
                false => Step::Ended(Termination::Limit),
            };
            known = Some(null);
            match step {
                Step::Ended(why) => {
                    outcome.stopped = why;
                    return Ok(outcome);
                }
                Step::Added(fitted) => all = *fitted,
            }
        }
    }

    /// The model and the declared one as they are fitted to as many rows as are fitted at once, with the coefficients of all.
    pub fn settled(&self, model: &Model) -> Result<Model, DiscoverError> {
        let model = model.on_data_of(self.fitted)?;
        let of_all = |fit: &Fit| AllRows::of(fit, &self.blocks, self.sample.options).map(|all| all.fit);
        let (declared, current) = (of_all(&model.declared.fit)?, of_all(&model.current.fit)?);
        let model = model.with_declared(declared);
        Ok(if model.findings.is_empty() { model.without_findings() } else { model.with_fit(current) })
    }

    /// One more finding, where there is one, or the end; none where one more candidate is barred.
    fn step(
        &self,
        outcome: &mut Outcome,
        (barred, known): (&mut Vec<Candidate>, &mut Known),
        (linearisation, screen, null): (&Linearisation<'_>, &Screen, &NullDistribution),
        all: &AllRows,
        progress: &Begin<'_>,
    ) -> Result<Option<Step>, DiscoverError> {
        let (options, blocks) = (self.sample.options, &self.blocks);
        if outcome.last.p_value > options.alpha {
            return Ok(Some(Step::Ended(Termination::NothingLeft)));
        }
        if outcome.model.findings.len() >= options.most {
            return Ok(Some(Step::Ended(Termination::Limit)));
        }
        if barred.len() >= self.sample.budget().contests {
            return Ok(Some(Step::Ended(Termination::NothingConvincing)));
        }
        let Some(best) = compared(linearisation, screen, (barred, known), (all, blocks), options)? else {
            return Ok(Some(Step::Ended(Termination::NothingConvincing)));
        };
        let Compared { candidate, competitors, prior_width, detail } = best;
        if !candidate.family.is_named() {
            // It would be one of many small curves, and the next name would stand for what it is.
            return Ok(Some(Step::Ended(Termination::NothingConvincing)));
        }
        let evidence = evidence(&candidate, &detail, null, (all, blocks), options)?;
        let mut held = candidate.clone();
        held.width = Some(prior_width);
        let accepted = Accepted {
            candidate: held,
            evidence: evidence.clone(),
            competitors,
            shortlist: Vec::new(),
            instead: Vec::new(),
        };
        let policy = (&options.policy, options.alpha);
        let admitted = match evidence.doubt_beyond_size(policy, candidate.follows_time()) {
            Some(doubt) => Err(doubt),
            None => {
                progress(Progress::Found(candidate.words()))?;
                self.admitted(&outcome.model, accepted)?
            }
        };
        match admitted {
            Ok((model, fitted)) => {
                outcome.model = model;
                barred.clear();
                Ok(Some(Step::Added(Box::new(fitted))))
            }
            Err(doubt) => {
                Refused { candidate: candidate.clone(), evidence, doubt }.note_in(&mut outcome.refused);
                barred.push(candidate);
                Ok(None)
            }
        }
    }

    /// The model with one more finding, with the coefficients of all rows, or the reason why it is rejected.
    fn admitted(
        &self,
        before: &Model,
        accepted: Accepted,
    ) -> Result<Result<(Model, AllRows), Doubt>, DiscoverError> {
        let Some((findings, added)) = before.joined(accepted) else { return Ok(Err(Doubt::NothingNew)) };
        let model = before.refitted(self.sample, findings)?;
        if before.current.fit.converged && !model.current.fit.converged {
            return Ok(Err(Doubt::NotConverged));
        }
        let all = AllRows::of(&model.current.fit, &self.blocks, self.sample.options)?;
        let own = model.effects_of(self.sample, added);
        if let Some(objection) = objection(&all.fit, &model.current.found[added], own, self.sample.policy()) {
            return Ok(Err(doubt_of(objection)));
        }
        Ok(Ok((model.with_fit(all.fit.clone()), all)))
    }
}
