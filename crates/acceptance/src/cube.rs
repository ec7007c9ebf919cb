//! The test cube of ISO 9283 and its five poses: the largest cube that the robot reaches in one posture.
//!
//! ```text
//! P1 = centre        P2 … P5 = centre + 0.8 (C − centre),   C the corners of the inclined plane
//! ```
//!
//! The edges are parallel to the axes of the base. The inclined plane passes through two opposite edges of the cube that are parallel to y. A
//! pose lies a tenth of the plane's diagonal from the corner. The orientation of the tool is the same in all poses. A cube is reached where its
//! corners and poses are, from the joint values of its centre, without another posture. Source: ISO 9283:1998, 6.8.

use crate::error::AcceptanceError;
use nalgebra::{DMatrix, Vector3};
use truepose_compensate::{Compensator, CompensatorOptions, Status, Target};
use truepose_errormodel::{ErrorModel, FittedModel, Schema};
use truepose_kinematics::{Chain, Conditions, Pose};

/// What the cube has to be like.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TestCube {
    /// Its edge, m; none: the largest of the standard's sizes.
    pub edge: Option<f64>,
    /// Its centre, m, base frame; none: wherever the largest cube fits.
    pub centre: Option<[f64; 3]>,
    /// Orientation of the tool: roll, pitch, yaw in the base frame, rad; none: that of the posture in the middle.
    pub rpy: Option<[f64; 3]>,
}

/// One of the five poses.
#[derive(Debug, Clone, PartialEq)]
pub struct IsoPose {
    /// `P1` to `P5`.
    pub number: usize,
    /// Variables of the joints, rad or m.
    pub joints: Vec<f64>,
    /// Commanded position and orientation of the tool, m, base frame.
    pub pose: Pose,
}

/// A cube with its poses.
#[derive(Debug, Clone, PartialEq)]
pub struct IsoCube {
    /// Edge, m.
    pub edge: f64,
    /// Centre, m, base frame.
    pub centre: Vector3<f64>,
    /// P1 to P5.
    pub poses: Vec<IsoPose>,
}

/// Sizes that are tried, m: those of the standard, and smaller ones of the same series.
const EDGES: [f64; 12] = [2.5, 1.6, 1.0, 0.63, 0.4, 0.25, 0.16, 0.1, 0.063, 0.04, 0.025, 0.016];
/// Postures that are tried in the middle of the cube.
const POSTURES: usize = 400;
/// A joint that moves farther between the centre and a corner (rad) takes another posture.
const FAR: f64 = 2.0;
/// Part of a joint's range in which the posture of the centre lies.
const MIDDLE: f64 = 0.8;

/// The largest cube whose poses and corners the robot reaches, and of equal ones that which stays farthest from the joints' limits.
///
/// # Errors
/// When there is none, or the robot has no inverse kinematics here.
pub fn test_cube(chain: &Chain, cube: &TestCube) -> Result<IsoCube, AcceptanceError> {
    let nothing = ErrorModel::new(chain.clone(), Vec::new())?;
    let ideal = FittedModel::new(nothing, Vec::new(), DMatrix::zeros(0, 0))?;
    let with = |starts| CompensatorOptions {
        starts,
        position_tolerance: 1e-9,
        orientation_tolerance: 1e-9,
        ..CompensatorOptions::default()
    };
    let mut reach = Reach {
        chain,
        near: Compensator::bind(&ideal, &Schema::default(), with(0))?,
        far: Compensator::bind(&ideal, &Schema::default(), with(24))?,
        oriented: chain.movable().len() >= 6,
    };
    let edges = cube.edge.map_or(EDGES.to_vec(), |edge| vec![edge]);
    let mut best: Option<(f64, f64, IsoCube)> = None;
    for k in 0..POSTURES {
        let Some(middle) = reach.middle(cube, k) else { continue };
        for &edge in &edges {
            if best.as_ref().is_some_and(|(largest, ..)| edge < *largest) {
                break;
            }
            let Some((margin, found)) = reach.cube(&middle, edge) else { continue };
            if best.as_ref().is_none_or(|(largest, room, _)| edge > *largest || margin > *room) {
                best = Some((edge, margin, found));
            }
            break;
        }
        // A given centre has few postures.
        if cube.centre.is_some() && k >= POSTURES / 8 && best.is_some() {
            break;
        }
    }
    let smallest = edges.last().copied().unwrap_or(0.0);
    best.map(|(.., found)| found).ok_or(AcceptanceError::NoCube { smallest })
}

struct Reach<'m> {
    chain: &'m Chain,
    near: Compensator<'m>,
    far: Compensator<'m>,
    oriented: bool,
}

/// A posture with its tool in the base frame.
struct Middle {
    joints: Vec<f64>,
    pose: Pose,
}

impl Reach<'_> {
    /// The k-th posture in the middle of the ranges, moved to the centre and orientation that are asked for.
    fn middle(&mut self, cube: &TestCube, k: usize) -> Option<Middle> {
        let joints: Vec<f64> = self
            .chain
            .movable()
            .iter()
            .enumerate()
            .map(|(j, &joint)| {
                let (low, high) = self.chain.joint(joint).limits.unwrap_or((-1.5, 1.5));
                let (low, high) = (low.max(-std::f64::consts::PI), high.min(std::f64::consts::PI));
                0.5 * (low + high) + MIDDLE * (high - low) * (halton(k + 1, PRIMES[j % PRIMES.len()]) - 0.5)
            })
            .collect();
        let to_base = self.chain.base().pose.inverse();
        let pose = to_base * self.chain.forward(&joints);
        if cube.centre.is_none() && cube.rpy.is_none() {
            return Some(Middle { joints, pose });
        }
        let position = cube.centre.map_or(pose.translation, Vector3::from);
        let rotation = cube.rpy.map_or(pose.rotation, |rpy| Pose::from_xyz_rpy([0.0; 3], rpy).rotation);
        let pose = Pose::new(rotation, position);
        let joints = self.solve(&pose, &joints, true)?;
        Some(Middle { joints, pose })
    }

    /// The cube about a posture: the smallest distance of a joint from its limits, as a part of its range.
    fn cube(&mut self, middle: &Middle, edge: f64) -> Option<(f64, IsoCube)> {
        let half = 0.5 * edge;
        let at = |x: f64, y: f64, z: f64| {
            Pose::new(middle.pose.rotation, middle.pose.translation + Vector3::new(x, y, z) * half)
        };
        let mut margin = self.margin(&middle.joints);
        let mut reached = |pose: Pose| {
            let joints = self.solve(&pose, &middle.joints, false)?;
            margin = margin.min(self.margin(&joints));
            Some(joints)
        };
        // The plane's corners, and the others.
        let plane = [(-1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (1.0, 1.0, 1.0), (1.0, -1.0, 1.0)];
        let others = [(1.0, -1.0, -1.0), (1.0, 1.0, -1.0), (-1.0, 1.0, 1.0), (-1.0, -1.0, 1.0)];
        for (x, y, z) in others.into_iter().chain(plane) {
            reached(at(x, y, z))?;
        }
        let mut poses = vec![IsoPose { number: 1, joints: middle.joints.clone(), pose: middle.pose }];
        for (number, (x, y, z)) in (2..).zip(plane) {
            let pose = at(0.8 * x, 0.8 * y, 0.8 * z);
            let joints = reached(pose)?;
            poses.push(IsoPose { number, joints, pose });
        }
        Some((margin, IsoCube { edge, centre: middle.pose.translation, poses }))
    }

    fn margin(&self, joints: &[f64]) -> f64 {
        let one = |(&joint, &q): (&truepose_kinematics::JointId, &f64)| {
            let (low, high) = self.chain.joint(joint).limits?;
            Some((q - low).min(high - q) / (high - low))
        };
        self.chain.movable().iter().zip(joints).filter_map(one).fold(0.5, f64::min)
    }

    fn solve(&mut self, pose: &Pose, seed: &[f64], anywhere: bool) -> Option<Vec<f64>> {
        let wanted = self.chain.base().pose * *pose;
        let mut target = Target::at(wanted.translation);
        if self.oriented {
            target = target.turned(wanted.rotation);
        }
        let conditions = Conditions::at(self.chain, seed);
        let solver = if anywhere { &mut self.far } else { &mut self.near };
        let command = solver.command(&target, &conditions, Some(seed));
        let joints = command.joints.to_vec();
        let stays = |(k, (a, b)): (usize, (&f64, &f64))| {
            self.chain.joint(self.chain.movable()[k]).unit() == "m" || (a - b).abs() < FAR
        };
        let near = anywhere || joints.iter().zip(seed).enumerate().all(stays);
        let allowed = self.chain.within_controller_limits(&joints);
        (command.status == Status::Ok && near && allowed).then_some(joints)
    }
}

const PRIMES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];

/// Halton's sequence.
fn halton(mut index: usize, base: usize) -> f64 {
    let (mut value, mut part) = (0.0, 1.0);
    while index > 0 {
        part /= base as f64;
        value += part * (index % base) as f64;
        index /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn the_five_poses_lie_in_the_inclined_plane_of_a_cube_that_is_reached() {
        let chain = samples::ur10();
        let cube = test_cube(&chain, &TestCube::default()).unwrap();
        assert!(cube.edge >= 0.4, "{}", cube.edge);
        let to_base = chain.base().pose.inverse();
        for pose in &cube.poses {
            let there = to_base * chain.forward(&pose.joints);
            assert!((there.translation - pose.pose.translation).norm() < 1e-8);
            let by = pose.pose.translation - cube.centre;
            // x = z in the plane; 0.8 of the way to a corner.
            assert!((by.x - by.z).abs() < 1e-12);
            let expected = if pose.number == 1 { 0.0 } else { 0.4 * cube.edge * 3f64.sqrt() };
            assert!((by.norm() - expected).abs() < 1e-12);
        }
        assert_eq!(cube.poses.iter().map(|p| p.number).collect::<Vec<_>>(), [1, 2, 3, 4, 5]);
        assert_eq!(test_cube(&chain, &TestCube::default()).unwrap(), cube);
    }

    #[test]
    fn a_given_cube_is_made_or_refused() {
        let chain = samples::ur10();
        let asked = TestCube { edge: Some(0.3), centre: Some([0.6, 0.1, 0.4]), rpy: Some([3.0, 0.0, 0.0]) };
        let cube = test_cube(&chain, &asked).unwrap();
        assert!(
            (cube.centre - Vector3::new(0.6, 0.1, 0.4)).norm() < 1e-12 && (cube.edge - 0.3).abs() < 1e-12
        );
        let far = TestCube { centre: Some([9.0, 0.0, 0.0]), ..asked };
        assert!(matches!(test_cube(&chain, &far), Err(AcceptanceError::NoCube { .. })));
    }

    #[test]
    fn robots_with_few_joints_have_a_cube_as_well() {
        for chain in [samples::scara(), samples::seven()] {
            let cube = test_cube(&chain, &TestCube::default()).unwrap();
            assert!(cube.edge > 0.01, "{}: {}", chain.name(), cube.edge);
        }
    }
}
