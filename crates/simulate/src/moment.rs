//! One pose measurement as it really is: what hangs on the robot, and where it comes to rest instead of where it was sent.

use crate::flaws::normal;
use crate::rigid::Rigid;
use crate::stream::Stream;
use crate::{Campaign, Plant, SimulateError, Visit};
use nalgebra::{Point3, Vector3};
use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;
use truepose_kinematics::{Conditions, Load, Payload, ToolId};

/// What is drawn once for a pose measurement.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Moment {
    /// When it begins, s.
    pub time: f64,
    /// The true load.
    pub carried: Load,
    /// Deviation of the tool in its own repeatability, m.
    pub shared: Vector3<f64>,
    /// Rotation likewise, rad.
    pub turned: Vector3<f64>,
    /// Further deviation of the pose, m.
    pub away: Vector3<f64>,
    /// Deviation of each joint, rad or m; empty without any.
    pub off_joints: Vec<f64>,
    /// Whether the pose is displaced as a whole.
    pub displaced: bool,
}

/// Where the robot is.
pub(crate) struct Stand {
    /// The tool without repeatability.
    pub tool: Rigid,
    /// The tool where the joints end.
    pub reached: Rigid,
    /// A point of the tool where it really is, m, measurement frame.
    pub at: Vector3<f64>,
}

impl Plant {
    /// What is drawn for each visit of a campaign. The same seed gives the same.
    pub(crate) fn moments(&self, campaign: &Campaign, seed: u64) -> Result<Vec<Moment>, SimulateError> {
        let (disturbed, poses) = (&self.disturbances, campaign.visits.len());
        disturbed.fits(self.chain().movable().len(), poses)?;
        let (mut of_visit, mut of_payload) = (Stream::Visit.of(seed), Stream::Payloads.of(seed));
        let mut of_joint = Stream::Joints.of(seed);
        let wander = disturbed.wander.map(|wander| wander.path(poses, &mut Stream::Wander.of(seed)));
        let displaced = disturbed.displaced_poses(poses, &mut Stream::BadPoses.of(seed));
        let visits = campaign.visits.iter().zip(campaign.times()).enumerate();
        let drawn = visits.map(|(index, (visit, time))| Moment {
            time,
            carried: self.really_carried(visit.load, time, &mut of_payload),
            shared: three(&mut of_visit) * self.repeatability.sd,
            turned: three(&mut of_visit) * self.repeatability.rotation_sd,
            away: wander.as_ref().map_or(Vector3::zeros(), |path| path[index])
                + displaced[index].unwrap_or_default(),
            off_joints: disturbed.joints(&mut of_joint),
            displaced: displaced[index].is_some(),
        });
        Ok(drawn.collect())
    }

    /// The conditions of a visit in which the robot really is, with its joints wound up by so much.
    pub(crate) fn conditions(
        &self,
        visit: &Visit,
        moment: &Moment,
        (approach, wound_up): (&[f64], &[f64]),
    ) -> Conditions {
        Conditions {
            joints: visit.joints.iter().zip(wound_up).map(|(q, off)| q + off).collect(),
            tool: ToolId::FIRST,
            load: moment.carried,
            time: moment.time,
            approach: approach.to_vec(),
            channels: Vec::new(),
        }
    }

    /// Where a point of the tool, m in its axes, is under these conditions.
    pub(crate) fn stand(
        &self,
        conditions: &Conditions,
        moment: &Moment,
        of: &Vector3<f64>,
    ) -> Result<Stand, SimulateError> {
        let tool = self.equilibrium(conditions)?.tool;
        let reached = self.reached(conditions, &moment.off_joints, &tool)?;
        let at = (reached * Point3::from(*of)).coords;
        let off = moment.shared + moment.away + moment.turned.cross(&(at - reached.translation.vector));
        Ok(Stand { tool, reached, at: at + off })
    }

    /// The tool where the joints end with these deviations: `there` without any.
    fn reached(&self, conditions: &Conditions, off: &[f64], there: &Rigid) -> Result<Rigid, SimulateError> {
        if off.is_empty() {
            return Ok(*there);
        }
        let joints = conditions.joints.iter().zip(off).map(|(q, off)| q + off).collect();
        Ok(self.equilibrium(&Conditions { joints, ..conditions.clone() })?.tool)
    }

    /// The true load of the tool when this is declared.
    fn really_carried(&self, declared: Load, time: f64, rng: &mut ChaCha8Rng) -> Load {
        let chance = rng.random::<f64>();
        let Load::Payload(payload) = declared else { return declared };
        let labels = &self.blunders.mislabelled;
        let mass = match labels.iter().find(|(label, _)| (label - payload.mass).abs() < 1e-9) {
            Some((_, real)) => *real,
            None if payload.mass > 0.0 && chance < self.blunders.wrong_payload_share => {
                payload.mass * self.blunders.wrong_payload_factor
            }
            None => payload.mass,
        };
        let stretch = self.blunders.wrong_stretch.filter(|([from, until], label, _)| {
            (*from..*until).contains(&time) && (label - payload.mass).abs() < 1e-9
        });
        let mass = stretch.map_or(mass, |(_, _, factor)| factor * mass);
        Load::Payload(Payload { mass, ..payload })
    }
}

/// Three standard normal numbers.
pub(crate) fn three(rng: &mut impl Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| normal(rng))
}
