//! What people do to tables: each as a change that undoes it.

use super::cause::Cause;
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI};
use truepose_kinematics::{Chain, JointKind};

/// Every cause that is tried on this robot, the commonest first.
pub(super) fn causes(chain: &Chain) -> Vec<Cause> {
    let movable = chain.movable();
    let kind = |k: usize| chain.joint(movable[k]).kind;
    let n = movable.len();
    // A joint that follows another one has no column that could be wrong.
    let own = |k: &usize| chain.is_commanded(*k);
    let mut list = Vec::new();
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        list.push(Cause::SwappedAxes { a, b });
    }
    for axis in 0..3 {
        list.push(Cause::MirroredAxis { axis });
    }
    for factor in [1e-3, 1e3, 25.4e-3, 1.0 / 25.4e-3, 25.4, 1.0 / 25.4] {
        list.push(Cause::PositionUnit { factor });
    }
    for (wanted, factors) in
        [(JointKind::Revolute, [180.0 / PI, PI / 180.0]), (JointKind::Prismatic, [1e3, 1e-3])]
    {
        if (0..n).any(|k| kind(k) == wanted) {
            list.extend(factors.map(|factor| Cause::JointUnit { kind: wanted, factor }));
        }
    }
    let uniform = (1..n).all(|k| kind(k) == kind(0));
    if uniform && n > 2 && chain.followers().is_empty() {
        list.extend([1, n - 1].map(|by| Cause::ShiftedJoints { by }));
        list.push(Cause::ReversedJoints);
    }
    for b in (1..n).filter(own) {
        let alike = (0..b).filter(own).filter(|&a| kind(a) == kind(b));
        list.extend(alike.map(|a| Cause::SwappedJoints { a, b }));
    }
    list.extend((0..n).filter(own).map(|joint| Cause::NegatedJoint { joint }));
    for joint in (0..n).filter(own).filter(|&k| kind(k) == JointKind::Revolute) {
        list.extend([FRAC_PI_2, -FRAC_PI_2, PI].map(|by| Cause::OffsetJoint { joint, by }));
    }
    list.extend([Cause::StaleJoints { late: true }, Cause::StaleJoints { late: false }]);
    for b in 1..chain.described_targets().len() {
        list.extend((0..b).map(|a| Cause::SwappedTargets { a, b }));
    }
    list
}

/// A measured position with the cause undone.
pub(super) fn position(cause: &Cause, p: Vector3<f64>) -> Vector3<f64> {
    let mut p = p;
    match *cause {
        Cause::SwappedAxes { a, b } => p.swap_rows(a, b),
        Cause::MirroredAxis { axis } => p[axis] = -p[axis],
        Cause::PositionUnit { factor } => p *= factor,
        _ => (),
    }
    p
}

/// Joint values with the cause undone; joints that follow others do so.
pub(super) fn joints(cause: &Cause, chain: &Chain, q: &mut [f64]) {
    match *cause {
        Cause::JointUnit { kind, factor } => {
            for (q, &joint) in q.iter_mut().zip(chain.movable()) {
                if chain.joint(joint).kind == kind {
                    *q *= factor;
                }
            }
        }
        Cause::ShiftedJoints { by } => q.rotate_left(by % q.len().max(1)),
        Cause::ReversedJoints => q.reverse(),
        Cause::SwappedJoints { a, b } => q.swap(a, b),
        Cause::NegatedJoint { joint } => q[joint] = -q[joint],
        Cause::OffsetJoint { joint, by } => q[joint] += by,
        _ => (),
    }
    chain.follow(q);
}

/// The target with the cause undone.
pub(super) fn target(cause: &Cause, target: usize) -> usize {
    match *cause {
        // Offset 0 is the tool's origin.
        Cause::SwappedTargets { a, b } if target == a + 1 => b + 1,
        Cause::SwappedTargets { a, b } if target == b + 1 => a + 1,
        _ => target,
    }
}
