//! What grows, and by how much: emitted at a posture, and in a block of rows.

use super::{Grows, Thermal};
use crate::Emission;
use crate::lanes::{LaneEmission, LanePosture, LaneValue};
use truepose_kinematics::{Axis, Chain, JointId, JointKind, Posture, Site};

impl Thermal {
    /// Emits what grows by one kelvin, from a column on; `at_reference` with the scale at the reference.
    pub(super) fn grow(
        &self,
        first: usize,
        warmer: f64,
        at_reference: bool,
        at: &Posture<'_>,
        out: &mut Emission,
    ) {
        let chain = at.chain();
        if self.grows == Some(Grows::Arm) {
            for &joint in chain.movable() {
                if chain.joint(joint).kind == JointKind::Prismatic
                    && let Some(motion) = chain.joint_motion(joint)
                {
                    out.along(first, &motion, at.joint(joint) * warmer);
                }
                lengthen(joint, first, warmer, at, out);
            }
            return;
        }
        match self.growth(chain) {
            Some((joint, Grows::Length)) => lengthen(joint, first, warmer, at, out),
            Some((joint, Grows::Scale)) => {
                if let Some(motion) = chain.joint_motion(joint) {
                    out.along(first, &motion, at.joint(joint) * warmer);
                    if self.offset && at_reference {
                        out.along(first + 1, &motion, at.joint(joint));
                    }
                }
            }
            _ => self.spot.put(self.components.as_deref(), (first, 1), warmer, at, out),
        }
    }

    /// As [`Thermal::grow`], in a block of rows.
    pub(super) fn grow_lanes(
        &self,
        (first, at_reference): (usize, bool),
        warmer: LaneValue,
        at: &LanePosture<'_>,
        out: &mut LaneEmission,
    ) {
        let chain = at.chain();
        let slid = |joint: JointId, out: &mut LaneEmission| {
            let place = at.joint(joint).map(|place| out.value(|into| into.copy_from_slice(place)));
            place.zip(chain.joint_motion(joint))
        };
        let lengthen = |joint: JointId, out: &mut LaneEmission| {
            let (root, tip) = chain.link(joint);
            out.shift(first, chain.frame_after(joint), &(tip - root), warmer);
        };
        if self.grows == Some(Grows::Arm) {
            for &joint in chain.movable() {
                if chain.joint(joint).kind == JointKind::Prismatic
                    && let Some((place, motion)) = slid(joint, out)
                {
                    let longer = out.product(place, warmer);
                    out.along(first, &motion, longer);
                }
                lengthen(joint, out);
            }
            return;
        }
        match self.growth(chain) {
            Some((joint, Grows::Length)) => lengthen(joint, out),
            Some((joint, Grows::Scale)) => {
                if let Some((place, motion)) = slid(joint, out) {
                    let longer = out.product(place, warmer);
                    out.along(first, &motion, longer);
                    if self.offset && at_reference {
                        out.along(first + 1, &motion, place);
                    }
                }
            }
            _ => self.spot.put_lanes(self.components.as_deref(), (first, 1), warmer, (chain, out)),
        }
    }

    /// How many columns a time constant has, with the scale at the reference.
    pub(super) fn count(&self, chain: &Chain) -> usize {
        match self.growth(chain) {
            _ if self.grows == Some(Grows::Arm) => 1,
            Some((_, Grows::Scale)) => 1 + usize::from(self.offset),
            Some((_, Grows::Length)) => 1,
            _ => self.spot.count(self.components.as_deref()),
        }
    }
}

/// The link behind a joint grows by this strain.
fn lengthen(joint: JointId, column: usize, strain: f64, at: &Posture<'_>, out: &mut Emission) {
    let ((root, tip), frame) = (at.chain().link(joint), at.chain().frame_after(joint));
    let longer = (tip - root) * strain;
    for axis in Axis::TRANSLATIONS {
        out.push(column, Site::Frame(frame, axis), longer[axis.direction()]);
    }
}
