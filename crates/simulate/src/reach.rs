//! Joints with which the real robot is where it is observed.
//!
//! ```text
//! find q:  p(q) = a        δ = Jᵀ (J Jᵀ + λ)⁻¹ (a − p),   J by differences
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | p | where a point of the real robot comes to rest, its repeatability included | m, measurement frame |
//! | a | [`Aim::at`] | m, measurement frame |
//! | q | values that the controller counts | rad, m |
//!
//! The robot that touches is the true one, not the one as described: so the joints of a touched socket have all of its errors in them. Each
//! visit begins at a posture drawn within the limits, so that a socket is touched from many postures. Where a joint ends depends on
//! the direction from which it comes, and with friction or creep on all poses before: the campaign is gone through until nothing moves.

use crate::campaign::{limits, variables};
use crate::cell::{Aim, Thing};
use crate::moment::Moment;
use crate::stream::Stream;
use crate::{Campaign, Plant, SimulateError, Task, Visit};
use nalgebra::{DMatrix, Matrix3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::borrow::Cow;
use truepose_kinematics::TargetId;

/// Postures that are tried for one observation.
const TRIES: usize = 1000;
/// Steps towards one point.
const STEPS: usize = 30;
/// Largest change of a joint in one step, rad or m.
const STRIDE: f64 = 0.3;
/// λ, m²: what a step through a singular posture is damped by.
const DAMPING: f64 = 1e-6;
/// Step of a difference, rad or m.
const DIFFERENCE: f64 = 1e-6;
/// A point is reached within this, m.
const REACHED: f64 = 1e-10;
/// How often the campaign is gone through: each time the changes are those that a change of path makes.
const PASSES: usize = 12;

/// One visit's aim, and what the joints are beside it.
struct Errand<'m> {
    visit: Visit,
    moment: &'m Moment,
    thing: &'m Thing,
    of: Vector3<f64>,
    aim: Option<Aim>,
    approach: Vec<f64>,
    wound_up: Vec<f64>,
}

impl Plant {
    /// The thing of a number.
    pub(crate) fn thing(&self, number: usize) -> Result<&Thing, SimulateError> {
        let have = self.cell.things.len();
        let shape = SimulateError::Shape { what: "things of the cell", have, need: number + 1 };
        self.cell.things.get(number).ok_or(shape)
    }

    /// The campaign with joints with which the real robot is where it is observed.
    pub(crate) fn reaching<'c>(
        &self,
        campaign: &'c Campaign,
        moments: &[Moment],
        seed: u64,
    ) -> Result<Cow<'c, Campaign>, SimulateError> {
        let tasks = |visit: &Visit| visit.task != Task::Positions;
        if !campaign.visits.iter().any(tasks) {
            return Ok(Cow::Borrowed(campaign));
        }
        let limits = limits(self.chain())?;
        let mut campaign = campaign.clone();
        let mut rng = Stream::Aims.of(seed);
        let mut aims = vec![None; campaign.visits.len()];
        for pass in 0..PASSES {
            // At first neither the directions nor the path are known.
            let movable = self.chain().movable().len();
            let nothing = || vec![vec![0.0; movable]; campaign.visits.len()];
            let (approaches, wound_up) = match pass {
                0 => (nothing(), nothing()),
                _ => (campaign.approaches(), self.path_errors(&campaign)?),
            };
            let mut farthest = 0.0f64;
            for (index, moment) in moments.iter().enumerate() {
                let Task::Observed { thing, target } = campaign.visits[index].task else { continue };
                let mut errand = Errand {
                    visit: campaign.visits[index].clone(),
                    moment,
                    thing: self.thing(thing)?,
                    of: self.true_target(target)?,
                    aim: aims[index],
                    approach: approaches[index].clone(),
                    wound_up: wound_up[index].clone(),
                };
                match (pass, errand.aim) {
                    (0, _) => aims[index] = self.posture(&mut errand, &limits, &mut rng)?,
                    (_, Some(aim)) => {
                        farthest = farthest.max(self.away(&errand, &aim)?.norm());
                        if !self.brought(&mut errand, &aim, &limits)? {
                            return Err(self.not_reached(&errand));
                        }
                    }
                    (_, None) => {}
                }
                campaign.visits[index].joints = errand.visit.joints;
            }
            if pass > 0 && farthest < 10.0 * REACHED {
                return Ok(Cow::Owned(campaign));
            }
        }
        Err(SimulateError::Restless)
    }

    /// A posture of one errand, from nothing, and where it was aimed.
    fn posture(
        &self,
        errand: &mut Errand<'_>,
        limits: &[(f64, f64)],
        rng: &mut ChaCha8Rng,
    ) -> Result<Option<Aim>, SimulateError> {
        let (up, time) = (self.up(), errand.moment.time);
        for _ in 0..TRIES {
            let drawn = limits.iter().map(|(lower, upper)| lower + (upper - lower) * rng.random::<f64>());
            errand.visit.joints = variables(self.chain(), vec![drawn.collect()]).swap_remove(0);
            let aim = errand.thing.aim(time, &up, rng);
            if let Some(aim) = &aim
                && !self.brought(errand, aim, limits)?
            {
                continue;
            }
            if self.keeps(errand)? {
                return Ok(aim);
            }
        }
        Err(self.not_reached(errand))
    }

    fn keeps(&self, errand: &Errand<'_>) -> Result<bool, SimulateError> {
        let at = |of: Vector3<f64>| {
            let beside = (errand.approach.as_slice(), errand.wound_up.as_slice());
            self.stand(&self.conditions(&errand.visit, errand.moment, beside), errand.moment, &of)
        };
        let targets = errand.thing.targets.iter().map(|&target: &Option<TargetId>| {
            let of = self.true_target(target)?;
            Ok(at(of)?.at)
        });
        let targets = targets.collect::<Result<Vec<Vector3<f64>>, SimulateError>>()?;
        Ok(errand.thing.keeps(errand.moment.time, &at(Vector3::zeros())?.reached, &targets))
    }

    /// How far the robot is from where it is aimed, m.
    fn away(&self, errand: &Errand<'_>, aim: &Aim) -> Result<Vector3<f64>, SimulateError> {
        let beside = (errand.approach.as_slice(), errand.wound_up.as_slice());
        let conditions = self.conditions(&errand.visit, errand.moment, beside);
        Ok(aim.at - self.stand(&conditions, errand.moment, &aim.of.unwrap_or(errand.of))?.at)
    }

    /// Moves the joints until the robot is there; false where it does not get there within its limits.
    fn brought(
        &self,
        errand: &mut Errand<'_>,
        aim: &Aim,
        limits: &[(f64, f64)],
    ) -> Result<bool, SimulateError> {
        let chain = self.chain();
        let mut counted = errand.visit.joints.clone();
        chain.joints_to_controller(&mut counted);
        let put = |errand: &mut Errand<'_>, counted: &[f64]| {
            errand.visit.joints = counted.to_vec();
            chain.joints_from_controller(&mut errand.visit.joints);
        };
        for _ in 0..STEPS {
            let away = self.away(errand, aim)?;
            if away.norm() < REACHED {
                return Ok(counted
                    .iter()
                    .zip(limits)
                    .all(|(q, (lower, upper))| (lower..=upper).contains(&q)));
            }
            let mut jacobian = DMatrix::zeros(3, counted.len());
            for k in 0..counted.len() {
                let mut moved = counted.clone();
                moved[k] += DIFFERENCE;
                put(errand, &moved);
                let column = (away - self.away(errand, aim)?) / DIFFERENCE;
                jacobian.set_column(k, &column);
            }
            let square = &jacobian * jacobian.transpose();
            let square: Matrix3<f64> = square.fixed_view::<3, 3>(0, 0) + Matrix3::identity() * DAMPING;
            let Some(inverse) = square.try_inverse() else { return Ok(false) };
            let step = jacobian.transpose() * (inverse * away);
            let shrink = (STRIDE / step.amax().max(STRIDE)).min(1.0);
            counted.iter_mut().zip(step.iter()).for_each(|(q, by)| *q += shrink * by);
            put(errand, &counted);
        }
        Ok(false)
    }

    fn not_reached(&self, errand: &Errand<'_>) -> SimulateError {
        let name = self.cell.names.get(errand.thing.number).cloned().unwrap_or_default();
        SimulateError::OutOfReach { name, tries: TRIES }
    }
}
