//! Frames and sites of a robot: their numbers and their words.

use crate::{Axis, Chain, FrameId, JointId, Site, TargetId, ToolId};

impl Chain {
    /// The frame that files call `base`, `tool` (of several tools `tool NAME`), or by the name of the joint in front of it.
    pub fn frame_named(&self, name: &str) -> Option<FrameId> {
        if name == "base" {
            return Some(FrameId::BASE);
        }
        let tool = (0..self.tools.len()).map(|k| self.frame_of_tool(ToolId(k)));
        tool.into_iter()
            .find(|frame| self.frame_word(*frame) == name)
            .or_else(|| self.joint_named(name).map(|joint| self.frame_after(joint)))
    }

    /// The frame directly after a joint.
    pub fn frame_after(&self, joint: JointId) -> FrameId {
        FrameId(joint.0)
    }

    /// The first tool's frame, n + 1.
    #[inline]
    pub fn tool_frame(&self) -> FrameId {
        FrameId(self.joints().len() + 1)
    }

    /// A tool's frame.
    #[inline]
    pub fn frame_of_tool(&self, tool: ToolId) -> FrameId {
        FrameId(self.joints().len() + 1 + tool.0)
    }

    /// Number of frames: base, one after each joint, tools.
    #[inline]
    pub fn frame_count(&self) -> usize {
        self.joints().len() + 1 + self.tools.len()
    }

    /// All frames: base, one after each joint, tools.
    pub fn frames(&self) -> impl DoubleEndedIterator<Item = FrameId> + ExactSizeIterator + use<> {
        (0..self.frame_count()).map(FrameId)
    }

    /// The word for a frame in files and reports: `base`, a joint's name, or `tool`; of several tools `tool NAME`.
    pub fn frame_word(&self, frame: FrameId) -> &str {
        match frame {
            FrameId::BASE => "base",
            FrameId(i) if i <= self.joints().len() => &self.joints()[i - 1].name,
            FrameId(i) => &self.tools[i - 1 - self.joints().len()].word,
        }
    }

    /// How many generalized errors the robot has: six a frame and three a target of the description.
    pub fn site_count(&self) -> usize {
        6 * self.frame_count() + 3 * self.described_targets().len()
    }

    /// Position of a site in a vector of all generalized errors.
    #[inline]
    pub fn site_index(&self, site: Site) -> usize {
        match site {
            Site::Frame(frame, axis) => 6 * frame.0 + axis.index(),
            Site::Target(target, axis) => 6 * self.frame_count() + 3 * target.0 + axis.direction(),
        }
    }

    /// The site at a position of the vector of all generalized errors.
    #[inline]
    pub fn site_at(&self, index: usize) -> Site {
        let frames = 6 * self.frame_count();
        if index < frames {
            Site::Frame(FrameId(index / 6), Axis::ALL[index % 6])
        } else {
            Site::Target(TargetId((index - frames) / 3), Axis::ALL[(index - frames) % 3])
        }
    }

    /// `y@j2`, `rz@base`, `x@target P1`.
    pub fn site_word(&self, site: Site) -> String {
        match site {
            Site::Frame(frame, axis) => format!("{}@{}", axis.word(), self.frame_word(frame)),
            Site::Target(target, axis) => {
                format!("{}@target {}", axis.word(), self.targets()[target.0].name)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::samples;

    #[test]
    fn sites_come_back_from_their_index() {
        let robot = samples::pps();
        for index in 0..robot.site_count() {
            assert_eq!(robot.site_index(robot.site_at(index)), index);
        }
        assert_eq!(robot.site_word(robot.site_at(6 * 8)), "x@target P1");
    }
}
