//! A fitted model: evaluated without the data, the solver or the reduction that made it.

use super::domain::Domain;
use super::fallback::{between, share};
use super::installed::Installed;
use super::load_correction::LoadCorrection;
use super::spread::PositionSpread;
use crate::effects::Instrument;
use crate::noise::NoiseModel;
use crate::{
    Aim, BoundModel, Channel, Effect, Equilibrium, ErrorJacobian, ErrorModel, GeneralizedErrors, ModelError,
    Schema,
};
use nalgebra::{DMatrix, Matrix3, Matrix6};
use truepose_kinematics::{Chain, Conditions, Load, Pose, PostureBuffer, TargetId};

/// An error model with coefficients, how well they are known, and where they were seen.
#[derive(Debug, Clone)]
pub struct FittedModel {
    model: ErrorModel,
    coefficients: Vec<f64>,
    covariance: DMatrix<f64>,
    /// Channels at fit time, with their units: the same have to be there at run time.
    pub channels: Vec<Channel>,
    /// The inputs on which it was fitted.
    pub domain: Domain,
    /// Standard deviations of one component of a new measurement around the model, with what the rows of a visit share; `visit_sd` is zero.
    pub noise: NoiseModel,
    /// The part of `noise.position_sd` that rows of one visit share, the robot's repeatability, m; zero where it is not known.
    pub repeatability_sd: f64,
    /// The declared model, where findings were added to it: predictions beyond their data fall back to it.
    pub fallback: Option<Fallback>,
    /// Payloads that are declared wrongly: what is declared, and what is carried.
    pub loads: Vec<LoadCorrection>,
    /// The installations in which it was fitted, the first one first; empty where it is one.
    pub sessions: Vec<Installed>,
    /// How it came about, for people: program, data, options. Not needed for evaluation.
    pub provenance: serde_json::Map<String, serde_json::Value>,
}

/// The declared model as a fallback, and when it counts; the formulas are in `fitted/fallback.rs`.
#[derive(Debug, Clone)]
pub struct Fallback {
    /// The declared model, fitted alone to the same data.
    pub declared: std::sync::Arc<FittedModel>,
    /// Variance of a predicted position up to which the findings count in full, m²; 95 % of the rows of the fit are below.
    pub usual: f64,
    /// By how much more they count half, m²; infinite: they count everywhere.
    pub scale: f64,
    /// Mean square by which the findings move the rows of the fit, m².
    pub size: f64,
}

impl Fallback {
    /// Share of the findings, of the variance of a predicted position, m².
    pub fn weight(&self, variance: f64) -> f64 {
        share(variance, self.usual, self.scale)
    }
}

impl FittedModel {
    /// From coefficients c (one a column of the model) and their covariance.
    ///
    /// # Errors
    /// When the sizes do not fit.
    pub fn new(
        model: ErrorModel,
        coefficients: Vec<f64>,
        covariance: DMatrix<f64>,
    ) -> Result<Self, ModelError> {
        let need = model.columns().len();
        if coefficients.len() != need {
            return Err(ModelError::Shape { what: "coefficients", have: coefficients.len(), need });
        }
        if covariance.shape() != (need, need) {
            return Err(ModelError::Shape { what: "covariance", have: covariance.nrows(), need });
        }
        Ok(FittedModel {
            model,
            coefficients,
            covariance,
            channels: Vec::new(),
            domain: Domain::default(),
            noise: NoiseModel::none(),
            repeatability_sd: 0.0,
            fallback: None,
            loads: Vec::new(),
            sessions: Vec::new(),
            provenance: serde_json::Map::new(),
        })
    }

    /// With the channels of the data of the fit.
    pub fn with_channels(self, channels: Vec<Channel>) -> Self {
        FittedModel { channels, ..self }
    }

    /// With the inputs on which it was fitted.
    pub fn with_domain(self, domain: Domain) -> Self {
        FittedModel { domain, ..self }
    }

    /// With the noise of a new measurement around the model.
    pub fn with_noise(self, noise: NoiseModel) -> Self {
        FittedModel { noise, ..self }
    }

    /// With the part of the noise that rows of one visit share, m.
    pub fn with_repeatability(self, repeatability_sd: f64) -> Self {
        FittedModel { repeatability_sd, ..self }
    }

    /// With a model to which predictions fall back beyond the data of the fit.
    pub fn with_fallback(self, fallback: Option<Fallback>) -> Self {
        FittedModel { fallback, ..self }
    }

    /// With payloads that are declared wrongly.
    pub fn with_loads(self, loads: Vec<LoadCorrection>) -> Self {
        FittedModel { loads, ..self }
    }

    /// With the installations in which it was fitted.
    pub fn with_sessions(self, sessions: Vec<Installed>) -> Self {
        FittedModel { sessions, ..self }
    }

    /// With what another fit of the same robot has besides its model: domain, noise, channels, loads, record; its sessions are left behind.
    pub(super) fn like(self, other: &FittedModel) -> Self {
        let FittedModel { model, coefficients, covariance, .. } = self;
        FittedModel { model, coefficients, covariance, sessions: Vec::new(), ..other.clone() }
    }

    /// With the record of how it came about.
    pub fn with_provenance(self, provenance: serde_json::Map<String, serde_json::Value>) -> Self {
        FittedModel { provenance, ..self }
    }

    /// The robot alone, without the errors of instrument and log: what commands, maps and exported geometry correct.
    #[must_use]
    pub fn of_robot(self) -> Self {
        self.only(|family| family != Instrument::FAMILY)
    }

    /// The effects of these families alone: the coefficients of all others are zero and known to be.
    #[must_use]
    pub fn only(mut self, family: impl Fn(&str) -> bool) -> Self {
        let other = |&column: &usize| !family(self.model.effects()[self.model.effect_of(column)].kind());
        for column in (0..self.coefficients.len()).filter(other).collect::<Vec<_>>() {
            self.coefficients[column] = 0.0;
            self.covariance.row_mut(column).fill(0.0);
            self.covariance.column_mut(column).fill(0.0);
        }
        self
    }

    /// The same with another covariance of the coefficients; everything else stays.
    ///
    /// # Errors
    /// When its size does not fit.
    pub fn with_covariance(self, covariance: DMatrix<f64>) -> Result<Self, ModelError> {
        let need = self.model.columns().len();
        if covariance.shape() != (need, need) {
            return Err(ModelError::Shape { what: "covariance", have: covariance.nrows(), need });
        }
        Ok(FittedModel { covariance, ..self })
    }

    /// The same errors on another description of the robot: another base, tool or targets.
    ///
    /// # Errors
    /// When an effect does not fit it, or it has other unknowns.
    pub fn on(&self, chain: Chain) -> Result<Self, ModelError> {
        let fallback = match &self.fallback {
            Some(known) => {
                let declared = std::sync::Arc::new(known.declared.on(chain.clone())?);
                Some(Fallback { declared, ..known.clone() })
            }
            None => None,
        };
        let model = self.model.on(chain)?;
        let need = model.columns().len();
        if need != self.coefficients.len() {
            return Err(ModelError::Shape { what: "coefficients", have: self.coefficients.len(), need });
        }
        Ok(FittedModel { model, fallback, ..self.clone() })
    }

    /// The model.
    pub fn model(&self) -> &ErrorModel {
        &self.model
    }

    /// The robot.
    pub fn chain(&self) -> &Chain {
        self.model.chain()
    }

    /// Coefficients c, one a column of the model, in its unit.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// Covariance of the coefficients; rows and columns of those that the reduction left out are zero.
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

    /// The load that is carried at a time (s) where this one is declared. A correction of a stretch of time is preferred.
    pub fn carried(&self, declared: Load, time: f64) -> Load {
        let of = |stretch: bool| {
            let mut loads =
                self.loads.iter().filter(move |correction| correction.during.is_some() == stretch);
            loads.find_map(|correction| correction.apply(declared, time))
        };
        of(true).or_else(|| of(false)).unwrap_or(declared)
    }

    /// Ready to predict under conditions of this schema.
    ///
    /// # Errors
    /// When a signal that the model needs is missing, or a channel has another unit than at fit time.
    pub fn bind(&self, schema: &Schema) -> Result<Predictor<'_>, ModelError> {
        for channel in &self.channels {
            if let Some(k) = schema.channel(&channel.name)
                && schema.channels[k].unit != channel.unit
                && self
                    .model
                    .effects()
                    .iter()
                    .any(|effect| effect.needs().contains(&crate::Signal::Channel(channel.name.clone())))
            {
                return Err(ModelError::ChannelUnit {
                    channel: channel.name.clone(),
                    have: schema.channels[k].unit.clone(),
                    need: channel.unit.clone(),
                });
            }
        }
        Ok(Predictor {
            fitted: self,
            bound: self.model.bind(schema)?,
            nominal: PostureBuffer::new(self.chain()),
            rest: Equilibrium::new(&self.model),
            rows: DMatrix::zeros(6, self.coefficients.len()),
            spread: self.fallback.is_some().then(|| PositionSpread::new(&self.covariance)),
            stands: false,
            conditions: Conditions {
                joints: vec![0.0; self.chain().movable().len()],
                approach: vec![0.0; self.chain().movable().len()],
                channels: vec![0.0; schema.channels.len()],
                ..Conditions::default()
            },
            declared: match &self.fallback {
                Some(fallback) => Some(Box::new(fallback.declared.bind(schema)?)),
                None => None,
            },
        })
    }
}

/// A prediction and what it is worth.
#[derive(Debug, Clone, Copy)]
pub(super) struct Predicted {
    pub pose: Pose,
    /// Of the position, m².
    pub covariance: Matrix3<f64>,
    /// Variance that the coefficients leave open of the position with every finding, m².
    pub open: f64,
    /// Share of the findings.
    pub weight: f64,
}

/// Evaluates a fitted model, posture after posture, without allocating.
#[derive(Debug, Clone)]
pub struct Predictor<'m> {
    fitted: &'m FittedModel,
    bound: BoundModel<'m>,
    nominal: PostureBuffer,
    rest: Equilibrium,
    /// [`Predictor::sensitivity`] of the last posture that was judged.
    rows: DMatrix<f64>,
    /// Made when the first posture is judged; of a fit with a fallback, all of whose postures are, at once.
    spread: Option<PositionSpread>,
    /// Those under which it stands, with the load that it carries.
    conditions: Conditions,
    /// Whether it was brought to rest under these.
    stands: bool,
    /// Of the fallback.
    declared: Option<Box<Predictor<'m>>>,
}

impl Predictor<'_> {
    /// The real robot under these conditions: orientation of the tool, position of the target (none: of the tool's
    /// origin), in the measurement frame; of two points that met the difference of [`Aim`]. Beyond the data of the fit it falls back to the declared model, where the fit has one.
    pub fn predict(&mut self, conditions: &Conditions, aim: impl Into<Aim>) -> Pose {
        let aim = aim.into();
        if self.fitted.fallback.is_some() {
            return self.judged(conditions, aim).pose;
        }
        self.settle(conditions);
        self.found(aim)
    }

    /// With every finding, at the last conditions.
    fn found(&self, aim: Aim) -> Pose {
        let real = self.rest.real();
        let point = real.point(self.fitted.chain(), self.rest.errors(), aim);
        Pose::new(real.tool().rotation, point)
    }

    /// The prediction with its covariance, and what the coefficients leave open of it with every finding.
    pub(super) fn judged(&mut self, conditions: &Conditions, aim: Aim) -> Predicted {
        self.differentiate(conditions, aim);
        let found = self.found(aim);
        let spread = self.spread.get_or_insert_with(|| PositionSpread::new(&self.fitted.covariance));
        let covariance = spread.of(&self.rows);
        let open = covariance.trace();
        let weight = self.fitted.fallback.as_ref().map_or(1.0, |fallback| fallback.weight(open));
        let (Some(declared), Some(fallback)) = (&mut self.declared, &self.fitted.fallback) else {
            return Predicted { pose: found, covariance, open, weight };
        };
        if weight >= 1.0 {
            return Predicted { pose: found, covariance, open, weight };
        }
        let pose = between(&declared.predict(conditions, aim), &found, weight);
        let missed = (1.0 - weight).powi(2) * fallback.size / 3.0;
        let covariance = covariance * (weight * weight) + Matrix3::identity() * missed;
        Predicted { pose, covariance, open, weight }
    }

    /// The share of the findings in the prediction under these conditions: one within the data of the fit.
    pub fn share_of_findings(&mut self, conditions: &Conditions, target: Option<TargetId>) -> f64 {
        if self.fitted.fallback.is_some() { self.judged(conditions, target.into()).weight } else { 1.0 }
    }

    /// The same pose as the nominal robot has it.
    pub fn nominal(&mut self, conditions: &Conditions, target: Option<TargetId>) -> Pose {
        let chain = self.fitted.chain();
        let posture = self.nominal.update(chain, conditions);
        let tool = posture.tool();
        let point = target.map_or(tool.translation, |t| tool.apply(&chain.targets()[t.0].position));
        Pose::new(tool.rotation, point)
    }

    /// How the prediction with every finding moves with each coefficient: `J_e Φ`, 6 × p, rows `[x y z rx ry rz]`, m or rad (measurement frame).
    pub fn sensitivity(&mut self, conditions: &Conditions, target: Option<TargetId>) -> DMatrix<f64> {
        self.differentiate(conditions, target.into());
        self.rows.clone()
    }

    /// Fills `rows`, without allocating.
    fn differentiate(&mut self, conditions: &Conditions, aim: Aim) {
        self.settle(conditions);
        let (chain, rest) = (self.fitted.chain(), &self.rest);
        let jacobian = ErrorJacobian::new(chain, rest.real(), rest.errors(), aim);
        let rows = &mut self.rows;
        rows.fill(0.0);
        for entry in rest.emission().entries() {
            let mut column = rows.column_mut(entry.column);
            let (p, r) = (jacobian.position(entry.site), jacobian.rotation(entry.site));
            for k in 0..3 {
                column[k] += entry.value * p[k];
                column[k + 3] += entry.value * r[k];
            }
        }
    }

    /// Covariance of `[x y z rx ry rz]` (m, rad, measurement frame) with every finding, from the coefficients alone: `J_e Φ C (J_e Φ)ᵀ`.
    pub fn covariance(&mut self, conditions: &Conditions, target: Option<TargetId>) -> Matrix6<f64> {
        let rows = self.sensitivity(conditions, target);
        let spread = &rows * &self.fitted.covariance * rows.transpose();
        Matrix6::from_iterator(spread.iter().copied())
    }

    /// [`Predictor::predict`], and the covariance of its position (m²), with that of the findings that it lacks where it falls back.
    pub fn with_covariance(&mut self, conditions: &Conditions, aim: impl Into<Aim>) -> (Pose, Matrix3<f64>) {
        let Predicted { pose, covariance, .. } = self.judged(conditions, aim.into());
        (pose, covariance)
    }

    /// The generalized errors under these conditions.
    pub fn errors(&mut self, conditions: &Conditions) -> &GeneralizedErrors {
        self.settle(conditions);
        self.rest.errors()
    }

    fn settle(&mut self, conditions: &Conditions) {
        let load = self.fitted.carried(conditions.load, conditions.time);
        // Several targets are looked at from one standstill: the robot is brought to rest once.
        if self.stands && self.conditions.load == load && self.bound.reads_same(&self.conditions, conditions)
        {
            return;
        }
        self.conditions.clone_from(conditions);
        self.conditions.load = load;
        self.stands = true;
        self.rest.settle(&self.bound, &self.conditions, &self.fitted.coefficients);
    }
}
