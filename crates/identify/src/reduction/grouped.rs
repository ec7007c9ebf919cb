//! The paper's order: constant errors are reduced first, and each grouped error gets the union of its members' terms.
//!
//! ```text
//! J^p = −Σ_j c_j J^j   ⟹   β_j = ε_j − c_j ε_p,    terms(β_j) = terms(ε_j) ∪ terms(ε_p) ∪ …
//! ```
//!
//! Source: Eq. (8)–(17) of the paper, in its order. In the other order every error has its terms and their columns are
//! reduced, which is what a fit does with any model; it reduces those of a grouped error again, since functions may
//! depend on each other where constants do not.

use super::groups::Reduction;
use super::reduce::reduce;
use crate::linearise::factorise;
use crate::{IdentifyError, NoiseModel};
use std::borrow::Cow;
use truepose_errormodel::effects::{Geometric, GroupedError, Order, Polynomial, Where};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, Term, UNBOUNDED, Visits};
use truepose_kinematics::{FrameId, Site};
use truepose_solvers::RankRule;

/// The model with the groups of every polynomial that reduces first and has none yet; the rest as it is.
///
/// # Errors
/// When the model does not fit the data, or a factorisation fails.
pub fn grouped<'m>(
    model: &'m ErrorModel,
    data: &Dataset,
    rule: RankRule,
) -> Result<Cow<'m, ErrorModel>, IdentifyError> {
    let waiting = |effect: &dyn AnyEffect| {
        Polynomial::of_effect(effect).filter(|p| p.order == Order::ReduceFirst && p.groups.is_none())
    };
    if model.effects().iter().all(|effect| waiting(effect.as_ref()).is_none()) {
        return Ok(Cow::Borrowed(model));
    }
    let mut effects = Vec::with_capacity(model.effects().len());
    for (k, effect) in model.effects().iter().enumerate() {
        let Some(polynomial) = waiting(effect.as_ref()) else {
            effects.push(effect.clone());
            continue;
        };
        let grouped: Box<dyn AnyEffect> = Box::new(with_groups(polynomial, model, data, rule)?);
        // Bounds that a user set are on all columns alike.
        let bounds = model.columns()[model.columns_of(k)].first().map_or(UNBOUNDED, |c| c.bounds);
        effects.push(match bounds == UNBOUNDED {
            true => grouped,
            false => Box::new(Term::new(grouped).bounded(bounds)?),
        });
    }
    Ok(Cow::Owned(ErrorModel::new(model.shared_chain(), effects)?))
}

fn with_groups(
    polynomial: Polynomial,
    model: &ErrorModel,
    data: &Dataset,
    rule: RankRule,
) -> Result<Polynomial, IdentifyError> {
    let mut frames: Vec<FrameId> = polynomial.errors(model.chain()).into_iter().map(|e| e.0).collect();
    frames.dedup();
    let constants = Geometric {
        frames: Some(frames.into_iter().map(Where::Frame).collect()),
        components: polynomial.components.clone(),
    };
    let constants = ErrorModel::new(model.shared_chain(), vec![Box::new(constants)])?;
    let zero = vec![0.0; constants.columns().len()];
    let factor = factorise(&constants, data, &Visits::of(data), NoiseModel::default(), &zero, None)?;
    let reduction = reduce(&constants, data, &factor, rule, &zero)?;
    Ok(Polynomial { groups: Some(groups(&constants, &reduction)), ..polynomial })
}

/// Each kept error, with the frames of what passes into it.
fn groups(constants: &ErrorModel, reduction: &Reduction) -> Vec<GroupedError> {
    let site = |column: usize| match constants.columns()[column].site {
        Some(Site::Frame(frame, axis)) => Some((frame, axis)),
        _ => None,
    };
    let kept = reduction.groups.iter().filter_map(|group| site(group.column).map(|at| (at, &group.members)));
    kept.map(|((frame, component), members)| {
        let mut of = vec![frame];
        for (member, _) in members.iter().filter_map(|&(column, _)| site(column)) {
            if !of.contains(&member) {
                of.push(member);
            }
        }
        GroupedError { frame, component, of }
    })
    .collect()
}
