//! Rows that could be made at things whose place is known: postures in which the robot touches a socket, a ball or a table, in which a camera of the
//! cell sees the target, or in which a camera on the robot looks at its points.
//!
//! ```text
//! find q:  p(q; c) = a        δ = Jᵀ (J Jᵀ + μ)⁻¹ (a − p),   J by differences
//! ```
//!
//! Each begins at a posture drawn within the joints' ranges, so that a socket is touched from many postures; those that leave the ranges on the way
//! are dropped. Nothing here knows what the robot or the tool would collide with.

use super::options::PlanOptions;
use super::pool::spread;
use super::view::{INSIDE, View};
use crate::IdentifyError;
use crate::landmarks::mounted;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::any::Any;
use truepose_errormodel::descent::{Schedule, descend, difference};
use truepose_errormodel::observation::{Camera, KINDS, Plane, Reading, Sphere};
use truepose_errormodel::{
    Dataset, DatasetBuilder, FittedModel, Landmark, Measurement, Predictor, Surroundings,
};
use truepose_kinematics::{Chain, Conditions, Pose, TargetId};

/// Rows that could be made, and the things of which none could.
#[derive(Debug, Clone, PartialEq)]
pub struct Within {
    /// A visit each; the landmark of a row counts in the surroundings.
    pub rows: Dataset,
    /// Things, by number, that nothing was planned for, and why.
    pub left_out: Vec<(usize, String)>,
}

/// Postures that are tried for each that is wanted.
const TRIES: usize = 20;
/// A point is reached within this, m.
const REACHED: f64 = 1e-7;
/// Largest change of a joint in one step, rad or m.
const STRIDE: f64 = 0.3;
/// Step of a difference, rad or m.
const DIFFERENCE: f64 = 1e-6;

/// Candidates for [`super::plan_observed`]: about `options.pool` rows, as many at each landmark or sensor of which it is said where it is, with each
/// load in turn. `target`: what touches and is seen, the tool's origin when none.
///
/// # Errors
/// When the model needs a signal that planned rows cannot have, or every thing is left out.
pub fn within_reach(
    fitted: &FittedModel,
    surroundings: &Surroundings,
    target: Option<TargetId>,
    options: &PlanOptions,
) -> Result<Within, IdentifyError> {
    let chain = fitted.chain();
    let mut left_out = Vec::new();
    let mut things = Vec::new();
    // With a camera on the robot points of known place are there to be seen.
    let looks = surroundings.landmarks.iter().any(|thing| thing.mount.is_some());
    for (k, thing) in surroundings.landmarks.iter().enumerate() {
        if looks && thing.known && thing.observed.is_none() {
            continue;
        }
        match aim(thing, surroundings, fitted) {
            Ok(aim) => things.push((k, aim)),
            Err(why) => left_out.push((k, why)),
        }
    }
    let mut random = ChaCha8Rng::seed_from_u64(options.seed ^ 0x7e11);
    let each = options.pool.div_ceil(things.len().max(1));
    let mut errand = Errand::new(fitted, target)?;
    let mut builder = DatasetBuilder::new(chain).channels(fitted.channels.clone());
    let (mut landmarks, mut kinds, mut points) = (Vec::new(), Vec::new(), Vec::new());
    let mut visits = 0;
    for (number, (k, aim)) in things.iter().enumerate() {
        let seed = options.seed.wrapping_add(number as u64);
        let pool = spread(fitted, &PlanOptions { pool: TRIES * each, seed, ..options.clone() });
        let found = pool.into_iter().filter_map(|start| errand.brought(start, aim, &mut random));
        let observed = surroundings.landmarks[*k].observed.as_ref();
        let kind = observed.and_then(|of| KINDS.iter().position(|word| *word == of.kind()));
        let before = visits;
        for (conditions, seen) in found.take(each) {
            for point in seen {
                let target = target.filter(|_| point.is_none());
                let row = Measurement::at(conditions.joints.clone())
                    .load(conditions.load)
                    .approach(conditions.approach.clone())
                    .time(conditions.time)
                    .channels(conditions.channels.clone())
                    .visit(visits)
                    .position([0.0; 3])
                    .tool(conditions.tool)
                    .target(target);
                builder.push(row)?;
                landmarks.push(Some(*k));
                points.push(point);
                kinds.push(kind.map_or(0.0, |kind| (kind + 1) as f64));
            }
            visits += 1;
        }
        if visits == before {
            left_out.push((*k, "no posture within the joints' ranges brings the robot there".into()));
        }
    }
    let count = landmarks.len();
    if count == 0 {
        return Err(nothing(surroundings, &left_out));
    }
    let mut rows = builder.finish();
    rows.line = (1..=count as u64).collect();
    rows.set_landmarks(Some(&landmarks));
    rows.set_points(points.iter().any(Option::is_some).then_some(&points));
    let any = kinds.iter().any(|kind| *kind > 0.0);
    let numbers = || any.then(|| vec![0.0; count]);
    rows.set_kinds(any.then_some(kinds), [numbers(), numbers(), numbers()]);
    Ok(Within { rows, left_out })
}

/// Why there are no rows: one reason after the other, with the things that it holds for.
fn nothing(surroundings: &Surroundings, left_out: &[(usize, String)]) -> IdentifyError {
    let mut reasons: Vec<(&str, Vec<&str>)> = Vec::new();
    for (k, why) in left_out {
        let name = surroundings.landmarks[*k].name.as_str();
        match reasons.iter_mut().find(|(known, _)| known == why) {
            Some((_, names)) => names.push(name),
            None => reasons.push((why, vec![name])),
        }
    }
    let words = |(why, names): &(&str, Vec<&str>)| format!("{}: {why}", names.join(", "));
    let why = match reasons.is_empty() {
        true => "the robot is described without landmarks and sensors".into(),
        false => format!(
            "no row can be planned at its landmarks and sensors: {}",
            reasons.iter().map(words).collect::<Vec<_>>().join("; ")
        ),
    };
    IdentifyError::Observations { why }
}

/// Where the robot goes to observe a thing.
enum Aim {
    /// To this point, m, measurement frame.
    Point(Vector3<f64>),
    /// To a ball of this centre and radius, from above, m.
    Ball(Vector3<f64>, f64),
    /// To the nearest point of a plane: normal, and a point of it, m.
    Plane(Vector3<f64>, Vector3<f64>),
    /// Anywhere from where it is seen.
    Seen(Box<Landmark>),
    /// To where a camera on the robot sees its points.
    View(Box<View>),
}

/// Where the robot goes for a thing, or why nobody can say.
fn aim(thing: &Landmark, surroundings: &Surroundings, fitted: &FittedModel) -> Result<Aim, String> {
    const UNKNOWN: &str = "it is not said where it is";
    if let Some(mount) = &thing.mount {
        let view = View::of(thing, mounted(fitted.chain(), mount), surroundings, fitted)?;
        return Ok(Aim::View(Box::new(view)));
    }
    let Some(observed) = &thing.observed else {
        return thing.position.map(Aim::Point).ok_or_else(|| UNKNOWN.into());
    };
    if !observed.placed() {
        return Err(UNKNOWN.into());
    }
    let any = &**observed as &dyn Any;
    if let Some(ball) = any.downcast_ref::<Sphere>() {
        let radius = ball.radius.ok_or("its radius is not said")?;
        return Ok(Aim::Ball(ball.centre.unwrap_or_default(), radius));
    }
    if let Some(Plane { normal: Some(normal), point: Some(point), .. }) = any.downcast_ref::<Plane>() {
        return Ok(Aim::Plane(normal.normalize(), *point));
    }
    Ok(Aim::Seen(Box::new(thing.clone())))
}

/// Bringing the robot somewhere, with memory that is used again.
struct Errand<'m> {
    chain: &'m Chain,
    predictor: Predictor<'m>,
    target: Option<TargetId>,
    limits: Vec<Option<(f64, f64)>>,
    reading: Reading,
}

impl<'m> Errand<'m> {
    fn new(fitted: &'m FittedModel, target: Option<TargetId>) -> Result<Self, IdentifyError> {
        let chain = fitted.chain();
        Ok(Errand {
            chain,
            predictor: fitted.bind(&super::accuracy::schema(fitted))?,
            target,
            limits: chain.movable().iter().map(|&joint| chain.controller_limits(joint)).collect(),
            reading: Reading::default(),
        })
    }

    /// The conditions with joints with which the robot observes a thing, begun at these, and the points that it sees, or none of them; nothing where it
    /// does not get there.
    fn brought(
        &mut self,
        start: Conditions,
        aim: &Aim,
        random: &mut ChaCha8Rng,
    ) -> Option<(Conditions, Vec<Option<usize>>)> {
        let target = self.target;
        let touch = Reach { target, of: Vector3::zeros(), point: Vector3::zeros() };
        let reach = match aim {
            Aim::Point(point) => Reach { point: *point, ..touch },
            Aim::Ball(centre, radius) => Reach { point: centre + above(random) * *radius, ..touch },
            Aim::Plane(normal, point) => {
                let at = self.predictor.predict(&start, target).translation;
                Reach { point: at - normal * normal.dot(&(at - point)), ..touch }
            }
            Aim::Seen(thing) => {
                let at = self.predictor.predict(&start, target);
                return self.seen(&at, thing).then(|| (start, vec![None]));
            }
            Aim::View(view) => {
                let start = Conditions { tool: view.tool, ..start };
                let reach = Reach { target: None, of: view.ahead(random), point: view.middle };
                let end = self.reached(start, &reach)?;
                let at = self.predictor.predict(&end, None);
                let points = view.seen(&at, &mut self.reading)?;
                return Some((end, points.into_iter().map(Some).collect()));
            }
        };
        Some((self.reached(start, &reach)?, vec![None]))
    }

    /// Whether a sensor of the cell reads something there; a camera within its image.
    fn seen(&mut self, at: &Pose, thing: &Landmark) -> bool {
        let Some(observed) = &thing.observed else { return false };
        if !observed.read(at, &mut self.reading) {
            return false;
        }
        let camera = (&**observed as &dyn Any).downcast_ref::<Camera>();
        let Some(size) = camera.and_then(|camera| camera.size) else { return true };
        let inside = |(value, size): (&f64, f64)| (value / size - 0.5).abs() <= 0.5 * INSIDE;
        self.reading.value.iter().zip(size).all(inside)
    }

    /// The conditions with joints with which it is there.
    fn reached(&mut self, start: Conditions, reach: &Reach) -> Option<Conditions> {
        const SCHEDULE: Schedule = Schedule {
            first: 1e-4,
            good: (0.1, 1e-9),
            bad: (10.0, 1.0),
            steps: 40,
            patience: (3, 8),
            flat: 1e-16,
            gain: difference,
        };
        let away = |errand: &mut Self, at: &Conditions| {
            reach.point - errand.predictor.predict(at, reach.target).apply(&reach.of)
        };
        let first = away(self, &start);
        let (end, left) = descend(
            ((start, first), first.norm_squared()),
            &SCHEDULE,
            |(at, left), damping| {
                let mut jacobian = DMatrix::zeros(3, at.joints.len());
                for k in 0..at.joints.len() {
                    let mut moved = at.clone();
                    moved.joints[k] += DIFFERENCE;
                    jacobian.set_column(k, &((left - away(self, &moved)) / DIFFERENCE));
                }
                let square = &jacobian * jacobian.transpose();
                let square: Matrix3<f64> = square.fixed_view::<3, 3>(0, 0) + Matrix3::identity() * damping;
                let step: DVector<f64> = jacobian.transpose() * (square.try_inverse()? * left);
                let shrink = (STRIDE / step.amax().max(STRIDE)).min(1.0);
                let mut next = at.clone();
                next.joints.iter_mut().zip(step.iter()).for_each(|(q, by)| *q += shrink * by);
                let left = away(self, &next);
                Some(((next, left), left.norm_squared()))
            },
            |next| next,
        );
        let mut counted = end.0.joints.clone();
        self.chain.joints_to_controller(&mut counted);
        let within = |(q, limits): (&f64, &Option<(f64, f64)>)| {
            limits.is_none_or(|(lower, upper)| (lower..=upper).contains(q))
        };
        (left.sqrt() < REACHED && counted.iter().zip(&self.limits).all(within)).then_some(end.0)
    }
}

/// A point of the tool, in its axes at the target, and where it is brought to, measurement frame, m.
#[derive(Clone, Copy)]
struct Reach {
    target: Option<TargetId>,
    of: Vector3<f64>,
    point: Vector3<f64>,
}

/// A direction of the upper half, equally likely everywhere.
fn above(random: &mut impl Rng) -> Vector3<f64> {
    let z: f64 = random.random();
    let (sine, cosine) = (std::f64::consts::TAU * random.random::<f64>()).sin_cos();
    let across = (1.0 - z * z).sqrt();
    Vector3::new(across * cosine, across * sine, z)
}
