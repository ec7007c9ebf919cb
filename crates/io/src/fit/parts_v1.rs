//! Effects and coefficients, as fits and their fallbacks have them.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use truepose_errormodel::{AnyEffect, ErrorModel, FittedModel};

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct EffectV1 {
    pub family: String,
    pub parameters: Value,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(expecting = "a coefficient: a table of name, unit and value")]
pub(super) struct CoefficientV1 {
    pub name: String,
    pub unit: String,
    pub value: f64,
}

impl EffectV1 {
    /// The effects of a model.
    pub fn all(model: &ErrorModel) -> Vec<Self> {
        let one = |effect: &dyn AnyEffect| EffectV1 {
            family: effect.kind().into(),
            parameters: effect.parameters(),
        };
        model.effects().iter().map(|effect| one(&**effect)).collect()
    }
}

impl CoefficientV1 {
    /// The coefficients of a fitted model.
    pub fn all(fit: &FittedModel) -> Vec<Self> {
        let columns = fit.model().columns().iter().zip(fit.coefficients());
        columns
            .map(|(column, &value)| CoefficientV1 {
                name: column.name.clone(),
                unit: column.unit.clone(),
                value,
            })
            .collect()
    }
}
