//! Whether a prediction lies within what the fit saw: range by range, and by its own variance.
//!
//! ```text
//! V(x) = tr J C Jᵀ                    variance of a predicted position that the coefficients leave open
//! V(x) > max_i V(x_i) / (1 − h_i)     extrapolation: a larger leverage than any row of the fit had, predicted without that row
//! ```
//!
//! | symbol | here | shape | unit | |
//! | --- | --- | --- | --- | --- |
//! | J | `Predictor::sensitivity`, position | 3 × p | m per coefficient | |
//! | C | covariance of the coefficients | p × p | | |
//! | x_i | [`Domain::sample`](super::Domain) | | | rows of the fit |
//! | h_i | V(x_i) / 3σ², at most 0.9 | 1 | 1 | leverage of a row; σ: `Noise::position_sd` |
//!
//! Ranges of single inputs do not see gaps and corners between them; the leverage does (regressor variable hull: Montgomery, Peck and
//! Vining, *Introduction to Linear Regression Analysis*, section 3.8; Cook 1977). A joint counts as beyond from [`SAME_JOINT`] on.

use super::model::{FittedModel, Predicted, Predictor};
use crate::{ModelError, Schema, Signal};
use nalgebra::{Matrix3, Matrix3x6, Vector3};
use truepose_kinematics::{Conditions, Load, Pose, TargetId};

/// Joint values closer than this, rad or m, are one configuration (docs/files.md, section 2).
const SAME_JOINT: f64 = 1e-4;

/// The variance without a row is finite for a row that decides a coefficient alone.
const MOST_LEVERAGE: f64 = 0.9;

/// What of a prediction's inputs the fit never saw.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Beyond {
    /// A joint, by its place among the movable ones.
    Joint(usize),
    /// The mass that is carried.
    Payload,
    /// The time.
    Time,
    /// A channel that the model reads, by its place in the schema.
    Channel(usize),
    /// No input alone: their combination. The variance of the prediction is larger than at any row of the fit.
    Leverage,
}

/// A prediction with what it is worth.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Orientation of the tool and position of the target, m, measurement frame.
    pub pose: Pose,
    /// Covariance of the position that the coefficients leave open, m².
    pub covariance: Matrix3<f64>,
    /// What lies beyond the data of the fit, and by how much: in the input's unit, for [`Beyond::Leverage`] as a ratio of standard
    /// deviations.
    pub beyond: Vec<(Beyond, f64)>,
}

/// How a fit knows where something is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TargetKnown {
    /// It was measured in the data of the fit (or the fit does not say what was).
    Measured,
    /// It is declared, and was not measured.
    Declared,
    /// It was to be found from the data, and the data does not determine it.
    Undetermined,
}

/// Predicts, and holds every prediction against what the fit saw. One for each thread.
#[derive(Debug, Clone)]
pub struct Coverage<'m> {
    fitted: &'m FittedModel,
    predictor: Predictor<'m>,
    /// Channels that the model reads: in the fit's domain, and in the schema.
    read: Vec<(Option<usize>, usize)>,
    timed: bool,
    /// Largest variance at a row of the fit, m²; none where the fit holds no rows.
    widest: Option<f64>,
}

impl<'m> Coverage<'m> {
    /// For conditions of this schema.
    ///
    /// # Errors
    /// When a signal that the model needs is missing, or a channel has another unit than at fit time.
    pub fn new(fitted: &'m FittedModel, schema: &Schema) -> Result<Self, ModelError> {
        let mut read: Vec<(Option<usize>, usize)> = Vec::new();
        let mut timed = false;
        for need in fitted.model().effects().iter().flat_map(|effect| effect.needs()) {
            timed |= need == Signal::Time;
            if let Signal::Channel(name) = need
                && let Some(given) = schema.channel(&name)
                && !read.iter().any(|(_, k)| *k == given)
            {
                read.push((fitted.channels.iter().position(|channel| channel.name == name), given));
            }
        }
        let widest = widest(fitted)?;
        Ok(Coverage { fitted, predictor: fitted.bind(schema)?, read, timed, widest })
    }

    /// The prediction under these conditions, and what of them lies beyond the data of the fit.
    pub fn judge(&mut self, conditions: &Conditions, target: Option<TargetId>) -> Judged {
        let Predicted { pose, covariance, open, .. } = self.predictor.judged(conditions, target.into());
        let mut beyond = self.out_of_range(conditions);
        if let Some(widest) = self.widest
            && open > widest * (1.0 + 1e-9)
        {
            beyond.push((Beyond::Leverage, (open / widest.max(f64::MIN_POSITIVE)).sqrt()));
        }
        Judged { pose, covariance, beyond }
    }

    /// Covariance, m², of a point of the tool at this offset from its origin (m, in the tool's axes) that the coefficients leave open: of the
    /// position of the tool, and of its orientation times the lever.
    ///
    /// ```text
    /// p = t + R o,   C_p = J C Jᵀ,   J = [I  −[R o]ₓ]      C: of [t, rotation vector], 6 × 6
    /// ```
    pub fn covariance_at(&mut self, conditions: &Conditions, offset: &Vector3<f64>) -> Matrix3<f64> {
        let lever = self.predictor.predict(conditions, None).rotation * offset;
        let open = self.predictor.covariance(conditions, None);
        let mut map = Matrix3x6::identity();
        map.fixed_view_mut::<3, 3>(0, 3).copy_from(&-lever.cross_matrix());
        map * open * map.transpose()
    }

    /// The same pose as the nominal robot has it.
    pub fn nominal(&mut self, conditions: &Conditions, target: Option<TargetId>) -> Pose {
        self.predictor.nominal(conditions, target)
    }

    fn out_of_range(&self, conditions: &Conditions) -> Vec<(Beyond, f64)> {
        let domain = &self.fitted.domain;
        let mut beyond = Vec::new();
        if domain.joints.is_empty() {
            return beyond;
        }
        for (k, (range, &q)) in domain.joints.iter().zip(&conditions.joints).enumerate() {
            if range.beyond(q) > SAME_JOINT {
                beyond.push((Beyond::Joint(k), range.beyond(q)));
            }
        }
        let mass = match conditions.load {
            Load::None => Some(0.0),
            Load::Payload(payload) => Some(payload.mass),
            Load::Wrench(_) => None,
        };
        let by = match (mass, &domain.payload) {
            (Some(mass), Some(range)) => range.beyond(mass),
            (Some(mass), None) => mass.abs(),
            (None, _) => 0.0,
        };
        if by > 0.0 {
            beyond.push((Beyond::Payload, by));
        }
        let time = domain.time.as_ref().map_or(0.0, |range| range.beyond(conditions.time));
        if self.timed && time > 0.0 {
            beyond.push((Beyond::Time, time));
        }
        for &(fitted, given) in &self.read {
            let range = fitted.and_then(|k| domain.channels.get(k));
            let by = range.zip(conditions.channels.get(given)).map_or(0.0, |(range, &v)| range.beyond(v));
            if by > 0.0 {
                beyond.push((Beyond::Channel(given), by));
            }
        }
        beyond
    }
}

/// The largest variance of a predicted position at the rows of the fit, each as if it had not been among them, m².
fn widest(fitted: &FittedModel) -> Result<Option<f64>, ModelError> {
    let rows = fitted.domain.sample.rows();
    if rows.is_empty() || fitted.domain.sample.bound(fitted.model()).is_none() {
        return Ok(None);
    }
    let mut predictor = fitted.bind(&rows.schema)?;
    let mut conditions = Conditions::default();
    let noise = 3.0 * fitted.noise.position_sd.powi(2);
    let mut widest: f64 = 0.0;
    for row in (0..rows.len()).filter(|&row| rows.seen(row).position.contains(&true)) {
        rows.conditions_into(row, &mut conditions);
        let variance = predictor.judged(&conditions, rows.target[row].into()).open;
        let leverage = if noise > 0.0 { (variance / noise).min(MOST_LEVERAGE) } else { 0.0 };
        widest = widest.max(variance / (1.0 - leverage));
    }
    Ok(Some(widest))
}

impl FittedModel {
    /// How the position of a target (none: the tool's origin) on the tool is known.
    pub fn target_known(&self, target: Option<TargetId>) -> TargetKnown {
        let seen = &self.domain.targets;
        if seen.is_empty() || seen.contains(&target) {
            return TargetKnown::Measured;
        }
        let chain = self.chain();
        if target.is_some_and(|t| chain.targets().get(t.0).is_some_and(|target| !target.known)) {
            return TargetKnown::Undetermined;
        }
        if target.is_none() && self.fixed_by_points() {
            return TargetKnown::Measured;
        }
        // Declared on the tool: known where the tool is.
        let anchored = chain.tools_known() || self.anchors().next().is_some();
        match self.orientation_known() {
            TargetKnown::Undetermined => TargetKnown::Undetermined,
            _ if !anchored => TargetKnown::Undetermined,
            _ => TargetKnown::Declared,
        }
    }

    /// How the orientation of the tool is known: measured, declared (or fixed by three targets at least), or not at all, where the tool was to
    /// be found from positions alone.
    pub fn orientation_known(&self) -> TargetKnown {
        if self.noise.orientation_sd > 0.0
            || self.domain.sample.rows().orientation.iter().any(Option::is_some)
        {
            return TargetKnown::Measured;
        }
        if self.chain().tools_known() || self.fixed_by_points() {
            TargetKnown::Declared
        } else {
            TargetKnown::Undetermined
        }
    }

    /// Whether the data of the fit determines the place of a target (none: the tool's origin) on the moving tool: it was measured there, or
    /// the orientation of the tool was, by itself or by three points. Otherwise the lever between what was measured and the target turns by an
    /// unknown angle.
    pub fn determines(&self, target: Option<TargetId>) -> bool {
        let seen = &self.domain.targets;
        seen.is_empty() || seen.contains(&target) || self.determines_orientation()
    }

    /// Whether the data of the fit determines the orientation of the tool.
    pub fn determines_orientation(&self) -> bool {
        self.orientation_known() == TargetKnown::Measured || self.fixed_by_points()
    }

    /// Whether measured points of the tool fix its frame: three that do not lie on a line (to a sine of 1e-3).
    fn fixed_by_points(&self) -> bool {
        let points: Vec<Vector3<f64>> = self.anchors().collect();
        points.iter().enumerate().any(|(k, a)| {
            points[k + 1..].iter().any(|b| {
                let (a, b) = (a - points[0], b - points[0]);
                a.cross(&b).norm() > 1e-3 * a.norm() * b.norm()
            })
        })
    }

    /// Points that are declared on the tool and were measured, m, in the tool's axes.
    fn anchors(&self) -> impl Iterator<Item = Vector3<f64>> {
        let chain = self.chain();
        let seen = &self.domain.targets;
        let origin = seen.contains(&None).then(Vector3::zeros);
        let known =
            chain.targets().iter().enumerate().filter(|(k, target)| {
                target.known && (seen.is_empty() || seen.contains(&Some(TargetId(*k))))
            });
        origin.into_iter().chain(known.map(|(_, target)| target.position))
    }
}
