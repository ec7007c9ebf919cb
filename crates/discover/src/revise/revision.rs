//! When findings are revised, and which revisions are kept.

use crate::accept::admit::kept;
use crate::accept::model::Model;
use crate::error::DiscoverError;
use crate::model::current::Context;
use crate::revise::merge::merged;
use crate::revise::reconsider::reconsidered;
use crate::screen::candidates::TestCounts;

/// After a finding: every other one is tested again, and two that one cause explains are merged.
pub(crate) fn after_finding(
    context: &Context<'_>,
    model: Model,
    test_counts: &TestCounts,
) -> Result<Model, DiscoverError> {
    let revised = guarded(context, model, |model| {
        let newest = model.findings.len() - 1;
        let (mut model, mut changed) = reconsidered(context, model, newest, test_counts)?;
        if changed {
            // The newest won against others than those that are there now.
            let count = model.findings.len();
            model = reconsidered(context, model, count, test_counts)?.0;
        }
        let last = model.findings.len().checked_sub(1);
        if let Some(last) = last
            && let Some(merged) = merged(context, &model, last, test_counts)?
        {
            let count = merged.findings.len();
            model = reconsidered(context, merged, count, test_counts)?.0;
            changed = true;
        }
        Ok((model, changed))
    })?;
    Ok(revised.0)
}

/// At the end: every finding is tested again; whether the model changed.
pub(crate) fn reconsidered_once(
    context: &Context<'_>,
    model: Model,
    test_counts: &TestCounts,
) -> Result<(Model, bool), DiscoverError> {
    let count = model.findings.len();
    guarded(context, model, |model| reconsidered(context, model, count, test_counts))
}

/// The nonlinear parameters of all findings at their joint optimum; whether the model changed.
pub(crate) fn descended(context: &Context<'_>, model: Model) -> Result<(Model, bool), DiscoverError> {
    guarded(context, model, |model| {
        Ok(match model.descended(context)? {
            Some(next) => (next, true),
            None => (model, false),
        })
    })
}

/// Makes a change, and drops it where the changed model is worse.
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
