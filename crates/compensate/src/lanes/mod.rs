//! Commands side by side, one a lane of the processor's vectors, for models that support batch evaluation.
//!
//! Models of constant errors and of joint compliances ([`truepose_errormodel::Effect::compliances`]), on arms of six joints:
//! position and orientation are requested, and a seed is near. All other commands, and those that leave the regular iteration, are solved singly.
//! The result is that of the exact model, verified with it in the last iteration, and does not depend on the neighbours.

mod arm;
mod newton;
mod sines;
mod vector;
mod walk;

use crate::arm::{Arm, Mark, Marked};
use crate::command::MOST;
use crate::options::CompensatorOptions;
use crate::search::{Ending, Walk};
use crate::step::Limits;
use crate::task::{Gap, Task};
use arm::JOINTS;
use nalgebra::Vector3;
use pulp::Arch;
use sines::SMALL;
use truepose_errormodel::{FittedModel, error_matrix};
use truepose_kinematics::{FrameId, GravityFrame, JointId, JointKind, Load};

/// Commands in a block: as many as the widest vectors have lanes.
pub(crate) const WIDTH: usize = 8;
/// Most joints, fixed ones included, and most compliances.
const LINKS: usize = 12;
/// Most generalized errors of frames.
const SITES: usize = 6 * (LINKS + 2);

/// A joint compliance.
#[derive(Debug, Clone)]
struct Spring {
    slides: bool,
    /// rad/(N·m), m/N.
    compliance: f64,
    /// Of the joint, among those that move.
    coordinate: usize,
    /// Where that shows: generalized error, and its part of the motion.
    sites: [(usize, f64); 3],
    count: usize,
}

impl Spring {
    fn sites(&self) -> &[(usize, f64)] {
        &self.sites[..self.count]
    }
}

/// What is met on the way from the tip to the base.
#[derive(Debug, Clone, Copy)]
enum Hung {
    Link { mark: usize, mass: f64 },
    Spring { mark: usize, spring: usize },
}

/// A model that supports batch evaluation.
#[derive(Debug, Clone)]
pub(crate) struct Kernel {
    arch: Arch,
    nominal: Arm,
    bent: Arm,
    /// Constant generalized errors of the frames.
    constant: Vec<f64>,
    springs: Vec<Spring>,
    hung: Vec<Hung>,
    /// Which of them compliances move.
    moving: Vec<usize>,
    /// Of the nominal posture, and of the robot that stands where it stands; measurement frame, m/s².
    gravity: [[f64; 3]; 2],
    scale: [f64; MOST],
    limits: Limits,
    length: f64,
    position_tolerance: f64,
    orientation_tolerance: f64,
}

/// Requests and results, one number for each command.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    count: usize,
    /// The seeds, then the commands.
    x: [[f64; WIDTH]; JOINTS],
    position: [[f64; WIDTH]; 3],
    /// Columns.
    rotation: [[[f64; WIDTH]; 3]; 3],
    /// The real point of the tool.
    point: [[f64; WIDTH]; 3],
    /// The payload's mass, kg, and its first moment in the tool's axes, kg·m.
    mass: [f64; WIDTH],
    first: [[f64; WIDTH]; 3],
    /// The gap at the end.
    error: [[f64; WIDTH]; 6],
    /// How many; none where the command is not found this way.
    rounds: [f64; WIDTH],
}

impl Kernel {
    /// None for models that have to be evaluated one posture at a time. `constant` are the errors that are the same everywhere, in the
    /// order of `Chain::site_index`.
    pub fn of(
        fitted: &FittedModel,
        constant: &[f64],
        scale: &[f64; MOST],
        limits: &Limits,
        options: &CompensatorOptions,
    ) -> Option<Self> {
        let (chain, model) = (fitted.chain(), fitted.model());
        let links = chain.joints().len();
        if chain.movable().len() != JOINTS || links > LINKS || !chain.is_serial() {
            return None;
        }
        let frames = 6 * chain.frames().len();
        let constant = constant.get(..frames)?.to_vec();
        // Their angles are taken to the fourth power where levers are asked.
        if (0..frames).any(|site| site % 6 >= 3 && constant[site].abs() > SMALL) {
            return None;
        }
        let mut moves = vec![false; frames];
        let mut yielding: Vec<(JointId, Spring)> = Vec::new();
        for k in (0..model.effects().len()).filter(|&k| !model.is_constant(k)) {
            let joints = model.effects()[k].compliances(chain)?;
            for (column, joint) in model.columns_of(k).zip(joints) {
                let compliance = fitted.coefficients()[column];
                if compliance == 0.0 {
                    continue;
                }
                let motion = chain.joint_motion(joint)?;
                let slides = motion.kind == JointKind::Prismatic;
                let coordinate = chain.coordinate(joint)?;
                let mut spring = Spring { slides, compliance, coordinate, sites: [(0, 0.0); 3], count: 0 };
                for direction in (0..3).filter(|&d| motion.axis[d] != 0.0) {
                    let site = 6 * motion.frame.0 + direction + if slides { 0 } else { 3 };
                    moves[site] = true;
                    spring.sites[spring.count] = (site, motion.axis[direction]);
                    spring.count += 1;
                }
                yielding.push((joint, spring));
            }
        }
        if yielding.len() > LINKS {
            return None;
        }
        let mut marks: Vec<Marked> = Vec::new();
        let mut hung = Vec::new();
        for id in (1..=links).rev().map(JointId) {
            if let Some(link) = chain.joint(id).link {
                hung.push(Hung::Link { mark: marks.len(), mass: link.mass });
                let mark = Mark { what: marks.len(), point: link.com, direction: Vector3::zeros() };
                marks.push((chain.frame_after(id), mark));
            }
            for (spring, (joint, _)) in yielding.iter().enumerate().filter(|(_, (joint, _))| *joint == id) {
                let motion = chain.joint_motion(*joint)?;
                hung.push(Hung::Spring { mark: marks.len(), spring });
                let mark = Mark { what: marks.len(), point: Vector3::zeros(), direction: motion.axis };
                marks.push((motion.frame, mark));
            }
        }
        let base = error_matrix(&std::array::from_fn(|k| constant[6 * FrameId::BASE.0 + k]));
        let given = chain.gravity_in_measurement_frame();
        let stands = match chain.gravity().frame {
            GravityFrame::Measurement => given,
            GravityFrame::Base => chain.base().pose.rotation * (base.rotation * chain.gravity().vector),
        };
        let only = truepose_kinematics::ToolId::FIRST;
        Some(Kernel {
            arch: Arch::new(),
            nominal: Arm::with_marks(chain, only, &[], &[], &marks),
            bent: Arm::with_marks(chain, only, &constant, &moves, &marks),
            moving: (0..frames).filter(|&site| moves[site]).collect(),
            constant,
            springs: yielding.into_iter().map(|(_, spring)| spring).collect(),
            hung,
            gravity: [given.into(), stands.into()],
            scale: *scale,
            limits: *limits,
            length: chain.characteristic_length(),
            position_tolerance: options.position_tolerance,
            orientation_tolerance: options.orientation_tolerance,
        })
    }

    /// On these registers.
    pub fn on(self, arch: Arch) -> Self {
        Kernel { arch, ..self }
    }

    /// Finds the commands of a block.
    pub fn walk(&self, block: &mut Block) {
        block.fill_up();
        self.arch.dispatch(walk::Walks { kernel: self, block });
    }
}

impl Block {
    pub fn empty() -> Self {
        Block {
            count: 0,
            x: [[0.0; WIDTH]; JOINTS],
            position: [[0.0; WIDTH]; 3],
            rotation: [[[0.0; WIDTH]; 3]; 3],
            point: [[0.0; WIDTH]; 3],
            mass: [0.0; WIDTH],
            first: [[0.0; WIDTH]; 3],
            error: [[0.0; WIDTH]; 6],
            rounds: [0.0; WIDTH],
        }
    }

    /// Takes in one more; its place, or none when it cannot be solved in a batch. `point` is the real point of the tool.
    pub fn push(
        &mut self,
        task: &Task,
        point: &Vector3<f64>,
        load: &Load,
        seed: &[f64; MOST],
    ) -> Option<usize> {
        let (mass, first) = match load {
            Load::None => (0.0, Vector3::zeros()),
            Load::Payload(payload) => (payload.mass, payload.com * payload.mass),
            Load::Wrench(_) => return None,
        };
        let rotation = task.rotation?;
        let lane = self.count;
        if lane >= WIDTH {
            return None;
        }
        (0..JOINTS).for_each(|k| self.x[k][lane] = seed[k]);
        for k in 0..3 {
            self.position[k][lane] = task.position[k];
            self.point[k][lane] = point[k];
            self.first[k][lane] = first[k];
            (0..3).for_each(|column| self.rotation[column][k][lane] = rotation[(k, column)]);
        }
        self.mass[lane] = mass;
        self.count += 1;
        Some(lane)
    }

    /// Unused lanes repeat the first one.
    fn fill_up(&mut self) {
        let count = self.count;
        let fill = |row: &mut [f64; WIDTH]| {
            let first = row[0];
            row[count..].fill(first);
        };
        self.x.iter_mut().for_each(fill);
        self.position.iter_mut().for_each(fill);
        self.rotation.iter_mut().flatten().for_each(fill);
        self.point.iter_mut().for_each(fill);
        self.first.iter_mut().for_each(fill);
        fill(&mut self.mass);
    }

    /// What was found for one of them.
    pub fn found(&self, lane: usize) -> Option<Walk> {
        let rounds = self.rounds[lane] as usize;
        if rounds == 0 {
            return None;
        }
        let mut x = [0.0; MOST];
        (0..JOINTS).for_each(|k| x[k] = self.x[k][lane]);
        let error: [f64; 6] = std::array::from_fn(|k| self.error[k][lane]);
        let cost = error.iter().map(|e| e * e).sum();
        Some(Walk { x, gap: Gap { error, cost }, ending: Ending::There, rounds })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::Reached;
    use crate::real::RealArm;
    use truepose_errormodel::effects::{Geometric, JointCompliance, Transmission};
    use truepose_errormodel::{AnyEffect, ErrorModel, Schema};
    use truepose_kinematics::nalgebra::DMatrix;
    use truepose_kinematics::{Chain, Conditions, Payload, samples};

    fn kernel(chain: &Chain, effects: Vec<Box<dyn AnyEffect>>) -> Option<(FittedModel, Kernel)> {
        let model = ErrorModel::new(chain.clone(), effects).unwrap();
        let size = |(k, scale): (usize, f64)| scale * 0.1 * (1.0 + (k as f64 * 0.7).sin());
        let c: Vec<f64> = model.columns().iter().map(|column| column.scale).enumerate().map(size).collect();
        let p = c.len();
        let fitted = FittedModel::new(model, c, DMatrix::zeros(p, p)).unwrap();
        let schema = Schema { load: true, ..Schema::default() };
        let constant =
            RealArm::bind(&fitted, &schema, truepose_kinematics::ToolId::FIRST).unwrap().constant().to_vec();
        let options = CompensatorOptions::default();
        let kernel = Kernel::of(&fitted, &constant, &[1.0; MOST], &Limits::NONE, &options)?;
        Some((fitted, kernel))
    }

    fn elastic() -> Vec<Box<dyn AnyEffect>> {
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())]
    }

    #[test]
    fn models_that_support_batch_evaluation() {
        for chain in samples::all() {
            let can = kernel(&chain, elastic()).is_some();
            assert_eq!(can, chain.movable().len() == 6, "{}", chain.name());
        }
        let mut more = elastic();
        more.push(Box::new(Transmission::of(JointId(2), 1.0)));
        assert!(kernel(&samples::ur10(), more).is_none());
    }

    /// The error that is returned is the exact model's own.
    #[test]
    fn the_last_round_is_the_exact_model() {
        let (chain, load) = (samples::heavy(), Payload { mass: 80.0, com: Vector3::new(0.1, 0.0, 0.2) });
        let (fitted, kernel) = kernel(&chain, elastic()).unwrap();
        let schema = Schema { load: true, ..Schema::default() };
        let (mut real, mut at) = (
            RealArm::bind(&fitted, &schema, truepose_kinematics::ToolId::FIRST).unwrap(),
            Reached::nowhere(),
        );
        let mut block = Block::empty();
        let mut jobs = Vec::new();
        for k in 0..WIDTH {
            let q: Vec<f64> = (0..6).map(|j| 0.4 + 0.2 * j as f64 - 0.05 * k as f64).collect();
            let conditions = Conditions::at(&chain, &q).with_load(Load::Payload(load));
            let pose = chain.forward(&q);
            let task = Task {
                position: pose.translation,
                rotation: Some(pose.rotation),
                target: None,
                length: chain.characteristic_length(),
                position_tolerance: 1e-10,
                orientation_tolerance: 1e-10,
            };
            let mut seed = [0.0; MOST];
            seed[..6].copy_from_slice(&q);
            assert_eq!(block.push(&task, &Vector3::zeros(), &conditions.load, &seed), Some(k));
            jobs.push((task, conditions));
        }
        kernel.walk(&mut block);
        for (k, (task, conditions)) in jobs.iter_mut().enumerate() {
            let walk = block.found(k).expect("the straight way");
            conditions.joints.copy_from_slice(&walk.x[..6]);
            real.reach(conditions, &mut at);
            let gap = task.gap(&mut at, &Vector3::zeros());
            for (a, b) in gap.error.iter().zip(walk.gap.error) {
                // Levers and their weights are the same to round-off; characteristic lengths, rad.
                assert!((a - b).abs() < 1e-13, "{k}: {a:e} {b:e}");
            }
            assert!(task.reached(&gap) && (3..=5).contains(&walk.rounds), "{k}: {}", walk.rounds);
        }
    }
}
