//! A length typical of an arm.
//!
//! Frames of neighbouring parallel axes may stand anywhere along them: the calibrated table of an arm of one metre can have offsets of hundreds of
//! metres that cancel. Where the distances between frames add up to far more than the shortest way through the axes, that way is the length.

use crate::{Chain, FrameId, JointKind, Pose, ToolId};
use nalgebra::Vector3;

/// The sum of the distances is believed up to so many times the shortest way.
const CANCELS: f64 = 3.0;
/// Sweeps over the points of that way: of each, half of an offset at least is left behind.
const SWEEPS: usize = 60;

impl Chain {
    /// A length typical of the arm, m: the sum of the nominal distances between neighbouring frames, travels of slides included; of a
    /// tree its longest branch. Angles times this length compare with lengths.
    pub fn characteristic_length(&self) -> f64 {
        *self.length.0.get_or_init(|| {
            let longest = (0..self.tools().len()).map(|k| self.length_to(ToolId(k))).fold(0.0, f64::max);
            if longest > 1e-6 { longest } else { 1.0 }
        })
    }

    fn length_to(&self, tool: ToolId) -> f64 {
        let (mut frames, mut travel) = (self.tools()[tool.0].placed.pose.translation.norm(), 0.0);
        for (index, joint) in self.joints().iter().enumerate() {
            if !self.carries(FrameId(index + 1), tool) {
                continue;
            }
            frames += joint.transform(0.0).translation.norm();
            if joint.kind == JointKind::Prismatic
                && let Some((lower, upper)) = joint.limits
                && (upper - lower).is_finite()
            {
                travel += upper - lower;
            }
        }
        let carried = self.targets().iter().filter(|target| target.tool == tool);
        let target = carried.map(|t| t.position.norm()).fold(0.0, f64::max);
        // Where a slide stands at zero is no point of the way: of an arm with slides all distances count.
        let slides = self.joints().iter().any(|joint| joint.kind == JointKind::Prismatic);
        let shortest = if slides { f64::INFINITY } else { self.shortest_way(tool) };
        travel + target + if frames > CANCELS * shortest { shortest } else { frames }
    }

    /// From the base over a point of each turning joint's axis to the tool, at zero: each point where the way over it is shortest, again and again.
    fn shortest_way(&self, tool: ToolId) -> f64 {
        let mut frames = vec![Pose::IDENTITY];
        for (index, joint) in self.joints().iter().enumerate() {
            let before = self.parent(FrameId(index + 1)).unwrap_or(FrameId(0));
            frames.push(frames[before.0] * joint.transform(0.0));
        }
        let mut points = vec![(Vector3::zeros(), Vector3::zeros())];
        for &joint in self.movable() {
            if !self.carries(FrameId(joint.index() + 1), tool) {
                continue;
            }
            if let Some(motion) = self.joint_motion(joint).filter(|motion| motion.kind == JointKind::Revolute)
            {
                let frame = &frames[motion.frame.0];
                points.push((frame.translation, frame.rotation * motion.axis));
            }
        }
        let flange = self.parent(self.frame_of_tool(tool)).unwrap_or(FrameId(0));
        let end = (frames[flange.0] * self.tools()[tool.0].placed.pose).translation;
        points.push((end, Vector3::zeros()));
        for _ in 0..SWEEPS {
            for k in 1..points.len() - 1 {
                let (at, axis) = points[k];
                // Feet and distances of both neighbours: on the way between their mirror images the axis is crossed in that proportion.
                let seen = [points[k - 1].0, points[k + 1].0].map(|other| {
                    let along = axis.dot(&(other - at));
                    (along, (other - at - axis * along).norm())
                });
                let [(a, near), (b, far)] = seen;
                let by = if near + far > 0.0 { (a * far + b * near) / (near + far) } else { 0.5 * (a + b) };
                points[k].0 += axis * by;
            }
        }
        points.windows(2).map(|pair| (pair[1].0 - pair[0].0).norm()).sum()
    }
}

#[cfg(test)]
mod tests {
    use crate::{Chain, Joint, JointKind, Placed, Placement, Pose, ToolId, samples};
    use nalgebra::Vector3;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn offsets_that_cancel_are_no_length() {
        let arm = |offset: f64, tilt: f64| {
            let rows = [
                (0.1273, 0.0, FRAC_PI_2),
                (offset, -0.612, tilt),
                (0.0, -0.5723, -tilt),
                (0.163941 - offset, 0.0, FRAC_PI_2),
                (0.1157, 0.0, -FRAC_PI_2),
                (0.0922, 0.0, 0.0),
            ];
            let joints = rows.iter().enumerate().map(|(k, &(d, a, alpha))| {
                let placement = Placement::Dh { theta: 0.0, d, a, alpha };
                Joint::new(format!("j{}", k + 1), JointKind::Revolute, placement)
            });
            Chain::new("arm", joints.collect()).unwrap()
        };
        let plain = samples::ur10().characteristic_length();
        assert!((arm(0.0, 0.0).characteristic_length() - plain).abs() < 1e-12);
        let pose = Pose { translation: Vector3::new(0.0, 0.0, 0.4), ..Pose::IDENTITY };
        let tool = Placed { pose, known: true };
        let longer = samples::ur10().with_tool(tool).unwrap().characteristic_length();
        assert!((longer - plain - 0.4).abs() < 1e-12, "the length is that of the chain with its tool");
        let shortest = arm(0.0, 0.0).shortest_way(ToolId(0));
        for offset in [300.0, -87.0] {
            let found = arm(offset, 0.0).characteristic_length();
            assert!((found - shortest).abs() < 1e-3, "{found} {shortest}");
            // Axes that are parallel but for the scatter of a factory.
            let found = arm(offset, 1e-3).characteristic_length();
            assert!(found > 0.5 * shortest && found < 2.0 * plain, "{found}");
        }
        assert!(shortest > 1.0 && shortest < plain, "{shortest} {plain}");
    }
}
