//! Robots that branch: two arms on a torso, a head beside an arm.
//!
//! Frames are numbered so that the frame in front of a joint has a smaller number than the frame behind it; tools come last. What stands
//! between the base and a tool is a chain like any other: frames that do not carry the tool have no part in where it is, but their weights
//! load the joints that carry both.

use crate::kept_length::KeptLength;
use crate::{Chain, ChainError, FrameId, JointId, Placed, Tool, ToolId};

impl Chain {
    /// With these joints in front of each joint (none: the base), in the order of [`Chain::joints`]. The tools stay where they are.
    ///
    /// # Errors
    /// [`ChainError::Count`] when the list is not one a joint, [`ChainError::ParentBehind`] when one hangs on a joint that is not before it.
    pub fn with_parents(mut self, parents: &[Option<JointId>]) -> Result<Self, ChainError> {
        Self::counted("joints in front of a joint", parents.len(), self.joints().len())?;
        for (index, joint) in self.joints().iter().enumerate() {
            if parents[index].is_some_and(|parent| parent.0 == 0 || parent.0 > index) {
                return Err(ChainError::ParentBehind { name: joint.name.clone() });
            }
        }
        self.parents = parents.iter().map(|parent| parent.map_or(FrameId::BASE, |p| FrameId(p.0))).collect();
        self.length = KeptLength::default();
        self.find_paths();
        Ok(self)
    }

    /// With these tools; targets belong to the first one until they are declared again.
    ///
    /// # Errors
    /// When there is none, a name is empty or stands twice, a frame is not a joint's or the base, or a pose is not finite.
    pub fn with_tools(mut self, mut tools: Vec<Tool>) -> Result<Self, ChainError> {
        if tools.is_empty() {
            return Err(ChainError::Count { what: "tools", have: 0, need: 1 });
        }
        for (index, tool) in tools.iter().enumerate() {
            if tool.name.is_empty() {
                return Err(ChainError::EmptyName { what: "tool", number: index + 1 });
            }
            if tools[..index].iter().any(|other| other.name == tool.name) {
                return Err(ChainError::DuplicateName { what: "tools", name: tool.name.clone() });
            }
            if tool.frame.0 > self.joints().len() {
                let (joint, joints) = (tool.frame.0, self.joints().len());
                return Err(ChainError::NoSuchJoint { tool: tool.name.clone(), joint, joints });
            }
            if !tool.placed.pose.is_finite() {
                return Err(ChainError::NotFinite { what: "the pose", name: tool.name.clone() });
            }
        }
        if let [only] = tools.as_mut_slice() {
            only.word = "tool".into();
        }
        self.tools = tools;
        self.find_paths();
        let targets = self.targets().to_vec();
        self.with_targets(targets)
    }

    /// With the branches and the tools of another description of the same joints.
    ///
    /// # Errors
    /// When the joints are others.
    pub fn branched_as(mut self, other: &Chain) -> Result<Self, ChainError> {
        Self::counted("joints", self.joints().len(), other.joints().len())?;
        self.parents.clone_from(&other.parents);
        self.with_tools(other.tools.clone())
    }

    /// With these poses of the tools, in the order of [`Chain::tools`].
    ///
    /// # Errors
    /// When a pose is not finite, or there are not as many as tools.
    pub fn with_placed_tools(self, placed: &[Placed]) -> Result<Self, ChainError> {
        Self::counted("poses of tools", placed.len(), self.tools.len())?;
        let tools = self.tools.iter().zip(placed).map(|(tool, &placed)| Tool { placed, ..tool.clone() });
        let tools = tools.collect();
        self.with_tools(tools)
    }

    /// With what this makes of the pose of each tool.
    ///
    /// # Errors
    /// When a pose is not finite.
    pub fn map_tools(self, made: impl Fn(&Placed) -> Placed) -> Result<Self, ChainError> {
        let placed: Vec<Placed> = self.tools.iter().map(|tool| made(&tool.placed)).collect();
        self.with_placed_tools(&placed)
    }

    /// Whether the poses of all tools are known.
    pub fn tools_known(&self) -> bool {
        self.tools.iter().all(|tool| tool.placed.known)
    }

    /// The tools; one of most robots.
    pub fn tools(&self) -> &[Tool] {
        &self.tools
    }

    /// The tool of this name.
    pub fn tool_named(&self, name: &str) -> Option<ToolId> {
        self.tools.iter().position(|tool| tool.name == name).map(ToolId)
    }

    /// True when all joints follow one another and the only tool is on the last one.
    #[inline]
    pub fn is_serial(&self) -> bool {
        self.paths.is_empty()
    }

    /// The frame in front of a joint.
    #[inline]
    pub fn before(&self, joint: JointId) -> FrameId {
        self.parents[joint.index()]
    }

    /// The frame in front of a joint's frame or a tool; none of the base.
    #[inline]
    pub fn parent(&self, frame: FrameId) -> Option<FrameId> {
        let index = frame.0.checked_sub(1)?;
        Some(match self.parents.get(index) {
            Some(&before) => before,
            None => self.tools[index - self.parents.len()].frame,
        })
    }

    /// Whether a tool stands, directly or not, on a frame: an error of the frame moves it. Each tool carries itself.
    #[inline]
    pub fn carries(&self, frame: FrameId, tool: ToolId) -> bool {
        self.paths.get(tool.0).is_none_or(|path| path[frame.0])
    }

    /// For each frame whether it carries the tool of this frame; none where all do.
    #[inline]
    pub fn path(&self, tool: FrameId) -> Option<&[bool]> {
        self.paths.get(tool.0.checked_sub(self.parents.len() + 1)?).map(Vec::as_slice)
    }

    /// The tool whose frame this is.
    pub fn tool_of(&self, frame: FrameId) -> Option<ToolId> {
        frame.0.checked_sub(self.parents.len() + 1).map(ToolId)
    }

    fn counted(what: &'static str, have: usize, need: usize) -> Result<(), ChainError> {
        if have == need { Ok(()) } else { Err(ChainError::Count { what, have, need }) }
    }

    fn find_paths(&mut self) {
        let serial = (0..self.parents.len()).map(FrameId).eq(self.parents.iter().copied())
            && self.tools.len() == 1
            && self.tools[0].frame.0 == self.parents.len();
        self.paths.clear();
        if serial {
            return;
        }
        for tool in (0..self.tools.len()).map(ToolId) {
            let mut path = vec![false; self.frame_count()];
            let mut next = Some(self.frame_of_tool(tool));
            while let Some(frame) = next {
                path[frame.0] = true;
                next = self.parent(frame);
            }
            self.paths.push(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Conditions, Joint, JointKind, Placement, PostureBuffer, Target, joint_jacobian, samples};
    use nalgebra::Vector3;

    #[test]
    fn a_branch_is_where_its_own_chain_is() {
        let tree = samples::dual();
        let q: Vec<f64> = (0..tree.movable().len()).map(|k| 0.5 - 0.17 * k as f64).collect();
        for tool in [ToolId(0), ToolId(1)] {
            let on_it = |index: &usize| tree.carries(FrameId(index + 1), tool);
            let joints: Vec<Joint> =
                (0..tree.joints().len()).filter(on_it).map(|k| tree.joints()[k].clone()).collect();
            let part: Vec<f64> = (0..tree.joints().len())
                .filter(on_it)
                .filter_map(|k| tree.coordinate(JointId(k + 1)))
                .map(|k| q[k])
                .collect();
            let alone = Chain::new("alone", joints).and_then(|c| c.with_base(*tree.base()));
            let alone = alone.and_then(|c| c.with_tool(tree.tools()[tool.0].placed)).unwrap();
            let (there, here) = (alone.forward(&part), tree.forward_to(tool, &q));
            assert!((there.translation - here.translation).norm() < 1e-14);
            assert!((there.rotation - here.rotation).norm() < 1e-14);
            let conditions = Conditions { tool, ..Conditions::at(&tree, &q) };
            let mut buffer = PostureBuffer::new(&tree);
            let posture = buffer.update(&tree, &conditions);
            assert!((posture.tool().translation - here.translation).norm() < 1e-14);
            // The joints of the other arm do not move it.
            let jacobian = joint_jacobian(&posture, &here.translation);
            for (k, &joint) in tree.movable().iter().enumerate() {
                let moved = |d: f64| {
                    let mut q = q.clone();
                    q[k] += d;
                    tree.forward_to(tool, &q).translation
                };
                let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                assert!((jacobian.fixed_view::<3, 1>(0, k) - slope).norm() < 1e-8);
                assert_eq!(slope.norm() > 0.0, tree.carries(tree.frame_after(joint), tool));
            }
        }
    }

    #[test]
    fn what_is_no_tree_is_said() {
        let joint = |name: &str| {
            Joint::new(name, JointKind::Revolute, Placement::Dh { theta: 0.0, d: 0.0, a: 1.0, alpha: 0.0 })
        };
        let chain = Chain::new("r", vec![joint("a"), joint("b")]).unwrap();
        assert!(chain.is_serial());
        let short = chain.clone().with_parents(&[None]).unwrap_err();
        assert_eq!(short.to_string(), "1 joints in front of a joint are given where 2 are needed");
        assert!(chain.clone().with_parents(&[None, None, None]).is_err());
        let far = Tool::on("far", Some(JointId(9)), Placed::default());
        let far = chain.clone().with_tools(vec![far]).unwrap_err();
        assert_eq!(far.to_string(), "tool `far` is on joint 9, and the robot has 2");
        let wrong = chain.clone().with_parents(&[Some(JointId(2)), None]).unwrap_err();
        assert_eq!(
            wrong.to_string(),
            "joint `a` hangs on a joint that is declared behind it; declare joints base first"
        );
        let two = |b: &str| {
            vec![Tool::on("l", Some(JointId(1)), Placed::default()), Tool::on(b, None, Placed::default())]
        };
        assert!(chain.clone().with_tools(two("l")).is_err());
        let chain = chain.with_tools(two("r")).unwrap();
        assert!(!chain.is_serial());
        assert_eq!(chain.frame_word(FrameId(4)), "tool r");
        assert_eq!(chain.frame_named("tool l"), Some(FrameId(3)));
        let at = |tool| Target { name: "T".into(), position: Vector3::zeros(), known: true, tool };
        assert!(chain.clone().with_targets(vec![at(ToolId(2))]).is_err());
        assert!(chain.with_targets(vec![at(ToolId(1))]).is_ok());
    }
}
