//! The poses of several postures.

use super::Lane;
use crate::prepared::PreparedJoint;
use crate::{Chain, Pose, three};
use nalgebra::{Matrix3, Vector3};
use pulp::Simd;

/// Poses of as many postures as a register holds.
#[derive(Debug, Clone, Copy)]
pub struct LanePose<S: Simd> {
    /// Columns of the rotation.
    pub rotation: [[Lane<S>; 3]; 3],
    /// m.
    pub translation: [Lane<S>; 3],
}

impl<S: Simd> LanePose<S> {
    /// The same pose in all.
    #[inline(always)]
    pub fn splat(simd: S, pose: &Pose) -> Self {
        let (r, p) = (&pose.rotation, &pose.translation);
        LanePose {
            rotation: three!(j => three!(i => Lane::splat(simd, r[(i, j)]))),
            translation: three!(i => Lane::splat(simd, p[i])),
        }
    }

    /// Moved by a constant vector in its own axes.
    #[inline(always)]
    pub fn moved(mut self, by: &Vector3<f64>) -> Self {
        for (column, by) in self.rotation.iter().zip(by.iter()) {
            if *by != 0.0 {
                for (p, r) in self.translation.iter_mut().zip(column) {
                    *p = p.plus(*r, *by);
                }
            }
        }
        self
    }

    /// Moved by a vector of lanes in its own axes.
    #[inline(always)]
    pub fn moved_lanes(mut self, by: [Lane<S>; 3]) -> Self {
        for (column, by) in self.rotation.iter().zip(by) {
            for (p, r) in self.translation.iter_mut().zip(column) {
                *p = r.mul_add(by, *p);
            }
        }
        self
    }

    /// Turned by a constant rotation.
    #[inline(always)]
    pub fn turned(mut self, by: &Matrix3<f64>) -> Self {
        let old = self.rotation;
        for (j, column) in self.rotation.iter_mut().enumerate() {
            for (i, r) in column.iter_mut().enumerate() {
                *r = match (by[(0, j)], by[(1, j)], by[(2, j)]) {
                    (1.0, 0.0, 0.0) => old[0][i],
                    (0.0, 1.0, 0.0) => old[1][i],
                    (0.0, 0.0, 1.0) => old[2][i],
                    (a, b, c) => old[0][i].times(a).plus(old[1][i], b).plus(old[2][i], c),
                };
            }
        }
        self
    }

    /// Turned by rotations of lanes, given as columns.
    #[inline(always)]
    pub fn turned_lanes(mut self, by: &[[Lane<S>; 3]; 3]) -> Self {
        let old = self.rotation;
        for (column, by) in self.rotation.iter_mut().zip(by) {
            for (i, r) in column.iter_mut().enumerate() {
                *r = old[2][i].mul_add(by[2], old[1][i].mul_add(by[1], old[0][i] * by[0]));
            }
        }
        self
    }

    /// Turned about one of its own axes (0…2), given sine and cosine.
    #[inline(always)]
    pub fn turned_about(mut self, axis: usize, sine: Lane<S>, cosine: Lane<S>) -> Self {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        for i in 0..3 {
            let (u, v) = (self.rotation[a][i], self.rotation[b][i]);
            self.rotation[a][i] = v.mul_add(sine, u * cosine);
            self.rotation[b][i] = u.take_from(sine, v * cosine);
        }
        self
    }

    /// Past a joint of the robot, at q (rad or m) with its sine and cosine: times `A_i(q)`.
    #[inline(always)]
    pub fn past(
        self,
        simd: S,
        chain: &Chain,
        joint: usize,
        q: Lane<S>,
        sine: Lane<S>,
        cosine: Lane<S>,
    ) -> Self {
        match chain.prepared_joint(joint) {
            PreparedJoint::Fixed(pose) => self.moved(&pose.translation).turned(&pose.rotation),
            PreparedJoint::Dh { theta, d, a, alpha } => {
                let (s, c) = added(*theta, sine, cosine);
                let turned = self.moved(&Vector3::new(0.0, 0.0, *d)).turned_about(2, s, c);
                turned.moved(&Vector3::new(*a, 0.0, 0.0)).turned_about(
                    0,
                    Lane::splat(simd, alpha.0),
                    Lane::splat(simd, alpha.1),
                )
            }
            PreparedJoint::Mdh { theta, d, a, alpha } => {
                let (s, c) = added(*theta, sine, cosine);
                let tilted = self.moved(&Vector3::new(*a, 0.0, 0.0));
                let tilted = tilted.turned_about(0, Lane::splat(simd, alpha.0), Lane::splat(simd, alpha.1));
                tilted.moved(&Vector3::new(0.0, 0.0, *d)).turned_about(2, s, c)
            }
            PreparedJoint::Turn { pose, direction, sign } => {
                let there = self.moved(&pose.translation).turned(&pose.rotation);
                there.turned_about(*direction, sine.times(*sign), cosine)
            }
            PreparedJoint::Skew { pose, axis } => {
                let there = self.moved(&pose.translation).turned(&pose.rotation);
                // I + sin K + (1 − cos) K².
                let (k, rest) = (crate::skew(axis), Lane::splat(simd, 1.0) - cosine);
                let square = k * k;
                let columns = three!(j => {
                    three!(i => {
                        let one = if i == j { 1.0 } else { 0.0 };
                        Lane::splat(simd, one).plus(sine, k[(i, j)]).plus(rest, square[(i, j)])
                    })
                });
                there.turned_lanes(&columns)
            }
            PreparedJoint::Slide { pose, along } => {
                let there = self.moved(&pose.translation);
                there.moved_lanes(three!(i => q.times(along[i]))).turned(&pose.rotation)
            }
        }
    }
}

/// Sine and cosine of a constant angle and one of lanes.
#[inline(always)]
fn added<S: Simd>((s0, c0): (f64, f64), sine: Lane<S>, cosine: Lane<S>) -> (Lane<S>, Lane<S>) {
    (sine.times(c0).plus(cosine, s0), cosine.times(c0).plus(sine, -s0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{samples, sin_cos};
    use pulp::{Arch, WithSimd};

    struct Forward<'a>(&'a Chain, &'a [f64]);

    impl WithSimd for Forward<'_> {
        type Output = Pose;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Pose {
            let Forward(chain, joints) = self;
            let mut pose = LanePose::splat(simd, &chain.base().pose);
            for joint in 0..chain.joints().len() {
                let q = chain.coordinate(crate::JointId(joint + 1)).map_or(0.0, |k| joints[k]);
                let (s, c) = sin_cos(q);
                let (q, s, c) = (Lane::splat(simd, q), Lane::splat(simd, s), Lane::splat(simd, c));
                pose = pose.past(simd, chain, joint, q, s, c);
            }
            let tool = chain.tool().pose;
            pose = pose.moved(&tool.translation).turned(&tool.rotation);
            let first = |lane: Lane<S>| simd.reduce_max_f64s(lane.value());
            Pose::new(
                Matrix3::from_fn(|i, j| first(pose.rotation[j][i])),
                Vector3::from_fn(|i, _| first(pose.translation[i])),
            )
        }
    }

    #[test]
    fn every_joint_of_every_convention_goes_where_the_scalar_one_goes() {
        for chain in samples::all() {
            let joints: Vec<f64> = (0..chain.movable().len()).map(|k| 0.4 - 0.31 * k as f64).collect();
            let (want, have) = (chain.forward(&joints), Arch::new().dispatch(Forward(&chain, &joints)));
            assert!((want.rotation - have.rotation).amax() < 1e-14, "{}", chain.name());
            assert!((want.translation - have.translation).amax() < 1e-14, "{}", chain.name());
        }
    }
}
