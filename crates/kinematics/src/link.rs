//! The link behind a joint as a line: from the joint's place to the next one's, and what it carries at its tip.
//!
//! ```text
//!   ── joint j ●━━━━━━━━━━━━━━━━━━━━━● joint k ── …       k: the next joint that moves, or the tool
//!            root                   tip
//!   DH:            o_{j−1} … o_j        Tz(d_j) Tx(a_j) of A_j
//!   MDH, origin:   o_j … o_k            the translation of A_k
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | root, tip | [`Chain::link`] | m | behind joint j, which is fixed to its link |
//! | root, tip | [`Span`] | m | measurement |
//! | F, M | `tip_wrench`, about the tip | N, N·m | measurement |
//!
//! Where a turning joint sits on its axis is a matter of the description: it sits where the description puts the frame
//! about whose axis it turns. So a link is what lies between two neighbouring frames, and `d` belongs to the link in front
//! of the axis with MDH, to the one behind it with DH. A link is a body, so that its ends do not depend on q: a slide sits
//! where its carriage stands at zero. Fixed joints do not end a link.
//!
//! Wrists have links whose frames coincide. Such a link has a size nonetheless, of which the description says nothing:
//! the tool's offset (from the flange to the tool's origin, in the link's own axes) stands in for it.

use crate::{Chain, FrameId, Joint, JointId, JointKind, Placement, Pose, Posture, ToolId, Wrench};
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

/// Ends of a link that are nearer than this are one place, m.
const NO_LENGTH: f64 = 1e-6;

impl Joint {
    /// Where the joint sits on its axis, in the frame in front of it, at its zero, m.
    pub fn seat(&self) -> Vector3<f64> {
        match (self.placement, self.kind) {
            (Placement::Dh { d, .. }, JointKind::Prismatic) => Vector3::new(0.0, 0.0, d),
            (Placement::Dh { .. }, _) => Vector3::zeros(),
            _ => self.transform(0.0).translation,
        }
    }

    /// The same place in the frame behind the joint, which is fixed to its link; of a slide, its carriage.
    pub fn seat_behind(&self) -> Vector3<f64> {
        match self.placement {
            Placement::Dh { d, a, alpha, .. } => {
                let d = if self.kind == JointKind::Prismatic { 0.0 } else { d };
                Pose::rot(0, -alpha).rotation * -Vector3::new(a, 0.0, d)
            }
            _ => Vector3::zeros(),
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
}

impl Chain {
    /// The joint that moves next after this one: where joints branch, the first of them.
    pub fn next_movable(&self, joint: JointId) -> Option<JointId> {
        let follows = |next: &JointId| {
            *next > joint && (self.is_serial() || self.owner(self.before(*next)) == Some(joint))
        };
        self.movable().iter().copied().find(follows)
    }

    /// The joints whose frames are parts of the link behind a joint: itself, and the fixed ones on it.
    pub fn link_parts(&self, joint: JointId) -> impl Iterator<Item = JointId> + '_ {
        let all = joint.0..=self.joints().len();
        all.map(JointId).filter(move |part| self.owner(self.frame_after(*part)) == Some(joint))
    }

    /// The frames that end the link behind a joint: of the next joints that move, and of the tools on it.
    pub fn link_ends(&self, joint: JointId) -> impl Iterator<Item = FrameId> + '_ {
        self.frames().skip(joint.0 + 1).filter(move |frame| {
            let moves = |id: &JointId| self.joint(*id).moves();
            let ends = match self.tool_of(*frame) {
                Some(_) => true,
                None => moves(&JointId(frame.0)),
            };
            ends && self.parent(*frame).and_then(|before| self.owner(before)) == Some(joint)
        })
    }

    /// The joint on whose link a frame is; none where nothing in front of it moves.
    fn owner(&self, frame: FrameId) -> Option<JointId> {
        let mut next = Some(frame);
        while let Some(frame) = next {
            if self.tool_of(frame).is_none() && frame != FrameId::BASE && self.joint(JointId(frame.0)).moves()
            {
                return Some(JointId(frame.0));
            }
            next = self.parent(frame);
        }
        None
    }

    /// Where the link behind a joint begins and ends, in the axes of the frame behind the joint, m. Both are the same
    /// when it has no length: nor has the tool, then.
    pub fn link(&self, joint: JointId) -> (Vector3<f64>, Vector3<f64>) {
        let root = self.joint(joint).seat_behind();
        let mine = self.frame_after(joint);
        let next = self.next_movable(joint);
        let on_it = match self.is_serial() {
            true => next.is_none().then_some(ToolId::FIRST),
            false => self.link_ends(joint).find_map(|frame| self.tool_of(frame)),
        };
        let tool = &self.tools()[on_it.map_or(0, |tool| tool.0)];
        let (mut at, seat) = match (next, on_it) {
            (Some(next), _) => (self.before(next), self.joint(next).seat()),
            (None, Some(_)) => (tool.frame, tool.placed.pose.translation),
            (None, None) => (mine, Vector3::zeros()),
        };
        // From the last fixed joint back to the one that moves.
        let mut tip = seat;
        while at != mine {
            tip = self.joint(JointId(at.0)).transform(0.0).apply(&tip);
            at = self.parent(at).unwrap_or(mine);
        }
        if (tip - root).norm() < NO_LENGTH {
            (root, root + tool.placed.pose.translation)
        } else {
            (root, tip)
        }
    }

    /// Length of the link behind a joint, m.
    pub fn link_length(&self, joint: JointId) -> f64 {
        let (root, tip) = self.link(joint);
        (tip - root).norm()
    }
}

impl Posture<'_> {
    /// The link behind a joint.
    pub fn span(&self, joint: JointId) -> Span {
        let chain = self.chain();
        let (root, tip) = chain.link(joint);
        let behind = self.frame(chain.frame_after(joint));
        Span { joint, next: chain.next_movable(joint), root: behind.apply(&root), tip: behind.apply(&tip) }
    }

    /// What the link carries at its tip (its own weight left out), about the tip, in the measurement frame's axes.
    pub fn tip_wrench(&self, span: &Span) -> Wrench {
        let chain = self.chain();
        let carried = |frame: FrameId| {
            let at = self.frame(frame);
            self.wrench(frame).rotated(&at.rotation).carried_to(&(at.translation - span.tip))
        };
        if chain.is_serial() {
            return carried(span.next.map_or(chain.tool_frame(), |next| chain.frame_after(next)));
        }
        let mut whole = Wrench::default();
        for part in chain.link_ends(span.joint).map(carried) {
            whole.force += part.force;
            whole.moment += part.moment;
        }
        whole
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
        // Craig's convention: the column ends at the shoulder, the elbow carries the whole forearm, and of the wrist's
        // links two are no longer than the tool.
        let heavy = samples::heavy();
        let (forearm, tool) = (1.15_f64.hypot(0.05), 0.25_f64.hypot(0.05));
        for (k, drawn) in [0.32, 1.1, forearm, tool, 0.21, tool].into_iter().enumerate() {
            assert!((span(&heavy, k + 1, &q).0 - drawn).abs() < 1e-12, "link {}", k + 1);
            assert!((heavy.link_length(JointId(k + 1)) - drawn).abs() < 1e-12, "link {}", k + 1);
        }
    }

    #[test]
    fn a_link_does_not_change_with_the_joints() {
        for chain in samples::all() {
            let n = chain.movable().len();
            for &joint in chain.movable() {
                let here = span(&chain, joint.0, &vec![0.0; n]);
                let there = span(&chain, joint.0, &vec![0.2; n]);
                assert!((here.0 - there.0).abs() < 1e-12, "{} {}", chain.name(), joint.0);
            }
        }
    }

    #[test]
    fn fixed_joints_are_passed_and_slides_sit_on_their_carriage() {
        let skewed = samples::skewed();
        assert_eq!(span(&skewed, 1, &[0.0; 5]).1.next, Some(JointId(3)));
        assert_eq!(span(&skewed, 6, &[0.0; 5]).1.next, None);
        // s4 is a slide in standard DH: behind its carriage there is Tx(0.2) only.
        assert!((skewed.link_length(JointId(5)) - 0.2).abs() < 1e-12);
        // The joint sits on its axis, seen from either side.
        for chain in samples::all() {
            let q = vec![0.0; chain.movable().len()];
            for &joint in chain.movable() {
                let conditions = Conditions::at(&chain, &q);
                let mut buffer = PostureBuffer::new(&chain);
                let posture = buffer.update(&chain, &conditions);
                let own = chain.joint(joint);
                let in_front = posture.frame(crate::FrameId(joint.0 - 1)).apply(&own.seat());
                let behind = posture.frame(chain.frame_after(joint)).apply(&own.seat_behind());
                assert!((in_front - behind).norm() < 1e-12, "{} {}", chain.name(), joint.0);
            }
        }
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
