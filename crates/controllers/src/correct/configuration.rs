//! The configuration of an arm with six turning joints whose last three axes meet, in the words of controllers.
//!
//! ```text
//! front = (W − o_1) · (z_2 × z_1)            which side of axis 1 the wrist is on
//! elbow = ((o_3 − o_2) × (W − o_3)) · z_2    which side of the line from axis 2 to axis 3
//! ```
//!
//! | symbol | here | shape | unit | frame |
//! | --- | --- | --- | --- | --- |
//! | W | `wrist` | 3 | m | measurement |
//! | o_i, z_i | `axes` | 3, 3 | m, 1 | measurement |
//!
//! Their signs are held against those at a posture whose configuration is known: for KUKA A2 = −90°, A3 = 90°, the others small, which has
//! status bits 0 and 1 = 0 and 1; for ABB and FANUC all axes at zero, which is in front and elbow up. The wrist is the sign of axis 5:
//! KUKA's bit 2 and ABB's cfx are 1 where it is negative, FANUC's N is where it is negative. Stäubli's lefty is in front, epositive as at
//! axis 3 = 60°, wpositive where axis 5 is not negative.
//!
//! A tool that moves along a line or an arc keeps all three: W is then, for arms whose axes 2, 3 and 4 are parallel, where axes 5 and 6 meet,
//! and o_4 takes its place for the elbow.

use crate::program::Branch;
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Conditions, JointKind, PostureBuffer};

/// Axes that pass each other within this meet, m: nominal dimensions have no more decimals.
const MEET: f64 = 1e-5;

/// Axes within this are parallel, rad: of arms with a calibration of the maker's own.
const PARALLEL: f64 = 0.02;

/// The sine of the wrist below which it is stretched out: 3°.
const STRETCHED: f64 = 0.05;

/// Angles closer than this to where a turn number changes have both, degrees: points are rounded to hundredths of mm and degrees, which
/// a posture within the limits of singularity amplifies at most fifty times.
const EITHER: f64 = 0.5;

/// Corrected joints closer than this to it keep the number of the point, degrees: below it lies the resolution of numbers in programs.
const KEEPS: f64 = 1e-4;

/// Where the wrist is in front of axis 1 by less than this, m, the elbow is bent by less, m², or the sine of the wrist is less, either side is
/// the same configuration.
const OPEN: [f64; 3] = [1e-3, 1e-4, 1e-2];

/// The arm's configuration at some joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Configuration {
    /// In front of axis 1 or behind, as at the reference posture or not.
    front: bool,
    /// Elbow as at the reference posture or not.
    elbow: bool,
    /// Axis 5 is not negative.
    wrist: bool,
}

/// Reads the configurations of one robot.
#[derive(Debug, Clone)]
pub(super) struct Arm<'c> {
    chain: &'c Chain,
    buffer: PostureBuffer,
    /// The last three axes meet; otherwise axes 2, 3 and 4 are parallel.
    meets: bool,
}

impl<'c> Arm<'c> {
    /// Of an arm with six turning joints whose last three axes meet, or whose second to fourth axis are parallel.
    pub(super) fn of(chain: &'c Chain) -> Option<Self> {
        let turns = chain.movable().iter().all(|&joint| chain.joint(joint).kind == JointKind::Revolute);
        if chain.movable().len() != 6 || !turns {
            return None;
        }
        let mut arm = Arm { chain, buffer: PostureBuffer::new(chain), meets: true };
        let some = [0.1, -0.7, 0.9, 0.3, 0.5, 0.2];
        if arm.sides(&some).is_none() {
            arm.meets = false;
            arm.sides(&some)?;
        }
        Some(arm)
    }

    /// Whether controllers describe its configurations.
    pub(super) fn meets(&self) -> bool {
        self.meets
    }

    /// Origin and direction of each axis, measurement frame.
    fn axes(&mut self, joints: &[f64]) -> Vec<(Vector3<f64>, Vector3<f64>)> {
        let conditions = Conditions::at(self.chain, joints);
        let posture = self.buffer.update(self.chain, &conditions);
        let motions = self.chain.movable().iter().filter_map(|&joint| self.chain.joint_motion(joint));
        motions
            .map(|motion| {
                let at = posture.frame(motion.frame);
                (at.translation, at.rotation * motion.axis)
            })
            .collect()
    }

    /// Front in m, elbow in m², and the sine of the wrist; none where the axes are not those of such an arm.
    fn sides(&mut self, joints: &[f64]) -> Option<[f64; 3]> {
        let axes = self.axes(joints);
        let [(o1, z1), (o2, z2), (o3, z3), (o4, z4), (o5, z5), (o6, z6)] = axes[..] else { return None };
        let sine = z4.cross(&z6).dot(&z5);
        if !self.meets {
            let parallel = z2.cross(&z3).norm().max(z2.cross(&z4).norm());
            let wrist = meeting(o5, z5, o6, z6).filter(|_| parallel < PARALLEL)?;
            let front = (wrist - o1).dot(&z2.cross(&z1));
            return Some([front, (o3 - o2).cross(&(o4 - o3)).dot(&z2), sine]);
        }
        let wrist = meeting(o4, z4, o5, z5).or_else(|| meeting(o5, z5, o6, z6))?;
        let off = |o: Vector3<f64>, z: Vector3<f64>| (wrist - o).cross(&z).norm();
        if off(o4, z4) > MEET || off(o5, z5) > MEET || off(o6, z6) > MEET {
            return None;
        }
        let front = (wrist - o1).dot(&z2.cross(&z1));
        let elbow = (o3 - o2).cross(&(wrist - o3)).dot(&z2);
        Some([front, elbow, sine])
    }

    /// Whether shoulder, elbow and wrist are on the same sides at both.
    pub(super) fn keeps(&mut self, a: &[f64], b: &[f64]) -> bool {
        let (Some(a), Some(b)) = (self.sides(a), self.sides(b)) else { return false };
        (0..3).all(|k| a[k].abs() < OPEN[k] || b[k].abs() < OPEN[k] || (a[k] < 0.0) == (b[k] < 0.0))
    }

    /// Whether the axes 4 and 6 are nearly parallel.
    pub(super) fn stretched(&mut self, joints: &[f64]) -> bool {
        self.sides(joints).is_some_and(|sides| sides[2].abs() < STRETCHED)
    }

    /// The configuration at these joints (variables), with the reference posture of a controller's values in degrees.
    pub(super) fn configuration(&mut self, joints: &[f64], branch: &Branch) -> Option<Configuration> {
        if !self.meets {
            return None;
        }
        let reference = match branch {
            Branch::Kuka { .. } => [0.0, -90.0, 90.0, 0.0, 45.0, 0.0],
            Branch::Val3 { .. } => [0.0, 30.0, 60.0, 0.0, 45.0, 0.0],
            _ => [0.0, 0.0, 0.0, 0.0, 45.0, 0.0],
        };
        let mut known = reference.map(f64::to_radians).to_vec();
        self.chain.joints_from_controller(&mut known);
        let [front, elbow, _] = self.sides(&known)?;
        let [here_front, here_elbow, _] = self.sides(joints)?;
        let wrist = degrees(self.chain, joints).get(4).is_some_and(|&angle| angle >= 0.0);
        Some(Configuration { front: front * here_front >= 0.0, elbow: elbow * here_elbow >= 0.0, wrist })
    }
}

/// The controller's values in degrees.
pub(super) fn degrees(chain: &Chain, joints: &[f64]) -> Vec<f64> {
    let mut values = joints.to_vec();
    chain.joints_to_controller(&mut values);
    values.iter().map(|value| value.to_degrees()).collect()
}

/// Where two lines come nearest; none for parallel ones.
fn meeting(a: Vector3<f64>, u: Vector3<f64>, b: Vector3<f64>, v: Vector3<f64>) -> Option<Vector3<f64>> {
    let across = u.cross(&v);
    let square = across.norm_squared();
    (square > 1e-6).then(|| a + u * ((b - a).cross(&v).dot(&across) / square))
}

impl Configuration {
    /// KUKA's status bits 0 to 2.
    fn status(self) -> i64 {
        i64::from(!self.front) + 2 * i64::from(self.elbow) + 4 * i64::from(!self.wrist)
    }

    /// ABB's cfx.
    fn cfx(self) -> i64 {
        4 * i64::from(!self.front) + 2 * i64::from(!self.elbow) + i64::from(!self.wrist)
    }

    /// Whether the letters of the point are those of this configuration.
    pub(super) fn fits(self, branch: &Branch) -> bool {
        match branch {
            Branch::Kuka { status, .. } => self.status() == status & 7,
            Branch::Abb([.., cfx]) => self.cfx() == *cfx,
            Branch::Fanuc { flip, up, toward, .. } => {
                self.wrist == *flip && self.elbow == *up && self.front == *toward
            }
            Branch::Val3 { lefty, elbow, wrist } => {
                lefty.is_none_or(|lefty| lefty == self.front)
                    && elbow.is_none_or(|positive| positive == self.elbow)
                    && wrist.is_none_or(|positive| positive == self.wrist)
            }
            _ => true,
        }
    }
}

/// Whether the turn numbers of a point may be those of these joints, controller's values in degrees.
pub(super) fn turns_fit(branch: &Branch, angles: &[f64], axes: Option<[usize; 3]>) -> bool {
    match branch {
        Branch::Kuka { turn: Some(turn), .. } => angles
            .iter()
            .enumerate()
            .all(|(k, &angle)| angle.abs() < EITHER || (angle < 0.0) == (turn >> k & 1 == 1)),
        Branch::Abb([cf1, cf4, cf6, _]) => {
            [(0, cf1), (3, cf4), (5, cf6)].iter().all(|&(k, cf)| near_step(angles[k], 90.0, 0.0, *cf, EITHER))
        }
        Branch::Fanuc { turns, .. } => match axes {
            Some(axes) => axes
                .iter()
                .zip(turns)
                .all(|(&axis, turn)| near_step(angles[axis - 1], 360.0, 180.0, *turn, EITHER)),
            None => angles.iter().all(|angle| angle.abs() <= 180.0 + EITHER),
        },
        _ => true,
    }
}

/// The turn numbers to be written for corrected joints: those of the point where they hold.
///
/// # Errors
/// When they are not known.
pub(super) fn turns_of(
    branch: &Branch,
    angles: &[f64],
    axes: Option<[usize; 3]>,
) -> Result<Vec<i64>, String> {
    Ok(match branch {
        Branch::Kuka { turn: Some(turn), .. } => {
            let bit = |(k, &angle): (usize, &f64)| {
                let old = turn >> k & 1;
                let new = i64::from(angle < 0.0);
                (if angle.abs() < KEEPS { old } else { new }) << k
            };
            // Bits above the sixth are of external axes.
            vec![angles.iter().enumerate().map(bit).sum::<i64>() | (turn & !63)]
        }
        Branch::Abb([cf1, cf4, cf6, _]) => {
            [(0, cf1), (3, cf4), (5, cf6)].map(|(k, cf)| step(angles[k], 90.0, 0.0, *cf)).to_vec()
        }
        Branch::Fanuc { turns, .. } => {
            match axes {
                Some(axes) => axes
                    .iter()
                    .zip(turns)
                    .map(|(&axis, turn)| step(angles[axis - 1], 360.0, 180.0, *turn))
                    .collect(),
                None if angles.iter().all(|angle| angle.abs() <= 180.0 + KEEPS) => turns.to_vec(),
                None => return Err(
                    "an axis passes 180°, and which axes the turn numbers are of is not known (--turn-axes)"
                        .into(),
                ),
            }
        }
        _ => Vec::new(),
    })
}

/// Whether ⌊(angle + offset) / width⌋ is this number, or may be.
fn near_step(angle: f64, width: f64, offset: f64, number: i64, slack: f64) -> bool {
    let lower = number as f64 * width - offset;
    angle > lower - slack && angle < lower + width + slack
}

fn step(angle: f64, width: f64, offset: f64, old: i64) -> i64 {
    if near_step(angle, width, offset, old, KEEPS) { old } else { ((angle + offset) / width).floor() as i64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;
    use truepose_kinematics::{Placement, samples};

    #[test]
    fn turn_numbers_follow_the_joints_and_stay_where_they_hold() {
        let kuka = Branch::Kuka { status: 2, turn: Some(0b001010) };
        assert!(turns_fit(&kuka, &[5.0, -90.0, 90.0, -3.0, 45.0, 0.1], None));
        assert!(!turns_fit(&kuka, &[5.0, -90.0, 90.0, 3.0, 45.0, 0.0], None));
        assert_eq!(turns_of(&kuka, &[5.0, -90.0, 90.0, 0.2, 45.0, -0.3], None), Ok(vec![0b100010]));
        assert_eq!(turns_of(&kuka, &[5.0, -90.0, 90.0, 1e-6, 45.0, -1e-6], None), Ok(vec![0b001010]));
        let abb = Branch::Abb([0, -1, 1, 0]);
        assert!(turns_fit(&abb, &[45.0, 0.0, 0.0, -10.0, 5.0, 91.0], None));
        assert!(!turns_fit(&abb, &[45.0, 0.0, 0.0, 10.0, 5.0, 91.0], None));
        assert_eq!(turns_of(&abb, &[-0.01, 0.0, 0.0, -10.0, 5.0, 180.2], None), Ok(vec![-1, -1, 2]));
        let fanuc = Branch::Fanuc { flip: false, up: true, toward: true, turns: [0, 0, 0] };
        assert!(turns_of(&fanuc, &[0.0, 0.0, 0.0, 0.0, -90.0, 180.5], None).is_err());
        assert_eq!(turns_of(&fanuc, &[0.0, 0.0, 0.0, 0.0, -90.0, 180.5], Some([1, 4, 6])), Ok(vec![0, 0, 1]));
    }

    #[test]
    fn only_arms_whose_wrist_axes_meet_have_configurations() {
        let ur10 = samples::ur10();
        assert!(!Arm::of(&ur10).unwrap().meets());
        assert!(Arm::of(&samples::pps()).is_none());
        // KUKA's zero: the arm stretched out horizontally.
        let heavy = samples::heavy();
        let mut arm = Arm::of(&heavy).unwrap();
        let kuka = Branch::Kuka { status: 0, turn: None };
        let status = |arm: &mut Arm<'_>, q: [f64; 6]| arm.configuration(&q, &kuka).unwrap().status();
        assert_eq!(status(&mut arm, [0.4, -1.5, 1.2, 0.0, 0.5, 0.0]), 2);
        assert_eq!(status(&mut arm, [0.4, -1.5, 1.2, 0.0, -0.5, 0.0]), 6);
        assert_eq!(status(&mut arm, [0.4, -0.5, -1.2, 0.0, 0.5, 0.0]), 0);
        assert_eq!(status(&mut arm, [0.4, -1.9, 0.1, 0.0, 0.5, 0.0]) & 1, 1);
        // ABB's and FANUC's: the upper arm stands, the forearm is horizontal.
        let joints = heavy.joints().iter().enumerate().map(|(k, joint)| {
            let mut joint = joint.clone();
            if let Placement::Mdh { theta, .. } = &mut joint.placement {
                *theta += [0.0, -FRAC_PI_2, FRAC_PI_2, 0.0, 0.0, 0.0][k];
            }
            joint
        });
        let upright = Chain::new("upright", joints.collect()).unwrap();
        let mut arm = Arm::of(&upright).unwrap();
        let cfx = |arm: &mut Arm<'_>, q: [f64; 6]| arm.configuration(&q, &Branch::Abb([0; 4])).unwrap().cfx();
        assert_eq!(cfx(&mut arm, [0.3, 0.1, 0.1, 0.2, 0.5, 0.0]), 0);
        assert_eq!(cfx(&mut arm, [0.3, 0.1, 0.1, 0.2, -0.5, 0.0]), 1);
        assert_eq!(cfx(&mut arm, [0.3, 0.9, -1.9, 0.2, 0.5, 0.0]), 2);
        assert_eq!(cfx(&mut arm, [0.3, -1.5, -0.5, 0.2, 0.5, 0.0]), 4);
    }
}
