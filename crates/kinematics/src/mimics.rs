//! Joints without a drive of their own, which follow another one: `mimic` of a URDF.
//!
//! ```text
//! q_j = r q_d + o          dT/dq_d = J_d + r J_j
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | q_j, q_d | variables of the following joint and of the one that it follows | rad, m |
//! | r, o | [`Mimic::ratio`], [`Mimic::offset`] | of q_j per q_d, of q_j |
//!
//! Such a joint keeps its place among the movable joints and has frames, weights and errors of its own. Only its value is no input: wherever the
//! controller's values become variables ([`Chain::joints_from_controller`]) it is worked out, and no table has a column for it. Its own errors
//! act behind it. An error of the motion of the driving joint is not passed on: what moves is the value that the controller reports.

use crate::couplings::{Follower, Mimic};
use crate::{Chain, ChainError, JointId};

impl Chain {
    /// With joints that follow others.
    ///
    /// # Errors
    /// When a joint does not move, follows itself or two others, joints follow each other in a circle, a number is not finite, a ratio is zero,
    /// a coupled joint is concerned, or limits leave a driving joint no value.
    pub fn with_mimics(mut self, mimics: Vec<Mimic>) -> Result<Self, ChainError> {
        let wrong = |joint: JointId, reason: &'static str| {
            let name =
                self.joints().get(joint.index()).map_or_else(|| joint.0.to_string(), |of| of.name.clone());
            ChainError::Mimic { name, reason }
        };
        let mut followers: Vec<Follower> = Vec::new();
        for (number, mimic) in mimics.iter().enumerate() {
            let moves =
                |joint: JointId| Some(joint).filter(|j| j.0 > 0).and_then(|joint| self.coordinate(joint));
            let (Some(joint), Some(driver)) = (moves(mimic.joint), moves(mimic.driver)) else {
                return Err(wrong(mimic.joint, "it or the joint that it follows does not move"));
            };
            if mimics[..number].iter().any(|other| other.joint == mimic.joint) {
                return Err(wrong(mimic.joint, "it follows two joints; keep one of them"));
            }
            if !mimic.ratio.is_finite() || !mimic.offset.is_finite() || mimic.ratio == 0.0 {
                return Err(wrong(
                    mimic.joint,
                    "`ratio` has to be a finite number other than zero, `offset` a finite number",
                ));
            }
            let coupled =
                |joint: JointId| self.couplings().iter().any(|c| c.joint == joint || c.driver == joint);
            if coupled(mimic.joint) || self.couplings().iter().any(|c| c.joint == mimic.driver) {
                return Err(wrong(mimic.joint, "it or the joint that it follows is coupled as well"));
            }
            followers.push(Follower { joint, driver, ratio: mimic.ratio, offset: mimic.offset });
        }
        // Down to a joint with a value of its own.
        for k in 0..followers.len() {
            for _ in 0..=followers.len() {
                let Some(next) = followers.iter().position(|other| other.joint == followers[k].driver) else {
                    break;
                };
                let (through, own) = (followers[next], followers[k]);
                let offset = own.ratio * through.offset + own.offset;
                followers[k] =
                    Follower { driver: through.driver, ratio: own.ratio * through.ratio, offset, ..own };
            }
            if followers.iter().any(|other| other.joint == followers[k].driver) {
                return Err(wrong(mimics[k].joint, "joints follow each other in a circle"));
            }
        }
        self.couplings.mimics = mimics;
        self.couplings.followers = followers;
        for &joint in self.movable() {
            if self.controller_limits(joint).is_some_and(|(lower, upper)| lower > upper) {
                let name = self.joint(joint).name.clone();
                return Err(ChainError::Mimic {
                    name,
                    reason: "the limits of joints that follow it leave it no value",
                });
            }
        }
        Ok(self)
    }

    /// The joints that follow others, as declared; none of most robots.
    pub fn mimics(&self) -> &[Mimic] {
        &self.couplings.mimics
    }

    /// The same by coordinates, each with the joint whose value determines it.
    #[inline]
    pub fn followers(&self) -> &[Follower] {
        &self.couplings.followers
    }

    /// Whether the controller has a value for a movable joint, by its coordinate.
    pub fn is_commanded(&self, coordinate: usize) -> bool {
        self.followers().iter().all(|follower| follower.joint != coordinate)
    }

    /// Gives joints that follow others their values, in place: one number for each movable joint, rad or m.
    #[inline]
    pub fn follow(&self, joints: &mut [f64]) {
        self.couplings.follow(joints);
    }

    /// Whether the controller's values differ from the joints' variables, by couplings or joints that follow others.
    pub fn has_other_values(&self) -> bool {
        !(self.couplings().is_empty() && self.followers().is_empty())
    }

    /// Where limits of joints that follow it leave a joint, m or rad.
    pub(crate) fn narrowed(&self, joint: JointId, own: Option<(f64, f64)>) -> Option<(f64, f64)> {
        let mut limits = own;
        for follower in self.followers().iter().filter(|f| Some(f.driver) == self.coordinate(joint)) {
            let Some((lower, upper)) = self.joint(self.movable()[follower.joint]).limits else { continue };
            let ends = [lower, upper].map(|end| (end - follower.offset) / follower.ratio);
            let (lower, upper) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            limits = Some(limits.map_or((lower, upper), |own| (own.0.max(lower), own.1.min(upper))));
        }
        limits
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;

    fn mimic(joint: usize, driver: usize, ratio: f64, offset: f64) -> Mimic {
        Mimic { joint: JointId(joint), driver: JointId(driver), ratio, offset }
    }

    #[test]
    fn values_follow_through_several_joints_in_any_order() {
        let list = vec![mimic(6, 5, 2.0, 0.1), mimic(5, 2, -0.5, 0.3)];
        let chain = samples::ur10().with_mimics(list).unwrap();
        let mut q = [0.1, 0.4, 0.2, 0.3, 9.0, 9.0];
        chain.joints_from_controller(&mut q);
        let fifth = -0.5 * 0.4 + 0.3;
        assert!((q[4] - fifth).abs() < 1e-15 && (q[5] - (2.0 * fifth + 0.1)).abs() < 1e-15);
        let (before, mut back) = (q, q);
        chain.joints_to_controller(&mut back);
        assert!(before.iter().zip(back).all(|(before, back)| (before - back).abs() < 1e-15));
        assert_eq!(
            (0..6).map(|k| chain.is_commanded(k)).collect::<Vec<_>>(),
            [true, true, true, true, false, false]
        );
        assert_eq!(samples::ur10().coupled_as(&chain).unwrap().mimics(), chain.mimics());
    }

    #[test]
    fn limits_of_a_following_joint_hold_for_its_driver() {
        let mut chain = samples::ur10();
        chain.joint_mut(JointId(2)).limits = Some((-3.0, 3.0));
        chain.joint_mut(JointId(5)).limits = Some((-1.0, 0.5));
        let narrowed = chain.clone().with_mimics(vec![mimic(5, 2, -0.5, 0.0)]).unwrap();
        assert_eq!(narrowed.controller_limits(JointId(2)), Some((-1.0, 2.0)));
        let none = chain.with_mimics(vec![mimic(5, 2, -0.5, 90.0)]).unwrap_err().to_string();
        assert!(none.contains("leave it no value"), "{none}");
    }

    #[test]
    fn what_cannot_follow_is_refused() {
        let error = |list: Vec<Mimic>| samples::ur10().with_mimics(list).unwrap_err().to_string();
        assert!(error(vec![mimic(2, 2, 1.0, 0.0)]).contains("in a circle"));
        assert!(
            error(vec![mimic(2, 3, 1.0, 0.0), mimic(3, 4, 1.0, 0.0), mimic(4, 2, 1.0, 0.0)])
                .contains("in a circle")
        );
        assert!(error(vec![mimic(2, 9, 1.0, 0.0)]).contains("does not move"));
        assert!(error(vec![mimic(2, 0, 1.0, 0.0)]).contains("does not move"));
        assert!(error(vec![mimic(2, 3, 0.0, 0.0)]).contains("other than zero"));
        assert!(error(vec![mimic(2, 3, f64::NAN, 0.0)]).contains("finite"));
        assert!(error(vec![mimic(2, 3, 1.0, 0.0), mimic(2, 4, 1.0, 0.0)]).contains("follows two joints"));
    }
}
