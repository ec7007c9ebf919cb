//! A joint that another joint drags along: wrists whose motors sit in the forearm, belts, parallelograms.
//!
//! ```text
//! δ_i = r q_d + atan2( ε sin(q_d − φ), 1 − ε cos(q_d − φ) )
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | q_d | the driving joint's variable | rad or m |
//! | r | `ratio` | rad or m of this joint for each unit of the driving one |
//! | ε, φ | `eccentricity`, `phase` | 1, rad: the wheel that drags is not centred |
//!
//! A slide that drags a turn does so linearly: its ε is ignored.
//! Source: Mooring, Roth and Driels, *Fundamentals of Manipulator Calibration*, section 2.7; the second term is that of
//! an eccentric wheel.

use truepose_kinematics::JointKind;

/// How much a driving joint drags along another one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// Place of the driving joint in the chain, from 0.
    pub driver: usize,
    /// Units of this joint for each unit of the driving one.
    pub ratio: f64,
    /// Eccentricity over radius of the wheel that drags.
    pub eccentricity: f64,
    /// Direction of the eccentricity, rad.
    pub phase: f64,
}

impl Coupling {
    /// The dragged joint's error, rad or m.
    pub fn error(&self, driver: JointKind, q_d: f64) -> f64 {
        let linear = self.ratio * q_d;
        if driver != JointKind::Revolute {
            return linear;
        }
        let x = q_d - self.phase;
        linear + (self.eccentricity * x.sin()).atan2(1.0 - self.eccentricity * x.cos())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_centred_wheel_couples_in_proportion() {
        let coupling = Coupling { driver: 2, ratio: 1e-3, eccentricity: 0.0, phase: 0.0 };
        assert!((coupling.error(JointKind::Revolute, 0.8) - 8e-4).abs() < 1e-18);
        let wobbling = Coupling { eccentricity: 1e-4, ..coupling };
        let extra = wobbling.error(JointKind::Revolute, 0.8) - 8e-4;
        assert!((extra - 1e-4 * 0.8f64.sin()).abs() < 1e-8);
        assert!((wobbling.error(JointKind::Prismatic, 0.8) - 8e-4).abs() < 1e-18);
    }
}
