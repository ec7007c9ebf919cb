//! Revisions of the findings, and which of them are kept.

use crate::accept::admit::kept;
use crate::accept::model::Model;
use crate::error::DiscoverError;
use crate::model::current::Context;
use crate::revise::merge::merged;
use crate::revise::reconsider::reconsidered;
use crate::screen::multiplicity::Multiplicity;

/// After a new finding: every other one is reconsidered, the new one as well where another name is more probable, and it is merged with
/// another one where a single candidate explains both.
pub(crate) fn after_finding(
    context: &Context<'_>,
    model: Model,
    multiplicity: &Multiplicity,
) -> Result<Model, DiscoverError> {
    let revised = guarded(context, model, |model| {
        let outnamed = model.findings.last().is_some_and(|newest| newest.is_outnamed(context.policy()));
        let others = model.findings.len() - usize::from(!outnamed);
        let (mut model, mut changed) = reconsidered(context, model, others, multiplicity)?;
        if changed {
            // The newest finding was selected with other findings in the model.
            let count = model.findings.len();
            model = reconsidered(context, model, count, multiplicity)?.0;
        }
        let last = model.findings.len().checked_sub(1);
        if let Some(last) = last {
            let one;
            (model, one) = merged(context, model, last, multiplicity)?;
            if one {
                let count = model.findings.len();
                model = reconsidered(context, model, count, multiplicity)?.0;
                changed = true;
            }
        }
        Ok((model, changed))
    })?;
    Ok(revised.0)
}

/// At the end of the search: every finding is reconsidered. Returns the model and whether it changed.
pub(crate) fn reconsidered_once(
    context: &Context<'_>,
    model: Model,
    multiplicity: &Multiplicity,
) -> Result<(Model, bool), DiscoverError> {
    let count = model.findings.len();
    guarded(context, model, |model| reconsidered(context, model, count, multiplicity))
}

/// Optimises the nonlinear parameters of all findings jointly. Returns the model and whether it changed.
pub(crate) fn descended(context: &Context<'_>, model: Model) -> Result<(Model, bool), DiscoverError> {
    guarded(context, model, |model| {
        Ok(match model.descended(context)? {
            Some(next) => (next, true),
            None => (model, false),
        })
    })
}

/// Makes a change, and undoes it where the changed model predicts unseen poses worse ([`kept`]).
fn guarded(
    context: &Context<'_>,
    model: Model,
    change: impl FnOnce(Model) -> Result<(Model, bool), DiscoverError>,
) -> Result<(Model, bool), DiscoverError> {
    let (after, changed) = change(model.clone())?;
    if !changed {
        return Ok((after, false));
    }
    Ok(match kept(context, &model, after)? {
        Some(after) => (after, true),
        None => (model, false),
    })
}
