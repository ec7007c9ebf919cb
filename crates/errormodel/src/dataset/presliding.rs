//! A derived channel: how far the friction of a joint is wound up, from the way of the joint through all poses.
//!
//! ```text
//! dz/dq = (1 − z sgn(dq))/w      along a straight move by Δ:  z ← s − (s − z) exp(−|Δ|/w),  s = sgn Δ
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | z | state of the friction, its torque over the largest: 1 after a long move upward, −1 after a long one downward | 1 |
//! | w | pre-sliding distance | rad or m |
//! | Δ | move of the joint from one pose to the next | rad or m |
//!
//! z = 0 at the first pose of the record. The channel is called by the joint's number in the robot (from 1, fixed joints count) and w:
//! `z_3~w=0.05`. A controller makes it with [`presliding`], move by move.
//!
//! Source: Dahl, *A solid friction model* (1968), exponent 1.

use super::table::Dataset;
use truepose_kinematics::JointId;

/// What stands between the joint's number and the distance.
const WIDTH: &str = "~w=";

/// The name of the channel of a joint's friction with this pre-sliding distance, rad or m.
pub fn presliding_channel(joint: JointId, width: f64) -> String {
    format!("z_{}{WIDTH}{width}", joint.0)
}

/// Joint and pre-sliding distance (rad or m) of a channel of this name; none of other channels.
pub fn presliding_of(channel: &str) -> Option<(JointId, f64)> {
    let (joint, width) = channel.strip_prefix("z_")?.split_once(WIDTH)?;
    let width = width.parse().ok().filter(|width: &f64| width.is_finite() && *width > 0.0)?;
    let number = joint.parse().ok().filter(|&number| number > 0)?;
    Some((JointId(number), width))
}

/// The state of a joint's friction after a straight move by `step` from the state `z`; `width` is the pre-sliding distance (rad or m, as
/// `step`).
pub fn presliding(z: f64, step: f64, width: f64) -> f64 {
    if step == 0.0 { z } else { step.signum() - (step.signum() - z) * (-step.abs() / width).exp() }
}

impl Dataset {
    /// The moves of a movable joint (by its column) from each pose of the whole record to the next, rad or m.
    pub fn moves(&self, joint: usize) -> Vec<f64> {
        self.whole().moves(joint)
    }

    /// The state of the friction of a movable joint (by its column) at every row, for a pre-sliding distance in rad or m.
    pub fn presliding(&self, joint: usize, width: f64) -> Vec<f64> {
        self.whole().follow(joint, |z, step| presliding(z, step, width))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(joint: &[f64], approach: &[f64]) -> Dataset {
        let n = joint.len();
        Dataset {
            joints: vec![joint.to_vec()],
            approach: vec![approach.to_vec()],
            visit: (0..n).collect(),
            time: vec![0.0; n],
            position: vec![[0.0; 3]; n],
            orientation: vec![None; n],
            position_sd: vec![[f64::NAN; 3]; n],
            orientation_sd: vec![[f64::NAN; 3]; n],
            target: vec![None; n],
            load: vec![truepose_kinematics::Load::None; n],
            ..Dataset::default()
        }
    }

    #[test]
    fn it_is_the_differential_equation() {
        let joint = [0.0, 0.03, 0.02, 0.02, -0.4, -0.35];
        let found = path(&joint, &[0.0; 6]).presliding(0, 0.05);
        // In small steps of the equation, without its solution.
        let (mut z, mut q) = (0.0, 0.0);
        for (expected, found) in joint.into_iter().zip(found) {
            let count = 200_000;
            let step = (expected - q) / f64::from(count);
            for _ in 0..count {
                let middle = z + 0.5 * step * (1.0 - z * step.signum()) / 0.05;
                z += step * (1.0 - middle * step.signum()) / 0.05;
            }
            q = expected;
            assert!((z - found).abs() < 1e-9, "at {q}: {z} {found}");
        }
    }

    #[test]
    fn a_part_of_the_rows_remembers_the_way_between_them() {
        let data = path(&[0.0, 0.3, 0.28, 0.5, 0.46, 0.4], &[0.0; 6]);
        let whole = data.presliding(0, 0.04);
        let part = data.select(&[5, 1, 4]).select(&[0, 2]);
        assert_eq!(part.presliding(0, 0.04), [whole[5], whole[4]]);
    }

    #[test]
    fn time_is_the_order_and_a_stated_approach_is_believed() {
        let mut data = path(&[0.0, 0.5, 0.1], &[0.0, 1.0, -1.0]);
        data.time = vec![0.0, 2.0, 1.0];
        data.schema.time = true;
        let z = data.presliding(0, 0.1);
        // First up by 0.1, against which a downward approach is stated; then up by 0.4.
        assert_eq!(z[..1], [0.0]);
        assert_eq!(z[2..], [-1.0]);
        assert!((z[1] - (1.0 - 2.0 * (-4.0f64).exp())).abs() < 1e-15);
    }

    #[test]
    fn names_read_back() {
        let name = presliding_channel(JointId(3), 0.05);
        assert_eq!(name, "z_3~w=0.05");
        assert_eq!(presliding_of(&name), Some((JointId(3), 0.05)));
        for other in ["z_3", "z_a~w=1", "z_3~w=0", "z_0~w=1", "temperature~lag=600", "z_3~w=inf"] {
            assert_eq!(presliding_of(other), None, "{other}");
        }
    }
}
