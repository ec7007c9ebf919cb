//! The link behind a joint as a line: from the joint's place to the next one's, and what it carries at its tip.
//!
//! ```text
//!              Rz(θ_j)  Tz(d_j)           Tx(a) Rx(α)
//!   ── joint j ●━━━━━━━━━━━━━━━━━━━━━━━━━━━━━━━━━━━● joint k ── …       k: the next joint that moves, or the tool
//!            root      all that turns with joint j   tip
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | root, tip | [`Span`] | m | measurement |
//! | F, M | `tip_wrench`, about the tip | N, N·m | measurement |
//!
//! Where a turning joint sits on its axis is a matter of the description. With DH and MDH it is the foot of the common
//! normal that comes from the joint in front, so that `d_j`, which turns with joint j, belongs to link j in both
//! and one robot has the same links in either; with origin + axis it is the joint's origin. A slide sits on its carriage:
//! the rail in front of it grows with the travel. Fixed joints do not end a link.

use crate::{Chain, Joint, JointId, JointKind, Placement, Pose, Posture, Wrench};
use nalgebra::Vector3;

/// A link as a straight line, in the measurement frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// The joint in front of the link.
    pub joint: JointId,
    /// The next joint that moves; none when the link ends at the tool.
    pub next: Option<JointId>,
    /// Where the joint sits, m.
    pub root: Vector3<f64>,
    /// Where the next one sits, or the tool's origin, m.
    pub tip: Vector3<f64>,
}

impl Joint {
    /// Where the joint sits on its axis, in the frame in front of it, m; q in rad or m.
    pub fn seat(&self, q: f64) -> Vector3<f64> {
        match (self.placement, self.kind) {
            (Placement::Dh { .. }, JointKind::Revolute) => Vector3::zeros(),
            (Placement::Dh { d, .. }, JointKind::Prismatic) => Vector3::new(0.0, 0.0, d + q),
            (Placement::Mdh { a, .. }, JointKind::Revolute) => Vector3::new(a, 0.0, 0.0),
            (Placement::Origin { pose, .. }, JointKind::Revolute) => pose.translation,
            _ => self.transform(q).translation,
        }
    }

    /// Unit direction of the axis in the frame behind the joint, which is fixed to its link.
    pub fn axis_behind(&self) -> Vector3<f64> {
        match self.placement {
            // Rx(−α) takes z of the axis' frame there.
            Placement::Dh { alpha, .. } => Pose::rot(0, -alpha).rotation * Vector3::z(),
            Placement::Mdh { .. } => Vector3::z(),
            Placement::Origin { axis, .. } => axis.into_inner(),
        }
    }

    /// The middle of its limits, rad or m; zero where there are none.
    pub fn middle(&self) -> f64 {
        match self.limits {
            Some((lower, upper)) if (upper - lower).is_finite() => 0.5 * (lower + upper),
            _ => 0.0,
        }
    }
}

impl Chain {
    /// The joint that moves next after this one.
    pub fn next_movable(&self, joint: JointId) -> Option<JointId> {
        self.movable().iter().copied().find(|next| *next > joint)
    }

    /// Length of the link behind a joint with the joints at the middle of their limits, m.
    pub fn link_length(&self, joint: JointId) -> f64 {
        let here = self.joint(joint);
        let root = here.seat(here.middle());
        let next = self.next_movable(joint);
        let last = next.map_or(self.joints().len(), |next| next.0 - 1);
        let to_last = self.joints()[joint.index()..last]
            .iter()
            .fold(Pose::IDENTITY, |pose, joint| pose * joint.transform(joint.middle()));
        let seat = next.map_or(self.tool().pose.translation, |next| {
            let next = self.joint(next);
            next.seat(next.middle())
        });
        (to_last.apply(&seat) - root).norm()
    }
}

impl Posture<'_> {
    /// The link behind a joint.
    pub fn span(&self, joint: JointId) -> Span {
        let seat = |of: JointId| {
            let in_front: &Pose = self.frame(crate::FrameId(of.0 - 1));
            in_front.apply(&self.chain().joint(of).seat(self.joint(of)))
        };
        let next = self.chain().next_movable(joint);
        Span { joint, next, root: seat(joint), tip: next.map_or(self.tool().translation, seat) }
    }

    /// What the link carries at its tip (its own weight left out), about the tip, in the measurement frame's axes.
    pub fn tip_wrench(&self, span: &Span) -> Wrench {
        let frame = span.next.map_or(self.chain().tool_frame(), |next| self.chain().frame_after(next));
        let at = self.frame(frame);
        self.wrench(frame).rotated(&at.rotation).carried_to(&(at.translation - span.tip))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Conditions, PostureBuffer, samples};

    fn span(chain: &Chain, joint: usize, q: &[f64]) -> (f64, Span) {
        let conditions = Conditions::at(chain, q);
        let mut buffer = PostureBuffer::new(chain);
        let posture = buffer.update(chain, &conditions);
        let span = posture.span(JointId(joint));
        ((span.tip - span.root).norm(), span)
    }

    #[test]
    fn lengths_are_those_of_the_drawings() {
        let q = [0.3, -0.4, 0.5, 0.6, -0.7, 0.8];
        let ur10 = samples::ur10();
        let lengths: Vec<f64> = (1..=6).map(|j| span(&ur10, j, &q).0).collect();
        for (got, drawn) in lengths.iter().zip([0.1273, 0.612, 0.5723, 0.163941, 0.1157, 0.0922]) {
            assert!((got - drawn).abs() < 1e-12, "{lengths:?}");
        }
        // Column, upper arm, elbow, forearm (which turns with a4), wrist, flange with the tool.
        let heavy = samples::heavy();
        let (column, flange) = (0.65_f64.hypot(0.32), 0.46_f64.hypot(0.05));
        for (k, drawn) in [column, 1.1, 0.05, 1.15, 0.0, flange].into_iter().enumerate() {
            assert!((span(&heavy, k + 1, &q).0 - drawn).abs() < 1e-12, "link {}", k + 1);
            assert!((heavy.link_length(JointId(k + 1)) - drawn).abs() < 1e-12, "link {}", k + 1);
        }
    }

    #[test]
    fn a_rail_ends_at_its_carriage_and_fixed_joints_are_passed() {
        let pps = samples::pps();
        let at = |d2: f64| span(&pps, 1, &[0.0, d2, 0.0, 0.0, 0.0, 0.0]).0;
        assert!((at(0.2) - at(0.0) - 0.2).abs() < 1e-12);
        let skewed = samples::skewed();
        assert_eq!(span(&skewed, 1, &[0.0; 5]).1.next, Some(JointId(3)));
        assert_eq!(span(&skewed, 6, &[0.0; 5]).1.next, None);
    }

    #[test]
    fn an_axis_is_the_same_seen_from_its_link() {
        for chain in samples::all() {
            let conditions = Conditions::at(&chain, &vec![0.4; chain.movable().len()]);
            let mut buffer = PostureBuffer::new(&chain);
            let posture = buffer.update(&chain, &conditions);
            for &joint in chain.movable() {
                let motion = chain.joint_motion(joint).unwrap();
                let axis = posture.frame(motion.frame).rotation * motion.axis;
                let behind =
                    posture.frame(chain.frame_after(joint)).rotation * chain.joint(joint).axis_behind();
                assert!((axis - behind).norm() < 1e-14, "{} {}", chain.name(), joint.0);
            }
        }
    }

    #[test]
    fn the_tip_carries_what_the_joint_in_front_carries_less_its_own_weight() {
        let chain = samples::heavy();
        let conditions = Conditions::at(&chain, &[0.3, -0.4, 0.5, 0.6, -0.7, 0.8]);
        let mut buffer = PostureBuffer::new(&chain);
        let posture = buffer.update(&chain, &conditions);
        let span = posture.span(JointId(2));
        let tip = posture.tip_wrench(&span);
        let at = posture.frame(crate::FrameId(2));
        let link = chain.joint(JointId(2)).link.unwrap();
        let own = chain.gravity_in_measurement_frame() * link.mass;
        let whole = tip.carried_to(&(span.tip - at.translation));
        let moment = whole.moment + (at.rotation * link.com).cross(&own);
        let carried = posture.wrench(crate::FrameId(2)).rotated(&at.rotation);
        assert!((carried.force - whole.force - own).norm() < 1e-9);
        assert!((carried.moment - moment).norm() < 1e-9);
    }
}
