//! Whether a change of the model is kept: the refitted model has the last word.
//!
//! An effect that is added has to converge, to be significant and physical ([`crate::model::admissible`]), not to raise the training error, and to
//! predict unseen poses better ([`crate::model::refits`]). A revision of what was found (descent, defence, merging) may not lose by anything that counts.
//! What fails is taken back as a whole.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::Doubt;
use crate::accept::polish::polished;
use crate::error::DiscoverError;
use crate::model::admissible::{Objection, objection};
use crate::model::current::Working;
use crate::model::refits::{Refits, compared};
use crate::search::Search;
use std::sync::Arc;

/// What a change of the model can be taken back to.
struct Checkpoint {
    accepted: Vec<Accepted>,
    now: Arc<Working>,
    refits: Option<Refits>,
}

impl Search<'_> {
    /// Takes a candidate into the model, refits it, and takes it out again when that makes the model worse; why, if it does.
    pub fn admit(&mut self, accepted: Accepted) -> Result<Option<Doubt>, DiscoverError> {
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
    pub fn revise(
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
    pub fn sift(&mut self) -> Result<(), DiscoverError> {
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
}

fn doubt_of(objection: Objection) -> Doubt {
    match objection {
        Objection::NotSignificant => Doubt::NotSignificant,
        Objection::NotPhysical => Doubt::NotPhysical,
    }
}
