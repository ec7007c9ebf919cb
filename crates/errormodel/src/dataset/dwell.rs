//! Which rows one dwell of the robot measured, and which pose measurements are of one configuration.
//!
//! Encoders flicker: the joint values of one dwell, and of two visits to one commanded configuration, differ in their last digits. Rows and
//! configurations are matched within a tolerance, always against the *first* of their group, so that a slow sweep of small steps does not
//! become one pose.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | δ | tolerance of a joint's value in one dwell, [`DwellTolerance`] | rad, m |
//! | Δ | tolerance of a joint's value in one configuration, 10 δ | rad, m |
//! | L | characteristic length of the robot | m |
//! | ℓ | how far the position of one target may be from its first one in the dwell | m |
//!
//! ```text
//! same configuration     |q_k − q_k,first| ≤ Δ  of every joint, and the same load
//! same dwell             |q_k − q_k,first| ≤ δ  of every joint, the same load, and |p − p_first| ≤ ℓ of the same target
//! ```
//!
//! δ = 1e-5 (2 seconds of arc) moves a point at a lever of one metre by 10 µm: below the repeatability of any arm of that reach (ISO 9283; 20 to
//! 100 µm), and below the uncertainty of a laser tracker (15 µm + 6 µm/m), and yet several times the 1e-4° by which joints at rest flicker.
//! The tolerance of a slide is in proportion to L where L is beyond the lengths of usual machines ([`USUAL`]): a robot a thousand times as
//! small slides in steps of a thousandth, and ten micrometres are another pose of it.
//! Δ = 1e-4 (0.1 mm) is what a robot that was sent to the same place again reports. Within it no error that is looked for changes: the
//! shortest period of a joint has 256 cycles a turn, and over Δ it turns by 2π · 256 Δ/2π = 0.026 rad of its phase. What the robot as
//! described moves by within Δ is known and is in no residual, so that such pose measurements are repeats of each other; folds may not
//! part them.
//! ℓ is ten standard deviations as the instrument states them, but no less than 1e-4 L and no more than 1e-3 L, which is what the
//! coarsest instrument that arms are calibrated with scatters by; on top of it comes what δ moves.

use truepose_kinematics::{Chain, JointKind};

/// How far the joint values of one dwell may differ; those of one configuration may by ten times as much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DwellTolerance {
    /// Of turning joints, rad.
    pub angle: f64,
    /// Of slides, m; `None`: that of a robot of this size, 10 µm of usual ones.
    pub length: Option<f64>,
}

impl DwellTolerance {
    /// How far joint values of two visits to one configuration may differ, given how far those of one dwell may.
    #[must_use]
    pub fn of_repeats(dwell: f64) -> f64 {
        REPEATED * dwell
    }

    /// Of turning joints, rad, and of the slides of this robot, m.
    pub fn on(self, chain: &Chain) -> [f64; 2] {
        let length = chain.characteristic_length();
        [self.angle, self.length.unwrap_or(DEFAULT * length / length.clamp(USUAL[0], USUAL[1]))]
    }
}

impl Default for DwellTolerance {
    /// 1e-5 rad, and 10 µm of a robot of usual size.
    fn default() -> Self {
        DwellTolerance { angle: DEFAULT, length: None }
    }
}

/// Rad, and m of a robot of usual size.
const DEFAULT: f64 = 1e-5;
/// Characteristic lengths of robots whose slides have the default tolerance as it stands, m: where 1e-5 rad move the tool by as much, and
/// a gantry in a hall.
const USUAL: [f64; 2] = [1.0, 30.0];
/// Tolerance of a configuration, in tolerances of a dwell.
const REPEATED: f64 = 10.0;

/// What tells the dwells and configurations of a data set apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Dwell {
    /// δ of each movable joint, rad or m; 1e-5 of the joints that it has no number for.
    pub joints: Vec<f64>,
    /// Least and largest ℓ, m.
    pub position: [f64; 2],
}

impl Default for Dwell {
    /// The default tolerance, and positions that part nothing.
    fn default() -> Self {
        Dwell { joints: Vec::new(), position: [f64::INFINITY; 2] }
    }
}

impl Dwell {
    /// Of a robot.
    pub fn of(chain: &Chain, tolerance: DwellTolerance) -> Self {
        let length = chain.characteristic_length();
        let slides = |k: usize| chain.joint(chain.movable()[k]).kind == JointKind::Prismatic;
        let [turning, sliding] = tolerance.on(chain);
        let joints: Vec<f64> =
            (0..chain.movable().len()).map(|k| if slides(k) { sliding } else { turning }).collect();
        let moved: f64 =
            joints.iter().enumerate().map(|(k, delta)| if slides(k) { *delta } else { delta * length }).sum();
        Dwell { joints, position: [1e-4, 1e-3].map(|share| share * length + moved) }
    }

    /// δ of a movable joint, rad or m.
    pub fn tolerance(&self, joint: usize) -> f64 {
        self.joints.get(joint).copied().unwrap_or(DEFAULT)
    }

    /// Δ of a movable joint, rad or m.
    pub fn repeat_tolerance(&self, joint: usize) -> f64 {
        DwellTolerance::of_repeats(self.tolerance(joint))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::{Joint, Placement, samples};

    /// All lengths of a robot of origins times a factor.
    fn scaled(chain: &Chain, factor: f64) -> Chain {
        let joint = |joint: &Joint| {
            let mut joint = joint.clone();
            if let Placement::Origin { pose, .. } = &mut joint.placement {
                pose.translation *= factor;
            }
            if joint.kind == JointKind::Prismatic {
                joint.limits = joint.limits.map(|(lower, upper)| (factor * lower, factor * upper));
            }
            joint
        };
        Chain::new(chain.name().to_owned(), chain.joints().iter().map(joint).collect())
            .expect("the same joints")
    }

    #[test]
    fn a_robot_a_thousand_times_as_small_has_finer_slides() {
        let chain = samples::pps();
        let of = |factor: f64, tolerance| Dwell::of(&scaled(&chain, factor), tolerance);
        let slide = (0..6).find(|&k| chain.joint(chain.movable()[k]).kind == JointKind::Prismatic);
        let slide = slide.expect("three of them");
        let usual = of(1.0, DwellTolerance::default());
        assert!((usual.tolerance(slide) - 1e-5).abs() < 1e-18);
        // In proportion to the robot, and what is asked for as it is.
        let [small, smaller, large, larger] =
            [1e-3, 1e-4, 1e3, 1e4].map(|factor| of(factor, DwellTolerance::default()).tolerance(slide));
        assert!((smaller / small - 0.1).abs() < 1e-9 && small < 1e-6, "{small} {smaller}");
        assert!((larger / large - 10.0).abs() < 1e-9 && large > 1e-4, "{large} {larger}");
        let asked = DwellTolerance { length: Some(2e-6), ..DwellTolerance::default() };
        assert!((of(1e-3, asked).tolerance(slide) - 2e-6).abs() < 1e-18);
    }
}
