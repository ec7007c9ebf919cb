//! All characteristics of one state of a robot: as it is, or with the identified model.

use crate::attained::{Attained, TestPose};
use crate::compliance::Compliance;
use crate::distance::{DistanceFigures, distance_figures};
use crate::drift::{BLOCK, DriftFigures, drift_figures};
use crate::figure::Figure;
use crate::multi_direction::{MultiDirection, multi_direction};
use crate::path::PathFigures;
use crate::pose::{PoseFigures, pose_figures};
use nalgebra::Vector3;
use truepose_kinematics::Pose;

/// Figures of one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedFigures {
    /// `P1`, …
    pub name: String,
    /// Commanded position, m, base frame.
    pub commanded: [f64; 3],
    /// AP and RP, of the direction of approach with the most cycles.
    pub pose: PoseFigures,
    /// vAP, where the pose was approached from several directions.
    pub directions: Option<MultiDirection>,
    /// dAP and dRP, where there are two blocks of cycles.
    pub drift: Option<DriftFigures>,
    /// Attained minus commanded of each cycle, m, base frame.
    pub deviations: Vec<[f64; 3]>,
}

/// Figures of every pose and pair of poses.
#[derive(Debug, Clone, PartialEq)]
pub struct Characteristics {
    /// Poses in the order of their numbers.
    pub poses: Vec<NamedFigures>,
    /// AD and RD of pairs of poses (their places in `poses`): P2 and P4 of the standard, or the two farthest from each other.
    pub distances: Vec<(usize, usize, DistanceFigures)>,
    /// Static compliance, where a load varies.
    pub compliance: Vec<Compliance>,
    /// AT and RT, where a path was measured.
    pub path: Option<PathFigures>,
    /// The motion of a best fit.
    pub motion: Option<Pose>,
}

impl Characteristics {
    /// Of attained poses; `common` is the standard uncertainty that readings of a pose share, m.
    pub fn of(attained: &Attained, common: f64, compliance: Vec<Compliance>) -> Self {
        let poses = attained.poses.iter().map(|pose| named(pose, common)).collect();
        let distances = pairs(&attained.poses)
            .into_iter()
            .filter_map(|(a, b)| Some((a, b, between(&attained.poses[a], &attained.poses[b], common)?)))
            .collect();
        Characteristics { poses, distances, compliance, path: None, motion: attained.motion }
    }

    /// The largest of a figure over the poses.
    pub fn largest(&self, of: fn(&NamedFigures) -> Option<&Figure>) -> Option<(&NamedFigures, &Figure)> {
        let all = self.poses.iter().filter_map(|pose| Some((pose, of(pose)?)));
        // The first of equals.
        all.reduce(|most, next| if next.1.value > most.1.value { next } else { most })
    }
}

fn named(pose: &TestPose, common: f64) -> NamedFigures {
    let main = pose.main_direction();
    let (positions, rotations) = (pose.deviations(main), pose.rotations(main));
    let times: Option<Vec<f64>> = pose.of(main).map(|cycle| cycle.time).collect();
    let each = |d: usize| (pose.deviations(Some(d)), pose.rotations(Some(d)));
    let (by_direction, turned): (Vec<_>, Vec<_>) = (0..pose.directions).map(each).unzip();
    NamedFigures {
        name: pose.name.clone(),
        commanded: pose.commanded.translation.into(),
        pose: pose_figures(&positions, &rotations, common),
        directions: (pose.directions > 1).then(|| multi_direction(&by_direction, &turned)),
        drift: (positions.len() >= 2 * BLOCK).then(|| drift_figures(&positions, times.as_deref())).flatten(),
        deviations: positions.iter().map(|v| (*v).into()).collect(),
    }
}

/// P2 and P4, where poses have these names; else the two whose commanded positions are farthest apart.
fn pairs(poses: &[TestPose]) -> Vec<(usize, usize)> {
    let called = |name: &str| poses.iter().position(|pose| pose.name == name);
    if let (Some(a), Some(b), true) = (called("P2"), called("P4"), poses.len() == 5) {
        return vec![(a, b)];
    }
    let apart = |a: usize, b: usize| (poses[a].commanded.translation - poses[b].commanded.translation).norm();
    let mut farthest: Option<(usize, usize)> = None;
    for a in 0..poses.len() {
        for b in a + 1..poses.len() {
            let longer = farthest.is_none_or(|(c, d)| apart(a, b) > apart(c, d));
            if longer && poses[a].target == poses[b].target && apart(a, b) > 0.0 {
                farthest = Some((a, b));
            }
        }
    }
    farthest.into_iter().collect()
}

/// AD and RD over the cycles that both poses have; none with fewer than two.
fn between(a: &TestPose, b: &TestPose, common: f64) -> Option<DistanceFigures> {
    let (of_a, of_b) = (a.main_direction(), b.main_direction());
    let both: Vec<[Vector3<f64>; 2]> = a
        .of(of_a)
        .filter_map(|cycle| {
            let other = b.of(of_b).find(|other| other.number == cycle.number)?;
            Some([cycle.position, other.position])
        })
        .collect();
    let commanded = [a.commanded.translation, b.commanded.translation];
    (both.len() >= 2).then(|| distance_figures(&both, commanded, common))
}
