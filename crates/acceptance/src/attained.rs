//! Attained poses from measured rows: which rows repeat which pose, in the robot's base frame, beside the command.
//!
//! ```text
//! x_j = M B⁻¹ (p_j − d_j)        R_j = M B⁻¹ D_j⁻¹ R_meas
//! ```
//!
//! | symbol | here | frame |
//! | --- | --- | --- |
//! | p_j, R_meas | measured position of the target and orientation of the tool, the mean of the readings of one dwell | measurement |
//! | d_j, D_j | displacement and rotation of the real robot from the nominal one that the model predicts; zero before the fit | measurement |
//! | B | nominal base | measurement |
//! | M | best fit of the attained means to the commands; one where frames are as described | base |

use crate::best_fit::best_fit;
use crate::error::AcceptanceError;
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeMap;
use truepose_errormodel::{Dataset, configurations};
use truepose_kinematics::{Chain, Load, Pose, TargetId, rotation_log};

/// Where the frames of instrument and robot come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Alignment {
    /// As described (or as found by the fit).
    Described,
    /// The attained means are moved rigidly onto the commanded positions.
    BestFit,
}

/// One cycle of a pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Cycle {
    /// Attained position, m, base frame.
    pub position: Vector3<f64>,
    /// Rotation vector of R_j R_cᵀ, rad, base frame; none without an orientation.
    pub rotation: Option<Vector3<f64>>,
    /// Number of the cycle: the channel `cycle`, or the rank of the pose measurement.
    pub number: i64,
    /// When, s.
    pub time: Option<f64>,
    /// Direction of approach, as a number in this pose.
    pub direction: usize,
}

/// A pose that was measured more than once.
#[derive(Debug, Clone, PartialEq)]
pub struct TestPose {
    /// `P1`, …
    pub name: String,
    /// The row of its first reading.
    pub row: usize,
    /// Commanded position of the target and orientation of the tool, m, base frame.
    pub commanded: Pose,
    /// Variables of the joints, mean, rad or m.
    pub joints: Vec<f64>,
    /// The measured target; none: the tool's origin.
    pub target: Option<TargetId>,
    /// The load.
    pub load: Load,
    /// In the order of time.
    pub cycles: Vec<Cycle>,
    /// Number of directions of approach that were told apart.
    pub directions: usize,
    /// RMS of the stated standard deviations of an axis, m; none where none are stated.
    pub stated_sd: Option<f64>,
}

impl TestPose {
    /// Attained minus commanded, m, of the cycles of a direction (none: of all).
    pub fn deviations(&self, direction: Option<usize>) -> Vec<Vector3<f64>> {
        self.of(direction).map(|cycle| cycle.position - self.commanded.translation).collect()
    }

    /// Rotation vectors of the cycles of a direction, rad; empty where one of them has none.
    pub fn rotations(&self, direction: Option<usize>) -> Vec<Vector3<f64>> {
        let all: Option<Vec<_>> = self.of(direction).map(|cycle| cycle.rotation).collect();
        all.unwrap_or_default()
    }

    /// The cycles of a direction.
    pub fn of(&self, direction: Option<usize>) -> impl Iterator<Item = &Cycle> {
        self.cycles.iter().filter(move |cycle| direction.is_none_or(|d| cycle.direction == d))
    }

    /// The direction with the most cycles.
    pub fn main_direction(&self) -> Option<usize> {
        let count = |d: usize| self.of(Some(d)).count();
        (0..self.directions).rev().max_by_key(|&d| count(d)).filter(|_| self.directions > 1)
    }
}

/// Poses with what was left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Attained {
    /// Poses with two cycles at least, in the order of their first measurement, or of their number in the channel `pose`.
    pub poses: Vec<TestPose>,
    /// Poses that were measured once.
    pub once: usize,
    /// Rows without a whole position.
    pub partial: usize,
    /// M of a best fit.
    pub motion: Option<Pose>,
}

/// A direction stands for itself from so many cycles on where it follows from the order of the poses.
const FEWEST_OF_DIRECTION: usize = 5;

/// Gathers repeats. `commanded` has a pose for each row in the base frame, `displaced` the displacement D of each row (rotation and
/// translation, measurement frame) that the model predicts.
///
/// # Errors
/// When no pose was repeated, or a best fit is not determined.
pub fn attained(
    data: &Dataset,
    chain: &Chain,
    commanded: &[Pose],
    displaced: Option<&[Pose]>,
    alignment: Alignment,
) -> Result<Attained, AcceptanceError> {
    let to_base = chain.base().pose.inverse();
    let configuration = configurations(data);
    let number = |name: &str, row: usize| data.schema.channel(name).map(|k| data.channels[k][row]);
    // Rows of one target of one pose measurement are readings of one dwell.
    let mut dwells: BTreeMap<(usize, usize, usize), Vec<usize>> = BTreeMap::new();
    let mut partial = 0;
    for row in 0..data.len() {
        if data.position[row].iter().any(|v| v.is_nan()) {
            partial += 1;
            continue;
        }
        let target = data.target[row].map_or(0, |t| t.0 + 1);
        dwells.entry((configuration[data.visit[row]], target, data.visit[row])).or_default().push(row);
    }
    let mut groups: BTreeMap<(usize, usize), Vec<Vec<usize>>> = BTreeMap::new();
    for ((configuration, target, _), rows) in dwells {
        groups.entry((configuration, target)).or_default().push(rows);
    }
    let mut poses = Vec::new();
    let mut once = 0;
    let several_targets = groups.keys().map(|k| k.1).collect::<std::collections::BTreeSet<_>>().len() > 1;
    for (place, ((_, target), mut visits)) in groups.into_iter().enumerate() {
        if visits.len() < 2 {
            once += 1;
            continue;
        }
        if data.schema.time {
            visits.sort_by(|a, b| data.time[a[0]].total_cmp(&data.time[b[0]]));
        }
        let rows: Vec<usize> = visits.iter().flatten().copied().collect();
        let first = rows[0];
        let n = rows.len() as f64;
        let position = rows.iter().map(|&row| commanded[row].translation).sum::<Vector3<f64>>() / n;
        let command = Pose::new(commanded[first].rotation, position);
        let (direction_of, directions) = directions(data, &visits);
        let cycles = visits.iter().zip(direction_of).enumerate().map(|(rank, (rows, direction))| {
            let at = |&row: &usize| {
                let moved = displaced.map_or_else(Vector3::zeros, |all| all[row].translation);
                to_base.apply(&(data.measured_position(row) - moved))
            };
            let turned = |&row: &usize| -> Option<Vector3<f64>> {
                let back = displaced.map_or_else(Matrix3::identity, |all| all[row].rotation.transpose());
                let tool = to_base.rotation * back * data.measured_rotation(row)?;
                Some(rotation_log(&(tool * command.rotation.transpose())))
            };
            let rotations: Option<Vec<Vector3<f64>>> = rows.iter().map(turned).collect();
            let readings = rows.len() as f64;
            Cycle {
                position: rows.iter().map(at).sum::<Vector3<f64>>() / readings,
                rotation: rotations.map(|all| all.iter().sum::<Vector3<f64>>() / readings),
                number: number("cycle", rows[0]).map_or(rank as i64, |v| v.round() as i64),
                time: data.schema.time.then(|| data.time[rows[0]]),
                direction,
            }
        });
        let cycles: Vec<Cycle> = cycles.collect();
        let stated: Vec<f64> =
            rows.iter().flat_map(|&row| data.position_sd[row]).filter(|sd| !sd.is_nan()).collect();
        let mean = |column: &Vec<f64>| rows.iter().map(|&row| column[row]).sum::<f64>() / n;
        let label = number("pose", first).map_or(place as i64 + 1, |v| v.round() as i64);
        let target_name = target.checked_sub(1).filter(|_| several_targets).map(|t| &chain.targets()[t].name);
        poses.push((
            label,
            TestPose {
                name: target_name.map_or_else(|| format!("P{label}"), |name| format!("P{label} {name}")),
                row: first,
                commanded: command,
                joints: data.joints.iter().map(mean).collect(),
                target: target.checked_sub(1).map(TargetId),
                load: data.load[first],
                cycles,
                directions,
                stated_sd: (!stated.is_empty())
                    .then(|| (stated.iter().map(|s| s * s).sum::<f64>() / stated.len() as f64).sqrt()),
            },
        ));
    }
    if poses.is_empty() {
        return Err(AcceptanceError::NoRepeats);
    }
    if data.schema.channel("pose").is_some() {
        poses.sort_by_key(|pose| pose.0);
    } else {
        // Poses that were measured once have no number.
        let numbers: BTreeMap<i64, usize> = poses.iter().map(|pose| pose.0).zip(1..).collect();
        for (label, pose) in &mut poses {
            let rest = pose.name.split_once(' ').map_or(String::new(), |(_, rest)| format!(" {rest}"));
            pose.name = format!("P{}{rest}", numbers[label]);
        }
    }
    let mut poses: Vec<TestPose> = poses.into_iter().map(|pose| pose.1).collect();
    distinguish_loads(&mut poses);
    let motion = match alignment {
        Alignment::Described => None,
        Alignment::BestFit => Some(aligned(&mut poses)?),
    };
    Ok(Attained { poses, once, partial, motion })
}

/// Poses of one name at different loads get the mass in their names.
fn distinguish_loads(poses: &mut [TestPose]) {
    let names: Vec<String> = poses.iter().map(|pose| pose.name.clone()).collect();
    for (k, pose) in poses.iter_mut().enumerate() {
        let shared = names.iter().enumerate().any(|(other, name)| other != k && *name == names[k]);
        if shared {
            pose.name += &match pose.load {
                Load::None => ", unloaded".to_owned(),
                Load::Payload(payload) => format!(", {} kg", payload.mass),
                Load::Wrench(_) => format!(", {}", k + 1),
            };
        }
    }
}

/// Moves all cycles by the best fit of their means.
fn aligned(poses: &mut [TestPose]) -> Result<Pose, AcceptanceError> {
    let pair = |pose: &TestPose| {
        let n = pose.cycles.len() as f64;
        (pose.cycles.iter().map(|c| c.position).sum::<Vector3<f64>>() / n, pose.commanded.translation)
    };
    let pairs: Vec<_> = poses.iter().map(pair).collect();
    let motion = best_fit(&pairs)?;
    for pose in poses {
        let command = pose.commanded.rotation;
        for cycle in &mut pose.cycles {
            cycle.position = motion.apply(&cycle.position);
            cycle.rotation = cycle.rotation.map(|v| {
                let tool = motion.rotation * truepose_kinematics::rotation_vector(&v) * command;
                rotation_log(&(tool * command.transpose()))
            });
        }
    }
    Ok(motion)
}

/// The direction of approach of each pose measurement, and how many there are: the channel `direction`, or the signs in which the joints
/// moved last. The latter stand for themselves from some cycles on; others, as that of the first pose of a file, go to the largest.
fn directions(data: &Dataset, visits: &[Vec<usize>]) -> (Vec<usize>, usize) {
    let channel = data.schema.channel("direction");
    let signature = |rows: &Vec<usize>| -> Vec<i64> {
        match channel {
            Some(k) => vec![data.channels[k][rows[0]].round() as i64],
            None => data.approach.iter().map(|column| column[rows[0]] as i64).collect(),
        }
    };
    let signatures: Vec<Vec<i64>> = visits.iter().map(signature).collect();
    let mut known: Vec<(&Vec<i64>, usize)> = Vec::new();
    for one in &signatures {
        match known.iter_mut().find(|(other, _)| *other == one) {
            Some((_, count)) => *count += 1,
            None => known.push((one, 1)),
        }
    }
    let least = if channel.is_some() { 2 } else { FEWEST_OF_DIRECTION };
    let kept: Vec<&Vec<i64>> =
        known.iter().filter(|(_, count)| *count >= least).map(|(one, _)| *one).collect();
    if kept.len() < 2 {
        return (vec![0; visits.len()], 1);
    }
    let largest = known.iter().rev().max_by_key(|(_, count)| *count).map(|(one, _)| *one);
    let place = |one: &Vec<i64>| {
        let own = kept.iter().position(|other| *other == one);
        own.or_else(|| kept.iter().position(|other| Some(*other) == largest)).unwrap_or(0)
    };
    (signatures.iter().map(place).collect(), kept.len())
}
