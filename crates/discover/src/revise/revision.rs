//! When findings are revised, and which revisions are kept.

use crate::accept::admit::kept;
use crate::accept::model::Model;
use crate::error::DiscoverError;
use crate::model::current::Ground;
use crate::revise::merge::merged;
use crate::revise::reconsider::reconsidered;
use crate::screen::candidates::Questions;

/// After a finding: every other one is tested again, and two that one cause explains are merged.
pub(crate) fn after_finding(
    context: &Ground<'_>,
    model: Model,
    asked: &Questions,
) -> Result<Model, DiscoverError> {
    let revised = guarded(context, model, |model| {
        let newest = model.findings.len() - 1;
        let (mut model, mut changed) = reconsidered(context, model, newest, asked)?;
        if changed {
            // The newest won against others than those that are there now.
            let count = model.findings.len();
            model = reconsidered(context, model, count, asked)?.0;
        }
        let last = model.findings.len().checked_sub(1);
        if let Some(last) = last
            && let Some(merged) = merged(context, &model, last, asked)?
        {
            let count = merged.findings.len();
            model = reconsidered(context, merged, count, asked)?.0;
            changed = true;
        }
        Ok((model, changed))
    })?;
    Ok(revised.0)
}

/// At the end: every finding is tested again; whether the model changed.
pub(crate) fn reconsidered_once(
    context: &Ground<'_>,
    model: Model,
    asked: &Questions,
) -> Result<(Model, bool), DiscoverError> {
    let count = model.findings.len();
    guarded(context, model, |model| reconsidered(context, model, count, asked))
}

/// The nonlinear parameters of all findings at their joint optimum; whether the model changed.
pub(crate) fn descended(context: &Ground<'_>, model: Model) -> Result<(Model, bool), DiscoverError> {
    guarded(context, model, |model| {
        Ok(match model.descended(context)? {
            Some(next) => (next, true),
            None => (model, false),
        })
    })
}

/// Makes a change, and drops it where the changed model is worse.
fn guarded(
    context: &Ground<'_>,
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
