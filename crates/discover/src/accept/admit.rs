//! Whether a change of the model is kept: the refitted model decides.
//!
//! An effect that is added has to converge, to be significant and physical ([`crate::model::admissible`]), not to raise the training error, and to
//! predict unseen poses better ([`crate::model::refits`]). A revision of earlier findings (joint descent, reconsideration, merging) may not lose by
//! anything that counts. A change that fails is dropped as a whole.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::{Doubt, Refused};
use crate::accept::model::Model;
use crate::accept::polish::polished;
use crate::error::DiscoverError;
use crate::model::admissible::{Objection, objection};
use crate::model::current::Ground;
use crate::model::refits::compared;

/// The model with a candidate more, or why it is not kept.
pub(crate) fn admitted(
    context: &Ground<'_>,
    before: &Model,
    accepted: Accepted,
) -> Result<Result<Model, Doubt>, DiscoverError> {
    let Some((findings, added)) = before.joined(accepted) else {
        return Ok(Err(Doubt::NothingNew));
    };
    let mut after = before.refitted(context, findings)?;
    if let Some(better) = polished(context, &after.current, added)? {
        let mut findings = after.findings.clone();
        findings[added].candidate = better;
        after = after.refitted(context, findings)?;
    }
    let own = after.effects_of(context, added);
    let doubt = match objection(&after.current.fit, &after.current.found[added], own) {
        Some(objection) => Some(doubt_of(objection)),
        None => doubt_about(context, before, &after, true)?,
    };
    Ok(match doubt {
        Some(doubt) => Err(doubt),
        None => Ok(after),
    })
}

/// The model after a revision of its findings, where that is no worse; none where it is.
pub(crate) fn kept(
    context: &Ground<'_>,
    before: &Model,
    after: Model,
) -> Result<Option<Model>, DiscoverError> {
    Ok(doubt_about(context, before, &after, false)?.is_none().then_some(after))
}

/// What speaks against a model beside an earlier one. An effect that is added has to predict unseen poses better; a revision, which may also
/// make the model simpler, not worse by more than what counts.
fn doubt_about(
    context: &Ground<'_>,
    before: &Model,
    after: &Model,
    gains: bool,
) -> Result<Option<Doubt>, DiscoverError> {
    /// A training error may grow by so little where the noise of rows and poses is estimated anew.
    const GROWTH: f64 = 1.01;
    let (old, new) = (&before.current.fit, &after.current.fit);
    if old.converged && !new.converged {
        return Ok(Some(Doubt::NotConverged));
    }
    let trained = compared(&old.residuals, &new.residuals, old.noise);
    if gains && trained.is_some_and(|trained| trained.position > GROWTH && trained.deviation > 1.0) {
        return Ok(Some(Doubt::WorseFit));
    }
    let (earlier, refits) = (before.refits(context)?, after.refits(context)?);
    let unseen = compared(&earlier.residuals, &refits.residuals, old.noise);
    let worse = unseen.is_none_or(|unseen| if gains { unseen.is_no_gain() } else { unseen.is_loss() });
    Ok((worse || (earlier.converged && !refits.converged)).then_some(Doubt::WorseUnseen))
}

/// The model without findings that, with all others in it, are no longer significant or physical; those are noted.
pub(crate) fn sifted(
    context: &Ground<'_>,
    mut model: Model,
    refused: &mut Vec<Refused>,
) -> Result<Model, DiscoverError> {
    let mut at = 0;
    while at < model.findings.len() {
        let own = model.effects_of(context, at);
        let Some(objection) = objection(&model.current.fit, &model.current.found[at], own) else {
            at += 1;
            continue;
        };
        let mut findings = model.findings.clone();
        let Accepted { candidate, evidence, .. } = findings.remove(at);
        Refused { candidate, evidence, doubt: doubt_of(objection) }.note_in(refused);
        model = model.refitted(context, findings)?;
        at = 0;
    }
    Ok(model)
}

fn doubt_of(objection: Objection) -> Doubt {
    match objection {
        Objection::NotSignificant => Doubt::NotSignificant,
        Objection::NotPhysical => Doubt::NotPhysical,
    }
}
