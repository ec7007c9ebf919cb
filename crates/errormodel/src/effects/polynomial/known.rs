//! Products of Eq. (17) in a block of rows: each is worked out once, however many errors have it.

use super::term::Term;
use crate::lanes::{LaneEmission, LanePosture, LaneValue};
use truepose_kinematics::{FrameId, JointId};

/// A component of a frame's wrench (0…5).
type Felt = (usize, FrameId);

/// What has been worked out.
#[derive(Default)]
pub(super) struct Known {
    joints: Vec<((JointId, u32), LaneValue)>,
    wrenches: Vec<((Felt, u32), LaneValue)>,
    products: Vec<((LaneValue, LaneValue), LaneValue)>,
}

impl Known {
    /// The values of a term; `own` is the frame whose wrench it means unless it says so.
    pub fn value(
        &mut self,
        term: Term,
        own: FrameId,
        at: &LanePosture<'_>,
        out: &mut LaneEmission,
    ) -> LaneValue {
        let joint = term.joint.map_or(LaneEmission::ONE, |key| match found(&self.joints, key) {
            Some(value) => value,
            None => {
                let value = out.value(|into| match at.joint(key.0) {
                    Some(joint) => power(into, joint, key.1),
                    None => into.fill(0.0),
                });
                self.joints.push((key, value));
                value
            }
        });
        let wrench = term.wrench.map_or(LaneEmission::ONE, |(component, raised, frame)| {
            let key = ((component.index(), frame.unwrap_or(own)), raised);
            match found(&self.wrenches, key) {
                Some(value) => value,
                None => {
                    let value = out.value(|into| {
                        at.wrench(key.0.1, key.0.0, into);
                        into.iter_mut().for_each(|w| *w = w.powi(raised as i32));
                    });
                    self.wrenches.push((key, value));
                    value
                }
            }
        });
        let key = (joint, wrench);
        match found(&self.products, key) {
            Some(value) => value,
            None => {
                let value = out.product(joint, wrench);
                self.products.push((key, value));
                value
            }
        }
    }
}

fn found<K: PartialEq + Copy>(known: &[(K, LaneValue)], key: K) -> Option<LaneValue> {
    known.iter().find(|(k, _)| *k == key).map(|(_, value)| *value)
}

fn power(into: &mut [f64], of: &[f64], power: u32) {
    into.copy_from_slice(of);
    for _ in 1..power {
        into.iter_mut().zip(of).for_each(|(into, of)| *into *= of);
    }
}
