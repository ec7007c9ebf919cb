//! One plant: measured, identified, and executing commands; and the commands of its model compared with the model.

use super::robots::{Measured, Robot};
use crate::prelude::*;
use truepose_compensate::predicted_error;
use truepose_errormodel::Schema;
use truepose_kinematics::rotation_log;

/// An identified plant.
pub struct Trial {
    measured: Measured,
    pub fitted: FittedModel,
    payload: Load,
}

/// How far from the desired positions the plant ended, m.
pub struct Executed {
    /// Root mean square without compensation, and with it; without what differs each time.
    pub before: f64,
    pub after: f64,
    /// Largest of the latter.
    pub after_max: f64,
    /// Root mean square of what differs each time.
    pub repeatability: f64,
    pub ok: usize,
    pub of: usize,
    /// Of the locked rows as they were measured: how many, and how many lie within the 95 % band.
    pub rows: usize,
    pub within: usize,
}

impl Executed {
    /// Distance from the desired position with everything, over the robot's repeatability.
    pub fn ratio(&self) -> f64 {
        self.after.hypot(self.repeatability) / self.repeatability
    }

    /// The same without compensation.
    pub fn ratio_before(&self) -> f64 {
        self.before.hypot(self.repeatability) / self.repeatability
    }
}

/// What became of many poses.
#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    pub ok: usize,
    pub unreachable: usize,
    pub limit: usize,
    pub not_converged: usize,
    /// Of the ok: largest distance and angle between the model's prediction at the command and the pose.
    pub position: f64,
    pub orientation: f64,
    /// Of the ok: how many commands lie beyond a limit.
    pub beyond: usize,
}

impl Counts {
    fn with(self, other: Counts) -> Counts {
        Counts {
            ok: self.ok + other.ok,
            unreachable: self.unreachable + other.unreachable,
            limit: self.limit + other.limit,
            not_converged: self.not_converged + other.not_converged,
            position: self.position.max(other.position),
            orientation: self.orientation.max(other.orientation),
            beyond: self.beyond + other.beyond,
        }
    }

    pub fn all(&self) -> usize {
        self.ok + self.unreachable + self.limit + self.not_converged
    }
}

/// Which poses are requested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// Where the model is at joints within their limits.
    Reachable,
    /// Tens of metres away.
    Far,
    /// Where the model is with one joint beyond its limits: another posture may still reach it.
    BeyondLimits,
}

impl Trial {
    pub fn new(robot: &Robot, seed: u64, visits: usize) -> Outcome<Self> {
        let measured = robot.measured(seed, visits)?;
        let (model, data) = (robot.model(&measured.chain)?, measured.data.select(&measured.used));
        let fitted = fit(&model, &data, &PivotedQr::default(), &FitOptions::default())?.fitted;
        let mass = robot.payloads.iter().copied().fold(0.0, f64::max);
        let payload = Load::Payload(Payload { mass, com: Vector3::from(robot.com) });
        Ok(Trial { measured, fitted, payload })
    }

    /// Sends the plant to where the nominal robot would be at each locked visit.
    pub fn execute(&self) -> Outcome<Executed> {
        let Measured { plant, data, held_out, .. } = &self.measured;
        let (chain, schema) = (self.fitted.chain(), &data.schema);
        let mut compensator = Compensator::bind(&self.fitted, schema, CompensatorOptions::default())?;
        let mut predictor = self.fitted.bind(schema)?;
        let mut executed = Executed {
            before: 0.0,
            after: 0.0,
            after_max: 0.0,
            repeatability: 3f64.sqrt() * plant.repeatability.sd,
            ok: 0,
            of: held_out.len(),
            rows: 0,
            within: 0,
        };
        for rows in held_out {
            let (conditions, target) = (data.conditions(rows[0]), data.target[rows[0]]);
            let (position, wanted) = nominal_goal(chain, &conditions, target);
            let command = compensator.command(&wanted, &conditions, Some(&conditions.joints));
            if command.status == Status::Ok {
                let mut commanded = conditions.clone();
                commanded.joints = command.joints.to_vec();
                let off = (plant.true_position(&commanded, target)? - position).norm();
                executed.after += off * off;
                executed.after_max = executed.after_max.max(off);
                executed.before += (plant.true_position(&conditions, target)? - position).norm_squared();
                executed.ok += 1;
            }
            for &row in rows {
                let (conditions, target) = (data.conditions(row), data.target[row]);
                let band = predicted_error(&self.fitted, &mut predictor, &conditions, target);
                let predicted = predictor.predict(&conditions, target).translation;
                let off = (data.measured_position(row) - predicted).norm();
                executed.rows += 1;
                executed.within += usize::from(off <= band.measured_95);
            }
        }
        let count = executed.ok.max(1) as f64;
        executed.before = (executed.before / count).sqrt();
        executed.after = (executed.after / count).sqrt();
        Ok(executed)
    }

    /// Commands to many poses, half of them with the heaviest payload, from the nominal joints or from nowhere.
    pub fn round_trip(&self, request: Request, poses: usize, seeded: bool) -> Outcome<Counts> {
        let schema = &self.measured.data.schema;
        Compensator::bind(&self.fitted, schema, CompensatorOptions::default())?;
        const CHUNK: usize = 2000;
        let chunk = |chunk: usize| {
            let count = CHUNK.min(poses - chunk * CHUNK);
            self.some(request, count, seeded, chunk as u64, schema)
        };
        let chunks =
            (0..poses.div_ceil(CHUNK)).into_par_iter().map(chunk).collect::<Outcome<Vec<Counts>>>()?;
        Ok(chunks.into_iter().fold(Counts::default(), Counts::with))
    }

    fn some(
        &self,
        request: Request,
        poses: usize,
        seeded: bool,
        chunk: u64,
        schema: &Schema,
    ) -> Outcome<Counts> {
        let chain = self.fitted.chain();
        let mut rng = ChaCha8Rng::seed_from_u64(99);
        rng.set_stream(chunk);
        let mut compensator = Compensator::bind(&self.fitted, schema, CompensatorOptions::default())?;
        let mut predictor = self.fitted.bind(schema)?;
        let mut counts = Counts::default();
        let data = &self.measured.data;
        let middle = data.conditions(data.len() / 2);
        for k in 0..poses {
            let mut conditions = middle.clone();
            conditions.load = if k % 2 == 0 { Load::None } else { self.payload };
            conditions.joints = draw(chain, request, &mut rng);
            let target = (!chain.targets().is_empty()).then(|| TargetId(k % chain.targets().len()));
            let mut wanted = predictor.predict(&conditions, target);
            if request == Request::Far {
                let way = Vector3::from_fn(|_, _| rng.random::<f64>() - 0.5).normalize();
                wanted.translation += way * (30.0 + 30.0 * rng.random::<f64>());
            }
            // Beside the command, as the nominal solution is: a degree or a centimetre away.
            let aside = |q: &f64| q + 0.02 * (2.0 * rng.random::<f64>() - 1.0);
            let seed: Option<Vec<f64>> = seeded.then(|| conditions.joints.iter().map(aside).collect());
            let goal = Goal::at(wanted.translation).turned(wanted.rotation).of(target);
            let command = compensator.command(&goal, &conditions, seed.as_deref());
            match command.status {
                Status::Unreachable => counts.unreachable += 1,
                Status::Limit => counts.limit += 1,
                Status::NotConverged => counts.not_converged += 1,
                Status::Ok => {
                    counts.ok += 1;
                    conditions.joints.copy_from_slice(&command.joints);
                    conditions.approach.copy_from_slice(&command.approach);
                    let ends: Pose = predictor.predict(&conditions, target);
                    let turn = rotation_log(&(ends.rotation * wanted.rotation.transpose())).norm();
                    counts.position = counts.position.max((ends.translation - wanted.translation).norm());
                    counts.orientation = counts.orientation.max(turn);
                    let beyond = |(&joint, &q): (&_, &f64)| {
                        let joint: &Joint = chain.joint(joint);
                        joint.limits.is_some_and(|(lower, upper)| q < lower || q > upper)
                    };
                    counts.beyond +=
                        usize::from(chain.movable().iter().zip(command.joints.iter()).any(beyond));
                }
            }
        }
        Ok(counts)
    }
}

fn draw(chain: &Chain, request: Request, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let range = |&joint: &_| {
        let joint: &Joint = chain.joint(joint);
        let widest = if joint.kind == JointKind::Prismatic { 1.0 } else { std::f64::consts::PI };
        joint.limits.unwrap_or((-widest, widest))
    };
    let ranges: Vec<(f64, f64)> = chain.movable().iter().map(range).collect();
    let mut joints: Vec<f64> = ranges
        .iter()
        .map(|(lower, upper)| {
            let share = 0.97 * (rng.random::<f64>() - 0.5);
            0.5 * (lower + upper) + share * (upper - lower)
        })
        .collect();
    if request == Request::BeyondLimits {
        let k = rng.random_range(0..joints.len());
        let (lower, upper) = ranges[k];
        let over = (0.02 + 0.2 * rng.random::<f64>()) * (upper - lower);
        joints[k] = if rng.random::<bool>() { upper + over } else { lower - over };
    }
    joints
}
