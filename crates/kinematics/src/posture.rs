//! The robot at one configuration: its frames, and the wrench that each of them carries. Nominal, unless it is `settle`d.
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | T_i | `frame(i)` | pose | m | measurement |
//! | w_i | `wrench(i)` | 6 | N, N·m | about and in the axes of frame i |
//! | τ_j | `joint_load(j)` | 1 | N·m or N | about or along joint j's axis |
//!
//! Statics, from the tip to the base, with links k of mass m_k and centre c_k (frame k), load w at the tool:
//!
//! ```text
//! w_tool = load;     w_i = Σ_{k ≥ i} m_k g at c_k  +  load,   i = 1 … n;     w_0 = w_1
//! ```
//!
//! Of a tree k ≥ i stands for all frames that i carries, and the load hangs on the tool of the conditions.
//!
//! Frame i carries its own link, since `E_i` stands in front of that link. Wrenches are those that the
//! weights exert *on* the robot: a joint yields in the direction of `joint_load`.

use crate::sines::sin_cos;
use crate::{Chain, Conditions, FrameId, JointId, JointKind, Load, Pose, Slot, ToolId, Wrench};
use nalgebra::Vector3;

/// Memory for one posture, used again for the next one without allocating.
#[derive(Debug, Clone)]
pub struct PostureBuffer {
    frames: Vec<Pose>,
    /// `A_1 … A_n`, then the transforms of the tools: from the frame in front of each.
    steps: Vec<Pose>,
    /// Sine and cosine of each movable joint's value.
    turns: Vec<(f64, f64)>,
    /// In the measurement frame's axes, about each frame's origin.
    wrenches: Vec<Wrench>,
}

impl PostureBuffer {
    /// Memory for postures of this robot.
    pub fn new(chain: &Chain) -> Self {
        let n = chain.frame_count();
        PostureBuffer {
            frames: vec![Pose::IDENTITY; n],
            steps: vec![Pose::IDENTITY; n - 1],
            turns: vec![(0.0, 1.0); chain.movable().len()],
            wrenches: vec![Wrench::default(); n],
        }
    }

    /// The nominal posture under these conditions.
    ///
    /// `conditions.joints` has one value for each movable joint.
    pub fn update<'a>(&'a mut self, chain: &'a Chain, conditions: &'a Conditions) -> Posture<'a> {
        self.move_to(chain, conditions);
        self.view(chain, conditions)
    }

    /// The posture computed last, seen under conditions of the same joints and load (time, channels and
    /// approach may differ).
    pub fn view<'a>(&'a self, chain: &'a Chain, conditions: &'a Conditions) -> Posture<'a> {
        Posture {
            chain,
            conditions,
            frames: &self.frames,
            steps: &self.steps,
            turns: &self.turns,
            wrenches: &self.wrenches,
            slots: &[],
        }
    }

    /// The same conditions with the frames where the real robot has them: the wrenches are those of the posture in which
    /// it comes to rest, under this gravity (measurement frame, m/s²). The transforms between the frames stay the nominal ones.
    pub fn settle<'a>(
        &'a mut self,
        chain: &'a Chain,
        conditions: &'a Conditions,
        gravity: &Vector3<f64>,
        real: impl Fn(FrameId) -> Pose,
    ) -> Posture<'a> {
        for (index, frame) in self.frames.iter_mut().enumerate() {
            *frame = real(FrameId(index));
        }
        self.weigh(chain, conditions, gravity);
        self.view(chain, conditions)
    }

    /// As [`PostureBuffer::settle`], given by how much each frame is displaced, in its own axes.
    pub fn bend<'a>(
        &'a mut self,
        chain: &'a Chain,
        conditions: &'a Conditions,
        gravity: &Vector3<f64>,
        displaced: impl Fn(FrameId) -> Option<Pose>,
    ) -> Posture<'a> {
        for index in 0..self.frames.len() {
            let mut pose = match chain.parent(FrameId(index)) {
                Some(before) => self.frames[before.0] * self.steps[index - 1],
                None => chain.base().pose,
            };
            if let Some(by) = displaced(FrameId(index)) {
                pose = pose * by;
            }
            self.frames[index] = pose;
        }
        self.weigh(chain, conditions, gravity);
        self.view(chain, conditions)
    }

    /// The posture under these conditions with frames (measurement frame) and wrenches (about each frame's origin, in the measurement frame's
    /// axes) that somebody else has worked out. The transforms between the frames stay the nominal ones.
    pub fn place<'a>(
        &'a mut self,
        chain: &'a Chain,
        conditions: &'a Conditions,
        at: impl Fn(FrameId) -> (Pose, Wrench),
    ) -> Posture<'a> {
        self.move_to(chain, conditions);
        for (index, (pose, carried)) in self.frames.iter_mut().zip(&mut self.wrenches).enumerate() {
            (*pose, *carried) = at(FrameId(index));
        }
        self.view(chain, conditions)
    }

    fn move_to(&mut self, chain: &Chain, conditions: &Conditions) {
        let n = chain.joints().len();
        self.frames[0] = chain.base().pose;
        for (turn, &q) in self.turns.iter_mut().zip(&conditions.joints) {
            *turn = sin_cos(q);
        }
        for (index, (joint, coordinate)) in chain.prepared().enumerate() {
            let (q, turn) = coordinate.map_or((0.0, (0.0, 1.0)), |k| (conditions.joints[k], self.turns[k]));
            self.steps[index] = joint.transform(q, turn);
            self.frames[index + 1] = self.frames[chain.parents[index].0] * self.steps[index];
        }
        for (k, tool) in chain.tools().iter().enumerate() {
            self.steps[n + k] = tool.placed.pose;
            self.frames[n + 1 + k] = self.frames[tool.frame.0] * tool.placed.pose;
        }
        self.weigh(chain, conditions, &chain.gravity_in_measurement_frame());
    }

    /// Statics, with the frames where they are.
    fn weigh(&mut self, chain: &Chain, conditions: &Conditions, gravity: &Vector3<f64>) {
        let load = (conditions.tool, &conditions.load);
        weigh(chain, &self.frames, load, gravity, &mut self.wrenches);
    }
}

/// What each frame carries, about its origin, in the measurement frame's axes: from frames where they are (measurement frame), the load of
/// a tool, and gravity in the measurement frame, m/s².
pub fn weigh(
    chain: &Chain,
    frames: &[Pose],
    (carrier, load): (ToolId, &Load),
    gravity: &Vector3<f64>,
    wrenches: &mut [Wrench],
) {
    wrenches.fill(Wrench::default());
    let at = chain.frame_of_tool(carrier).0;
    wrenches[at] = match load {
        Load::None => Wrench::default(),
        Load::Payload(payload) => weight(payload.mass, &(frames[at].rotation * payload.com), gravity),
        Load::Wrench(measured) => measured.rotated(&frames[at].rotation),
    };
    for frame in (1..frames.len()).rev() {
        if let Some(link) = chain.joints().get(frame - 1).and_then(|joint| joint.link.as_ref()) {
            let own = weight(link.mass, &(frames[frame].rotation * link.com), gravity);
            wrenches[frame].force += own.force;
            wrenches[frame].moment += own.moment;
        }
        if let Some(FrameId(before)) = chain.parent(FrameId(frame)) {
            let arm = frames[frame].translation - frames[before].translation;
            let carried = wrenches[frame].carried_to(&arm);
            wrenches[before].force += carried.force;
            wrenches[before].moment += carried.moment;
        }
    }
}

/// The weight of a mass whose centre lies at `arm` from the point of reference.
fn weight(mass: f64, arm: &Vector3<f64>, gravity: &Vector3<f64>) -> Wrench {
    let force = gravity * mass;
    Wrench { force, moment: arm.cross(&force) }
}

/// The robot at one configuration. Only a posture has frames and wrenches.
#[derive(Debug, Clone, Copy)]
pub struct Posture<'a> {
    chain: &'a Chain,
    conditions: &'a Conditions,
    frames: &'a [Pose],
    steps: &'a [Pose],
    turns: &'a [(f64, f64)],
    wrenches: &'a [Wrench],
    slots: &'a [Slot],
}

impl<'a> Posture<'a> {
    /// The robot.
    #[inline]
    pub fn chain(&self) -> &'a Chain {
        self.chain
    }

    /// The inputs that made this posture.
    #[inline]
    pub fn conditions(&self) -> &'a Conditions {
        self.conditions
    }

    /// Pose of a frame in the measurement frame: nominal, or where the real robot has it.
    #[inline]
    pub fn frame(&self, frame: FrameId) -> &'a Pose {
        &self.frames[frame.0]
    }

    /// The nominal transforms from the frame in front of each frame but the base: `A_1(q_1) … A_n(q_n)`, then those of the tools.
    #[inline]
    pub fn steps(&self) -> &'a [Pose] {
        self.steps
    }

    /// Sine and cosine of each movable joint's value (of a slide's too, where they mean nothing).
    #[inline]
    pub fn turns(&self) -> &'a [(f64, f64)] {
        self.turns
    }

    /// Pose of the tool that is looked at in the measurement frame.
    #[inline]
    pub fn tool(&self) -> &'a Pose {
        &self.frames[self.chain.frame_of_tool(self.conditions.tool).0]
    }

    /// Value of a joint, rad or m; zero for a fixed joint.
    #[inline]
    pub fn joint(&self, joint: JointId) -> f64 {
        self.chain.coordinate(joint).map_or(0.0, |k| self.conditions.joints[k])
    }

    /// The wrench that a frame carries, about its origin, in its axes: N, N·m.
    #[inline]
    pub fn wrench(&self, frame: FrameId) -> Wrench {
        self.wrenches[frame.0].rotated(&self.frames[frame.0].rotation.transpose())
    }

    /// The load about (N·m) or along (N) a joint's axis; zero for a fixed joint.
    pub fn joint_load(&self, joint: JointId) -> f64 {
        let Some(motion) = self.chain.joint_motion(joint) else { return 0.0 };
        let at = &self.frames[motion.frame.0];
        let axis = at.rotation * motion.axis;
        let carried = &self.wrenches[self.chain.frame_after(joint).0];
        match motion.kind {
            JointKind::Prismatic => axis.dot(&carried.force),
            _ => {
                let arm = self.frames[joint.0].translation - at.translation;
                axis.dot(&carried.carried_to(&arm).moment)
            }
        }
    }

    /// The k-th signal that the effect being evaluated asked for.
    #[inline]
    pub fn signal(&self, k: usize) -> f64 {
        self.conditions.slot(self.slots[k])
    }

    /// The same posture for an effect whose needs were resolved to these slots.
    #[inline]
    pub fn with_slots(&self, slots: &'a [Slot]) -> Posture<'a> {
        Posture { slots, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Payload, samples};

    /// Potential energy of everything that hangs on the robot, J: an independent way to the joint loads.
    fn energy(chain: &Chain, conditions: &Conditions) -> f64 {
        let g = chain.gravity_in_measurement_frame();
        let mut energy = 0.0;
        let mut poses = vec![chain.base().pose];
        for (index, joint) in chain.joints().iter().enumerate() {
            let q = chain.coordinate(JointId(index + 1)).map_or(0.0, |k| conditions.joints[k]);
            let pose = poses[chain.before(JointId(index + 1)).0] * joint.transform(q);
            if let Some(link) = joint.link {
                energy -= link.mass * g.dot(&pose.apply(&link.com));
            }
            poses.push(pose);
        }
        if let Load::Payload(p) = conditions.load {
            let tool = &chain.tools()[conditions.tool.0];
            energy -= p.mass * g.dot(&(poses[tool.frame.0] * tool.placed.pose).apply(&p.com));
        }
        energy
    }

    #[test]
    fn joint_load_is_the_slope_of_the_potential_energy() {
        let trees = [(samples::dual(), 0), (samples::dual(), 1)];
        for (chain, tool) in samples::all().into_iter().map(|chain| (chain, 0)).chain(trees) {
            let n = chain.movable().len();
            let joints: Vec<f64> = (0..n).map(|k| 0.3 + 0.25 * k as f64).collect();
            let load = Load::Payload(Payload { mass: 12.0, com: Vector3::new(0.1, -0.2, 0.3) });
            let tool = ToolId(tool);
            let conditions = Conditions { tool, ..Conditions::at(&chain, &joints).with_load(load) };
            let mut buffer = PostureBuffer::new(&chain);
            let loads: Vec<f64> = {
                let posture = buffer.update(&chain, &conditions);
                chain.movable().iter().map(|&j| posture.joint_load(j)).collect()
            };
            for (k, load) in loads.iter().enumerate() {
                let at = |d: f64| {
                    let mut c = conditions.clone();
                    c.joints[k] += d;
                    energy(&chain, &c)
                };
                let slope = -(at(1e-5) - at(-1e-5)) / 2e-5;
                assert!(
                    (slope - load).abs() < 1e-5 * (1.0 + slope.abs()),
                    "{} joint {k}: {slope} against {load}",
                    chain.name()
                );
            }
        }
    }

    #[test]
    fn measured_wrench_wins_over_nothing_and_is_in_tool_axes() {
        let chain = samples::ur10();
        let wrench = Wrench { force: Vector3::new(1.0, 2.0, 3.0), moment: Vector3::new(0.1, 0.2, 0.3) };
        let conditions = Conditions::at(&chain, &[0.3; 6]).with_load(Load::Wrench(wrench));
        let mut buffer = PostureBuffer::new(&chain);
        let posture = buffer.update(&chain, &conditions);
        let back = posture.wrench(chain.tool_frame());
        assert!((back.force - wrench.force).norm() < 1e-14);
        assert!((back.moment - wrench.moment).norm() < 1e-14);
    }
}
