//! The fit file, format 1, in JSON. This schema does not change; a new format is a new file.

use super::check;
use super::fallback_v1::FallbackV1;
use super::parts_v1::{CoefficientV1, EffectV1};
use super::robot_v1::RobotV1;
use super::sample_v1::{self, RowV1, SampleOfV1};
use super::sessions_v1::{self, SessionV1};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use truepose_errormodel::{
    Channel, Domain, EffectRegistry, ErrorModel, FittedModel, Interval, LoadCorrection, NoiseModel,
};
use truepose_kinematics::nalgebra::DMatrix;
use truepose_kinematics::{Chain, TargetId};

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct FitV1 {
    pub format: u64,
    pub program: String,
    pub robot: RobotV1,
    pub effects: Vec<EffectV1>,
    pub coefficients: Vec<CoefficientV1>,
    /// Rows of the covariance of the coefficients.
    pub covariance: Vec<Vec<f64>>,
    pub channels: Vec<ChannelV1>,
    pub domain: DomainV1,
    pub noise: NoiseV1,
    /// Payloads that are declared wrongly.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loads: Vec<LoadCorrection>,
    /// The installations, where they are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sessions: Vec<SessionV1>,
    /// The declared model, where findings were added to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fallback: Option<FallbackV1>,
    #[serde(default)]
    pub provenance: Map<String, Value>,
    /// What the rows of `sample` have in common.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_of: Option<SampleOfV1>,
    /// Rows of the data of the fit.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sample: Vec<RowV1>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct ChannelV1 {
    name: String,
    unit: String,
    temperature: bool,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct DomainV1 {
    joints: Vec<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    payload: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    time: Option<[f64; 2]>,
    channels: Vec<[f64; 2]>,
    /// Targets that were measured; `null` is the tool's origin.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    targets: Vec<Option<usize>>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct NoiseV1 {
    position_sd: f64,
    orientation_sd: f64,
    /// The part of `position_sd` that rows of one visit share, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    repeatability_sd: Option<f64>,
}

impl From<&FittedModel> for FitV1 {
    fn from(fit: &FittedModel) -> Self {
        let model = fit.model();
        let covariance = fit.covariance();
        let (sample_of, sample) = sample_v1::written(&fit.domain.sample);
        FitV1 {
            format: super::FIT_FORMAT,
            program: super::PROGRAM.into(),
            robot: fit.chain().into(),
            effects: EffectV1::all(model),
            coefficients: CoefficientV1::all(fit),
            covariance: covariance.row_iter().map(|row| row.iter().copied().collect()).collect(),
            channels: fit
                .channels
                .iter()
                .map(|channel| ChannelV1 {
                    name: channel.name.clone(),
                    unit: channel.unit.clone(),
                    temperature: channel.temperature,
                })
                .collect(),
            domain: DomainV1 {
                joints: fit.domain.joints.iter().map(ends).collect(),
                payload: fit.domain.payload.as_ref().map(ends),
                time: fit.domain.time.as_ref().map(ends),
                channels: fit.domain.channels.iter().map(ends).collect(),
                targets: fit.domain.targets.iter().map(|target| target.map(|t| t.0)).collect(),
            },
            noise: NoiseV1 {
                position_sd: fit.noise.position_sd,
                orientation_sd: fit.noise.orientation_sd,
                repeatability_sd: (fit.repeatability_sd > 0.0).then_some(fit.repeatability_sd),
            },
            loads: fit.loads.clone(),
            sessions: fit.sessions.iter().map(SessionV1::from).collect(),
            fallback: fit.fallback.as_ref().map(FallbackV1::from),
            provenance: fit.provenance.clone(),
            sample_of,
            sample,
        }
    }
}

impl FitV1 {
    /// The model that the file holds.
    ///
    /// # Errors
    /// What in the file contradicts itself or is not known here.
    pub fn into_model(self, registry: &EffectRegistry) -> Result<FittedModel, String> {
        let chain = Chain::try_from(self.robot).map_err(|error| error.to_string())?;
        check::names(&chain).map_err(damaged)?;
        check::channels("channels", self.channels.iter().map(|channel| channel.name.as_str()), &chain)
            .map_err(damaged)?;
        if let Some(of) = &self.sample_of {
            let names = of.channels.iter().map(|channel| channel.name.as_str());
            check::channels(check::SAMPLED, names, &chain).map_err(damaged)?;
        }
        check::domain(self.domain.ranges(), &chain, self.channels.len()).map_err(damaged)?;
        check::loads(&self.loads).map_err(damaged)?;
        let effects = self
            .effects
            .into_iter()
            .map(|effect| registry.build(&effect.family, effect.parameters, &chain))
            .collect::<Result<Vec<_>, _>>()
            .map_err(|error| error.to_string())?;
        let model = ErrorModel::new(chain, effects).map_err(|error| error.to_string())?;
        for (number, (column, stored)) in (1..).zip(model.columns().iter().zip(&self.coefficients)) {
            if column.name != stored.name || column.unit != stored.unit {
                return Err(format!(
                    "coefficient {number} is `{}` [{}], but the model of the file has `{}` [{}] there; the file is damaged",
                    stored.name, stored.unit, column.name, column.unit
                ));
            }
        }
        let coefficients: Vec<f64> = self.coefficients.iter().map(|coefficient| coefficient.value).collect();
        let size = self.covariance.len();
        if let Some((row, short)) = (1..).zip(&self.covariance).find(|(_, row)| row.len() != size) {
            return Err(format!(
                "row {row} of the covariance has {} numbers, not {size}; the file is damaged",
                short.len()
            ));
        }
        let covariance = DMatrix::from_row_iterator(size, size, self.covariance.into_iter().flatten());
        check::coefficients(&model, &coefficients).map_err(damaged)?;
        check::covariance(&model, &covariance).map_err(damaged)?;
        if self.noise.position_sd < 0.0 || self.noise.orientation_sd < 0.0 {
            return Err("a standard deviation of `noise` is below zero; the file is damaged".into());
        }
        let repeatability = self.noise.repeatability_sd.unwrap_or(0.0);
        if !(0.0..=self.noise.position_sd).contains(&repeatability) {
            return Err(format!(
                "`repeatability_sd` of `noise` is {repeatability}, not between 0 and `position_sd`; the file is damaged"
            ));
        }
        let fit = FittedModel::new(model, coefficients, covariance).map_err(|error| error.to_string())?;
        let fallback = self.fallback.map(|file| file.into_fallback(fit.chain(), registry)).transpose()?;
        let (joints, targets) = (fit.chain().movable().len(), fit.chain().targets().len());
        if let Some(target) = self.domain.targets.iter().flatten().find(|&&target| target >= targets) {
            return Err(format!(
                "`domain` names target {target}, which the robot does not have; the file is damaged"
            ));
        }
        let sample = match self.sample_of {
            Some(of) => sample_v1::read(of, self.sample, joints, targets)?,
            None => Default::default(),
        };
        let sessions = sessions_v1::read(self.sessions).map_err(damaged)?;
        let channels = self.channels.into_iter().map(|channel| Channel {
            name: channel.name,
            unit: channel.unit,
            temperature: channel.temperature,
        });
        let domain = Domain {
            joints: self.domain.joints.into_iter().map(interval).collect(),
            payload: self.domain.payload.map(interval),
            time: self.domain.time.map(interval),
            by_order: false,
            channels: self.domain.channels.into_iter().map(interval).collect(),
            targets: self.domain.targets.into_iter().map(|target| target.map(TargetId)).collect(),
            sample,
        };
        let noise = NoiseModel {
            position_sd: self.noise.position_sd,
            orientation_sd: self.noise.orientation_sd,
            ..NoiseModel::none()
        };
        Ok(fit
            .with_channels(channels.collect())
            .with_domain(domain)
            .with_noise(noise)
            .with_repeatability(repeatability)
            .with_fallback(fallback)
            .with_loads(self.loads)
            .with_sessions(sessions)
            .with_provenance(self.provenance))
    }
}

impl DomainV1 {
    fn ranges(&self) -> check::Ranges<'_> {
        let DomainV1 { joints, channels, payload, time, .. } = self;
        check::Ranges { joints, channels, payload: *payload, time: *time }
    }
}

fn ends(interval: &Interval) -> [f64; 2] {
    [interval.lower, interval.upper]
}

/// What is said of all that no fit writes.
fn damaged(problem: String) -> String {
    format!("{problem}; the file is damaged, or was edited by hand")
}

fn interval([lower, upper]: [f64; 2]) -> Interval {
    Interval { lower, upper }
}
