//! Static equilibrium of the robot: every compliance carries the wrench of the *deflected* posture.
//!
//! ```text
//! T = B · D_0 · S_0 · Π_i [ before_i · motion_i(q_i + δ_i) · R_i(q_i) · S_i · after_i · D_i · G_i · K_i ] · tool · D_tool
//! ```
//!
//! | symbol | what | depends on |
//! | --- | --- | --- |
//! | D | constant displacement | nothing |
//! | δ | backlash, transmission, coupling, drift of the joint's motion | q, approach, load, t |
//! | R | the carriage on its guideway | q |
//! | S | foundation; drive and bearing | the wrench that they carry |
//! | G, K | growth of the link; the link as a beam | t; the wrench at its tip, its own weight |
//!
//! The outward pass composes the transforms with the deflections as they are; the inward pass sums the weights
//! (force, and moment about the *measurement frame's origin*), which give new deflections. That is repeated until
//! nothing moves. Each step leaves the fraction (load × compliance / arm ≈ 1e-2) of the change before, so that
//! seven steps reach round-off. Source: the fixed-point form of K(x) x = w(x), any text on structural mechanics.

use crate::SimulateError;
use crate::physics::changes::Moved;
use crate::rigid::{Rigid, TakenApart, displaced, displaced_at, from_pose};
use crate::truth::{Truth, span};
use nalgebra::{Point3, Translation3, Vector3};
use truepose_kinematics::{Chain, Conditions, JointId, JointKind, Load, Wrench};

const MOST_ITERATIONS: usize = 80;
/// m and rad: a hundred thousandth of a nanometre.
const STILL: f64 = 1e-14;

/// The robot in static equilibrium.
#[derive(Debug, Clone)]
pub(crate) struct Equilibrium {
    /// Measurement frame → tool, the tool's own displacement included.
    pub tool: Rigid,
    /// Load about (N·m) or along (N) each joint's axis; zero for fixed joints.
    pub loads: Vec<f64>,
}

/// The deflections that the loads decide, in the axes of their place.
#[derive(Debug, Clone)]
struct Deflections {
    base: [f64; 6],
    joints: Vec<[f64; 6]>,
    /// Of each joint's own motion: backlash, and waves of its transmission.
    backlash: Vec<f64>,
    beams: Vec<[f64; 6]>,
}

/// Where things are with some deflections.
struct Shape {
    base: Rigid,
    /// On each joint's axis, behind its motion.
    axes: Vec<Rigid>,
    /// Each link at its root, not yet bent.
    links: Vec<Rigid>,
    tool: Rigid,
}

/// A robot taken apart, ready to be put into postures.
#[derive(Debug, Clone)]
pub(crate) struct Assembly {
    base: Rigid,
    tool: Rigid,
    joints: Vec<TakenApart>,
    spans: Vec<Vector3<f64>>,
    coordinates: Vec<Option<usize>>,
    gravity: Vector3<f64>,
    name: String,
}

impl Assembly {
    pub fn of(chain: &Chain) -> Self {
        let ids = || (1..=chain.joints().len()).map(JointId);
        let base = from_pose(&chain.base().pose);
        let described = chain.gravity();
        let gravity = match described.frame {
            truepose_kinematics::GravityFrame::Measurement => described.vector,
            truepose_kinematics::GravityFrame::Base => base.rotation * described.vector,
        };
        Assembly {
            base,
            tool: from_pose(&chain.tool().pose),
            joints: chain.joints().iter().map(TakenApart::of).collect(),
            spans: ids().map(|j| span(chain, j)).map(|(root, tip)| tip - root).collect(),
            coordinates: ids().map(|j| chain.coordinate(j)).collect(),
            gravity,
            name: chain.name().to_owned(),
        }
    }

    /// The static equilibrium under these conditions.
    pub fn equilibrium(&self, truth: &Truth, conditions: &Conditions) -> Result<Equilibrium, SimulateError> {
        let movable = self.coordinates.iter().flatten().count();
        if conditions.joints.len() != movable {
            return Err(SimulateError::Shape {
                what: "joint values",
                have: conditions.joints.len(),
                need: movable,
            });
        }
        let n = self.joints.len();
        let moved = Moved::at(&truth.changes, conditions.time, n);
        let mut now = Deflections {
            base: [0.0; 6],
            joints: vec![[0.0; 6]; n],
            backlash: vec![0.0; n],
            beams: vec![[0.0; 6]; n],
        };
        let mut iterations = 0;
        loop {
            let shape = self.outward(truth, conditions, &moved, &now);
            let (next, loads) = self.inward(truth, conditions, &moved, &shape);
            let change_m = now.farthest(&next);
            if change_m <= STILL {
                return Ok(Equilibrium { tool: shape.tool, loads });
            }
            now = next;
            iterations += 1;
            // A change of a thousand metres, or one that is not a number, does not converge.
            if iterations == MOST_ITERATIONS || change_m.is_nan() || change_m > 1e3 {
                return Err(SimulateError::NoEquilibrium { robot: self.name.clone(), iterations, change_m });
            }
        }
    }

    /// The direction against gravity; z where there is none.
    pub fn up(&self) -> Vector3<f64> {
        (-self.gravity).try_normalize(1e-12).unwrap_or_else(Vector3::z)
    }

    fn value(&self, conditions: &Conditions, place: usize) -> f64 {
        self.coordinates[place].map_or(0.0, |k| conditions.joints[k])
    }

    fn outward(&self, truth: &Truth, conditions: &Conditions, moved: &Moved, now: &Deflections) -> Shape {
        let n = self.joints.len();
        let mut at = self.base * displaced(&truth.frames[0]) * displaced(&moved.base) * displaced(&now.base);
        let mut shape =
            Shape { base: at, axes: Vec::with_capacity(n), links: Vec::with_capacity(n), tool: at };
        for (i, (joint, errors)) in self.joints.iter().zip(&truth.joints).enumerate() {
            let q = self.value(conditions, i);
            let transmission: f64 = errors.transmission.iter().map(|one| one.error(joint.kind, q)).sum();
            let dragged: f64 = errors
                .couplings
                .iter()
                .map(|c| c.error(self.joints[c.driver].kind, self.value(conditions, c.driver)))
                .sum();
            let linked = errors.linkage.map_or(0.0, |bar| bar.error(q, self.value(conditions, bar.driver)));
            let motion = q * (1.0 + moved.scales[i])
                + transmission
                + dragged
                + linked
                + moved.joints[i]
                + now.backlash[i];
            at = at * joint.before * joint.motion(motion);
            if let Some(guideway) = &errors.guideway {
                at *= displaced(&guideway.displacement(q));
            }
            at *= displaced(&now.joints[i]);
            shape.axes.push(at);
            at = at * joint.after * displaced(&truth.frames[i + 1]);
            shape.links.push(at);
            at *= Translation3::from(self.spans[i] * moved.lengths[i]);
            if let Some(beam) = &errors.beam {
                at *= displaced_at(&beam.tip, &now.beams[i]);
            }
        }
        shape.tool = at * self.tool * displaced(&truth.frames[n + 1]) * displaced(&moved.tool);
        shape
    }

    fn inward(
        &self,
        truth: &Truth,
        conditions: &Conditions,
        moved: &Moved,
        shape: &Shape,
    ) -> (Deflections, Vec<f64>) {
        let n = self.joints.len();
        let mut next = Deflections {
            base: [0.0; 6],
            joints: vec![[0.0; 6]; n],
            backlash: vec![0.0; n],
            beams: vec![[0.0; 6]; n],
        };
        let mut loads = vec![0.0; n];
        let mut carried = Carried::default();
        match conditions.load {
            Load::None => {}
            Load::Payload(payload) => {
                carried.hang(shape.tool * Point3::from(payload.com), self.gravity * payload.mass);
            }
            Load::Wrench(wrench) => {
                let rotation = shape.tool.rotation;
                carried.hang(Point3::from(shape.tool.translation.vector), rotation * wrench.force);
                carried.moment += rotation * wrench.moment;
            }
        }
        for i in (0..n).rev() {
            let (joint, errors, link) = (&self.joints[i], &truth.joints[i], &shape.links[i]);
            if let Some(beam) = &errors.beam {
                let at_tip = carried.seen_from(&(link * Translation3::from(beam.tip)));
                let gravity = link.rotation.inverse() * self.gravity;
                next.beams[i] = beam.deflection(&at_tip, errors.link.as_ref(), &gravity);
            }
            if let Some(own) = &errors.link {
                carried.hang(link * Point3::from(own.com), self.gravity * own.mass);
            }
            let at_axis = carried.seen_from(&shape.axes[i]);
            let (softer, q) = (moved.softer[i].exp(), self.value(conditions, i));
            let mut on_drive = at_axis;
            on_drive.moment += joint.axis.into_inner() * errors.spring.map_or(0.0, |spring| spring.torque(q));
            next.joints[i] =
                errors.stiffness.deflection(joint.kind, &joint.axis, &on_drive).map(|v| v * softer);
            let bent = errors.bridge.map(|bridge| bridge.deflection(q, &joint.axis, &at_axis));
            let out = errors.ram.map(|ram| ram.deflection(q, &joint.axis, &at_axis));
            for more in [bent, out].into_iter().flatten() {
                next.joints[i].iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            }
            if let Some(bearing) = &errors.bearing {
                turn(&mut next.joints[i], &bearing.tilt(&joint.axis, &at_axis.moment));
            }
            if let Some(flange) = &errors.flange {
                turn(&mut next.joints[i], &flange.tilt(&at_axis.moment));
            }
            loads[i] = match joint.kind {
                JointKind::Revolute => joint.axis.dot(&at_axis.moment),
                JointKind::Prismatic => joint.axis.dot(&at_axis.force),
                JointKind::Fixed => 0.0,
            };
            if let (Some(backlash), Some(k)) = (&errors.backlash, self.coordinates[i]) {
                let approach = conditions.approach.get(k).copied().unwrap_or(0.0);
                // The edges of what is worn are no steps.
                let worn = errors.worn.map_or(1.0, |[middle, half]| (-((q - middle) / half).powi(8)).exp());
                next.backlash[i] = worn * backlash.error(approach, loads[i]);
            }
            if let Some(waves) = &errors.waves {
                next.backlash[i] += waves.error(joint.kind, self.value(conditions, i), loads[i]);
            }
        }
        let at_base = carried.seen_from(&shape.base);
        next.base = truth.foundation.settling(&at_base);
        if let Some(plate) = &truth.base_plate {
            turn(&mut next.base, &plate.tilt(&at_base.moment));
        }
        (next, loads)
    }
}

impl Deflections {
    /// The largest difference of any two entries.
    fn farthest(&self, other: &Deflections) -> f64 {
        let sixes = |a: &[f64; 6], b: &[f64; 6]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, worse);
        let lists =
            |a: &[[f64; 6]], b: &[[f64; 6]]| a.iter().zip(b).map(|(a, b)| sixes(a, b)).fold(0.0, worse);
        let backlash = self.backlash.iter().zip(&other.backlash).map(|(a, b)| (a - b).abs()).fold(0.0, worse);
        [sixes(&self.base, &other.base), lists(&self.joints, &other.joints), lists(&self.beams, &other.beams)]
            .into_iter()
            .fold(backlash, worse)
    }
}

/// Adds a rotation to a displacement.
fn turn(displacement: &mut [f64; 6], by: &Vector3<f64>) {
    for (sum, part) in displacement[3..].iter_mut().zip(by.iter()) {
        *sum += part;
    }
}

/// The larger of two, and what is not a number above all.
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// Load of all links beyond this point: force, and moment about the measurement frame's origin.
#[derive(Debug, Clone, Copy, Default)]
struct Carried {
    force: Vector3<f64>,
    moment: Vector3<f64>,
}

impl Carried {
    fn hang(&mut self, at: Point3<f64>, force: Vector3<f64>) {
        self.force += force;
        self.moment += at.coords.cross(&force);
    }

    /// About the origin and in the axes of a frame.
    fn seen_from(&self, frame: &Rigid) -> Wrench {
        let into = frame.rotation.inverse();
        let moment = self.moment - frame.translation.vector.cross(&self.force);
        Wrench { force: into * self.force, moment: into * moment }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::beam::Beam;
    use crate::physics::joint_stiffness::JointStiffness;
    use truepose_kinematics::{Gravity, GravityFrame, Joint, Link, Payload, Placement, samples};

    /// One arm of 1 m along x that turns about z, gravity along −y, all its mass at the end.
    fn pendulum(length: f64, mass: f64) -> Chain {
        let joint =
            Joint::new("a", JointKind::Revolute, Placement::Dh { theta: 0.0, d: 0.0, a: length, alpha: 0.0 })
                .with_link(mass, [0.0; 3]);
        Chain::new("pendulum", vec![joint])
            .and_then(|c| {
                c.with_gravity(Gravity {
                    vector: Vector3::new(0.0, -9.81, 0.0),
                    frame: GravityFrame::Measurement,
                })
            })
            .expect("a chain")
    }

    #[test]
    fn a_compliant_arm_reaches_static_equilibrium() {
        // k θ = m g L cos θ, not m g L: at 1 kN·m/rad the difference is five millimetres of two hundred.
        let chain = pendulum(1.0, 25.0);
        let mut truth = Truth::of(&chain);
        truth.joints[0].stiffness = JointStiffness::drive(1000.0);
        let equilibrium =
            Assembly::of(&chain).equilibrium(&truth, &Conditions::at(&chain, &[0.0])).expect("equilibrium");
        let theta = -equilibrium.tool.translation.vector.y.asin();
        assert!((1000.0 * theta - 25.0 * 9.81 * theta.cos()).abs() < 1e-9, "{theta}");
        assert!((theta - 25.0 * 9.81 / 1000.0).abs() > 5e-3);
    }

    #[test]
    fn joint_torques_equal_the_slope_of_the_potential_energy() {
        // At rest every drive carries −∂V/∂q of the deflected posture: V from the rigid robot's tool alone.
        let chain = Chain::new(
            "two",
            pendulum(1.0, 0.0)
                .joints()
                .to_vec()
                .into_iter()
                .chain(pendulum(0.7, 0.0).joints().iter().map(|j| Joint { name: "b".into(), ..j.clone() }))
                .collect(),
        )
        .and_then(|c| c.with_gravity(*pendulum(1.0, 0.0).gravity()))
        .expect("a chain");
        let load = Load::Payload(Payload { mass: 40.0, com: Vector3::new(0.2, 0.1, 0.0) });
        let stiffness = [3e3, 2e3];
        let mut soft = Truth::of(&chain);
        for (joint, k) in soft.joints.iter_mut().zip(stiffness) {
            joint.stiffness = JointStiffness::drive(k);
        }
        let assembly = Assembly::of(&chain);
        let at = |q: [f64; 2]| Conditions::at(&chain, &q).with_load(load);
        let equilibrium = assembly.equilibrium(&soft, &at([0.4, -0.9])).expect("equilibrium");
        let deflected =
            [0.4 + equilibrium.loads[0] / stiffness[0], -0.9 + equilibrium.loads[1] / stiffness[1]];
        let energy = |q: [f64; 2]| {
            let rigid = assembly.equilibrium(&Truth::of(&chain), &at(q)).expect("equilibrium");
            40.0 * 9.81 * (rigid.tool * Point3::new(0.2, 0.1, 0.0)).y
        };
        for k in 0..2 {
            let step = |d: f64| energy(std::array::from_fn(|i| deflected[i] + if i == k { d } else { 0.0 }));
            let slope = -(step(1e-5) - step(-1e-5)) / 2e-5;
            assert!((slope - equilibrium.loads[k]).abs() < 1e-5, "{slope} against {}", equilibrium.loads[k]);
        }
    }

    #[test]
    fn a_beam_in_a_robot_bends_like_a_beam() {
        let chain = pendulum(1.0, 0.0);
        let mut truth = Truth::of(&chain);
        let (root, tip) = span(&chain, JointId(1));
        truth.joints[0].beam = Some(Beam::slender(root, tip, 1e4, 1e4).expect("a beam"));
        truth.joints[0].link = Some(Link { mass: 8.0, com: (root + tip) / 2.0 });
        let load = Load::Payload(Payload { mass: 5.0, com: Vector3::zeros() });
        let equilibrium = Assembly::of(&chain)
            .equilibrium(&truth, &Conditions::at(&chain, &[0.0]).with_load(load))
            .expect("equilibrium");
        let expected = -(5.0 * 9.81 / 3e4 + 8.0 * 9.81 / 8e4);
        assert!((equilibrium.tool.translation.vector.y - expected).abs() < 1e-15);
    }

    #[test]
    fn without_errors_it_is_rigid_and_too_soft_a_robot_is_refused() {
        let chain = samples::heavy();
        let mut truth = Truth::of(&chain);
        let conditions = Conditions::at(&chain, &[0.1; 6]);
        let assembly = Assembly::of(&chain);
        assert!(assembly.equilibrium(&truth, &conditions).is_ok());
        truth.joints[1].stiffness = JointStiffness::drive(10.0);
        assert!(matches!(
            assembly.equilibrium(&truth, &conditions),
            Err(SimulateError::NoEquilibrium { .. })
        ));
    }
}
