//! Acceptance of a change of the model, decided on the refitted model.
//!
//! An added effect is accepted when the fit with it converges, its coefficients are significant and physical
//! ([`crate::model::admissible`]), the training error does not increase, and refits predict unseen poses
//! better ([`crate::model::refits`]). A revision of earlier findings (joint optimisation, reconsideration,
//! merging) is accepted when its prediction of unseen poses is not worse by 2 % or more. A rejected change is
//! undone as a whole.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::{Doubt, Refused};
use crate::accept::model::Model;
use crate::accept::refine::refined_in_model;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::model::admissible::{Objection, objection};
use crate::model::current::Context;
use crate::model::refits::compared;

/// The model with one more finding, or the reason why it is rejected.
pub(crate) fn admitted(
    context: &Context<'_>,
    before: &Model,
    accepted: Accepted,
) -> Result<Result<Model, Doubt>, DiscoverError> {
    let Some((findings, added)) = before.joined(accepted) else {
        return Ok(Err(Doubt::NothingNew));
    };
    let mut after = before.refitted(context, findings)?;
    if let Some(better) = refined_in_model(context, &after.current, added)? {
        let mut findings = after.findings.clone();
        findings[added].candidate = better;
        after = after.refitted(context, findings)?;
    }
    let own = after.effects_of(context, added);
    let doubt = match objection(&after.current.fit, &after.current.found[added], own, context.policy()) {
        Some(objection) => Some(doubt_of(objection)),
        None => doubt_about(context, before, &after, true)?,
    };
    Ok(match doubt {
        Some(doubt) => Err(doubt),
        None => Ok(after),
    })
}

/// The revised model; `None` when it predicts unseen poses worse than the model before.
pub(crate) fn kept(
    context: &Context<'_>,
    before: &Model,
    after: Model,
) -> Result<Option<Model>, DiscoverError> {
    Ok(doubt_about(context, before, &after, false)?.is_none().then_some(after))
}

/// The reason to reject `after` in favour of `before`; `None` when there is none. With `gains` (an added
/// effect) `after` has to predict unseen poses better; without (a revision, which may make the model simpler)
/// it may be worse by less than the 2 % of [`crate::model::refits`].
fn doubt_about(
    context: &Context<'_>,
    before: &Model,
    after: &Model,
    gains: bool,
) -> Result<Option<Doubt>, DiscoverError> {
    let (old, new) = (&before.current.fit, &after.current.fit);
    if old.converged && !new.converged {
        return Ok(Some(Doubt::NotConverged));
    }
    let trained = compared(&old.residuals, &new.residuals, old.noise);
    if gains
        && trained.is_some_and(|trained| {
            trained.position > 1.0 + context.policy().training_growth && trained.deviation > 1.0
        })
    {
        return Ok(Some(Doubt::WorseFit));
    }
    let (earlier, refits) = (before.refits(context)?, after.refits(context)?);
    let unseen = compared(&earlier.residuals, &refits.residuals, old.noise);
    let worse = unseen.is_none_or(|unseen| {
        if gains { unseen.is_no_gain(context.policy()) } else { unseen.is_loss(context.policy()) }
    });
    Ok((worse || (earlier.converged && !refits.converged)).then_some(Doubt::WorseUnseen))
}

/// The model without the findings that are no longer significant or physical in the joint fit, and these; they are
/// added to `refused`.
pub(crate) fn without_insignificant(
    context: &Context<'_>,
    mut model: Model,
    refused: &mut Vec<Refused>,
) -> Result<(Model, Vec<Candidate>), DiscoverError> {
    let mut dropped = Vec::new();
    let mut at = 0;
    while at < model.findings.len() {
        let own = model.effects_of(context, at);
        let Some(objection) = objection(&model.current.fit, &model.current.found[at], own, context.policy())
        else {
            at += 1;
            continue;
        };
        let mut findings = model.findings.clone();
        let Accepted { candidate, evidence, .. } = findings.remove(at);
        dropped.push(candidate.clone());
        Refused { candidate, evidence, doubt: doubt_of(objection) }.note_in(refused);
        model = model.refitted(context, findings)?;
        at = 0;
    }
    Ok((model, dropped))
}

/// The doubt that an objection is.
pub(crate) fn doubt_of(objection: Objection) -> Doubt {
    match objection {
        Objection::NotSignificant => Doubt::NotSignificant,
        Objection::NotPhysical => Doubt::NotPhysical,
    }
}
