//! What a reduction shows that a user should know.

use super::Warning;
use crate::reduction::Reduction;
use truepose_errormodel::ErrorModel;

/// Of a model and the data behind it.
pub(super) fn of(model: &ErrorModel, reduction: &Reduction, observations: usize) -> Vec<Warning> {
    let columns = model.columns();
    let idle = reduction.dropped.iter().filter(|d| d.relation.is_empty() && columns[d.column].site.is_none());
    let mut warnings: Vec<Warning> =
        idle.map(|d| Warning::NoEffect { column: columns[d.column].name.clone() }).collect();
    for (structural, decision) in [(true, &reduction.structural), (false, &reduction.practical)] {
        if !decision.is_clear() {
            warnings.push(Warning::UnclearRank { structural, gap: decision.gap });
        }
    }
    if observations < columns.len() {
        warnings.push(Warning::FewerRowsThanUnknowns { observations, unknowns: columns.len() });
    }
    if observations <= reduction.rank() {
        warnings.push(Warning::NoRedundancy);
    }
    warnings
}
