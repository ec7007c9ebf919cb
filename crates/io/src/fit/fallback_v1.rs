//! The declared model of a fit with findings: predictions beyond the data of the fit fall back to it.

use super::check;
use super::parts_v1::{CoefficientV1, EffectV1};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use truepose_errormodel::{EffectRegistry, ErrorModel, Fallback, FittedModel};
use truepose_kinematics::Chain;
use truepose_kinematics::nalgebra::DMatrix;

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct FallbackV1 {
    /// Standard deviation of a predicted position, m, up to which findings count in full.
    usual_sd: f64,
    /// By how much more they count half, m; absent: they count everywhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    half_sd: Option<f64>,
    /// RMS by which the findings move the rows of the fit, m.
    findings_rms: f64,
    effects: Vec<EffectV1>,
    coefficients: Vec<CoefficientV1>,
    covariance: Vec<Vec<f64>>,
}

impl From<&Fallback> for FallbackV1 {
    fn from(fallback: &Fallback) -> Self {
        let declared = &fallback.declared;
        FallbackV1 {
            usual_sd: fallback.usual.sqrt(),
            half_sd: fallback.scale.is_finite().then(|| fallback.scale.sqrt()),
            findings_rms: fallback.size.sqrt(),
            effects: EffectV1::all(declared.model()),
            coefficients: CoefficientV1::all(declared),
            covariance: declared.covariance().row_iter().map(|row| row.iter().copied().collect()).collect(),
        }
    }
}

impl FallbackV1 {
    /// The fallback of a fit of this robot.
    pub fn into_fallback(self, chain: &Chain, registry: &EffectRegistry) -> Result<Fallback, String> {
        let sizes = [self.usual_sd, self.half_sd.unwrap_or(1.0), self.findings_rms];
        if sizes.iter().any(|size| !size.is_finite() || *size < 0.0)
            || self.half_sd.is_some_and(|sd| sd <= 0.0)
        {
            return Err("a standard deviation of `fallback` is not a length; the file is damaged".into());
        }
        let effects =
            self.effects.into_iter().map(|effect| registry.build(&effect.family, effect.parameters, chain));
        let effects =
            effects.collect::<Result<Vec<_>, _>>().map_err(|error| format!("`fallback`: {error}"))?;
        let model =
            ErrorModel::new(chain.clone(), effects).map_err(|error| format!("`fallback`: {error}"))?;
        let coefficients: Vec<f64> = self.coefficients.iter().map(|coefficient| coefficient.value).collect();
        let named = model.columns().iter().zip(&self.coefficients);
        let size = self.covariance.len();
        if coefficients.len() != model.columns().len()
            || size != coefficients.len()
            || self.covariance.iter().any(|row| row.len() != size)
            || named.into_iter().any(|(column, stored)| column.name != stored.name)
        {
            return Err(
                "the coefficients of `fallback` are not those of its effects; the file is damaged".into()
            );
        }
        let covariance = DMatrix::from_row_iterator(size, size, self.covariance.into_iter().flatten());
        check::coefficients(&model, &coefficients).map_err(|words| format!("`fallback`: {words}"))?;
        check::covariance(&model, &covariance).map_err(|words| format!("`fallback`: {words}"))?;
        let declared =
            FittedModel::new(model, coefficients, covariance).map_err(|error| error.to_string())?;
        Ok(Fallback {
            declared: Arc::new(declared),
            usual: self.usual_sd.powi(2),
            scale: self.half_sd.map_or(f64::INFINITY, |sd| sd * sd),
            size: self.findings_rms.powi(2),
        })
    }
}
