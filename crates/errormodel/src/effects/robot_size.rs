//! Sizes in metres and per newton metre, for a robot of any size.
//!
//! Expected sizes of slides, guideways, play and stiffness are those of machines that people build and stand beside. A robot in another
//! unit of length, or one that is a thousand times as small, has the same errors in proportion: lengths grow with the robot, and torques of
//! the same weights as well, so that a compliance per torque shrinks with it.

use truepose_kinematics::Chain;

/// Characteristic lengths of machines for which sizes are taken as they stand, m: a desktop arm, and a gantry in a hall.
const USUAL: [f64; 2] = [0.1, 30.0];

/// How much larger the robot is than a usual one: 1 for those of [`USUAL`], in proportion to its length beyond.
pub(super) fn robot_size(chain: &Chain) -> f64 {
    let length = chain.characteristic_length();
    length / length.clamp(USUAL[0], USUAL[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{
        Backlash, BaseCompliance, Coupling, Geometric, Guideway, JointCompliance, LinkCompliance,
        LoadNonlinearity, OwnWeight, Polynomial, Side, Spot, Thermal, Transmission,
    };
    use crate::{Column, Effect};
    use truepose_kinematics::{Joint, JointId, JointKind, Placement, samples};

    /// All lengths of a robot times a factor.
    fn scaled(chain: &Chain, factor: f64) -> Chain {
        let joint = |joint: &Joint| {
            let mut joint = joint.clone();
            match &mut joint.placement {
                Placement::Dh { d, a, .. } | Placement::Mdh { d, a, .. } => {
                    (*d, *a) = (*d * factor, *a * factor)
                }
                Placement::Origin { pose, .. } => pose.translation *= factor,
            }
            if joint.kind == JointKind::Prismatic {
                joint.limits = joint.limits.map(|(lower, upper)| (lower * factor, upper * factor));
            }
            joint
        };
        Chain::new(chain.name().to_owned(), chain.joints().iter().map(joint).collect()).unwrap()
    }

    #[test]
    fn usual_robots_have_the_sizes_as_they_stand() {
        for chain in samples::all() {
            assert!((robot_size(&chain) - 1.0).abs() < 1e-12, "{} is of no usual size", chain.name());
        }
        let (small, large) = (scaled(&samples::ur10(), 1e-3), scaled(&samples::ur10(), 1e3));
        assert!((robot_size(&large) / robot_size(&small)).log10() > 3.0);
    }

    /// Power of a length in a unit as columns write it: 1 for m/N, −2 for kg/(N*m^2).
    fn lengths(unit: &str) -> i32 {
        let unit = unit.trim();
        let mut depth = 0;
        let cut = |by: char, depth: &mut i32| {
            unit.char_indices().rev().find_map(|(at, c)| {
                *depth += i32::from(c == ')') - i32::from(c == '(');
                (*depth == 0 && c == by).then_some(at)
            })
        };
        if let Some(at) = cut('/', &mut depth) {
            return lengths(&unit[..at]) - lengths(&unit[at + 1..]);
        }
        if let Some(at) = cut('*', &mut depth) {
            return lengths(&unit[..at]) + lengths(&unit[at + 1..]);
        }
        if let Some(at) = cut('^', &mut depth) {
            return lengths(&unit[..at]) * unit[at + 1..].parse::<i32>().unwrap();
        }
        match unit.strip_prefix('(').and_then(|unit| unit.strip_suffix(')')) {
            Some(inside) => lengths(inside),
            None => i32::from(unit == "m"),
        }
    }

    #[test]
    fn powers_of_lengths_are_read() {
        for (unit, power) in
            [("m/N", 1), ("rad/(N*m)", -1), ("kg/(N*m^2)", -2), ("rad/(N*m)^3", -3), ("rad*kg*m/(N*m)", 0)]
        {
            assert_eq!(lengths(unit), power, "{unit}");
        }
    }

    /// Every effect but those of the instrument, which does not grow with the robot that it measures.
    fn effects(chain: &Chain, joint: JointId) -> Vec<Vec<Column>> {
        let slides = chain.joint(joint).kind == JointKind::Prismatic;
        let travel = chain.joint(joint).limits.map_or([-1.0, 1.0], |(lower, upper)| [lower, upper]);
        let other = chain.movable().iter().copied().find(|&other| other != joint).unwrap();
        let free = JointCompliance { own_weight: OwnWeight::Free, ..JointCompliance::of(joint) };
        let mut all = vec![
            Geometric::default().columns(chain),
            Polynomial::of(1, vec![]).columns(chain),
            free.columns(chain),
            JointCompliance::bearing(joint).columns(chain),
            JointCompliance::creep(joint, 600.0).columns(chain),
            JointCompliance::by_temperature(joint, "t", 20.0).columns(chain),
            BaseCompliance::default().columns(chain),
            LinkCompliance { own_weight: OwnWeight::Free, ..LinkCompliance::of(other) }.columns(chain),
            LoadNonlinearity::with_powers(joint, vec![2, 3]).columns(chain),
            LoadNonlinearity::soft(joint, 30.0).columns(chain),
            Backlash::of(joint, Side::Approach).columns(chain),
            Backlash::of(joint, Side::ByLoad).columns(chain),
            Coupling::of(joint, other).columns(chain),
            Transmission { by_load: true, ..Transmission::of(joint, 0.5) }.columns(chain),
            Transmission::gain(joint).columns(chain),
            Transmission::curve(joint, travel, 3).columns(chain),
            Thermal::of(Spot::Joint(joint), "t").columns(chain),
            Thermal::arm("t").columns(chain),
        ];
        if slides {
            all.push(JointCompliance::measured(joint, "t").columns(chain));
            all.push(Guideway { screw: Some(0.1), ..Guideway::of(joint) }.columns(chain));
            all.push(Guideway { by_load: true, ..Guideway::of(joint) }.columns(chain));
            all.push(LinkCompliance::ram(joint, 1.0, false).columns(chain));
        }
        all
    }

    #[test]
    fn no_expected_size_carries_metres() {
        for chain in [samples::ur10(), samples::pps(), samples::scara()] {
            for &joint in chain.movable() {
                for (from, to) in [(1e3, 1e4), (1e-4, 1e-3)] {
                    let [small, large] = [from, to].map(|factor| effects(&scaled(&chain, factor), joint));
                    for (small, large) in small.iter().flatten().zip(large.iter().flatten()) {
                        let (name, unit) = (&small.name, &small.unit);
                        let expected = 10f64.powi(lengths(unit));
                        let grows = large.scale / small.scale;
                        assert!(
                            (grows / expected - 1.0).abs() < 1e-9,
                            "{name} [{unit}]: {grows}, not {expected}"
                        );
                    }
                }
            }
        }
    }
}
