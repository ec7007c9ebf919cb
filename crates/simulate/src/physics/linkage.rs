//! A parallelogram that drives a joint past another one: crank, rod and rocker that are not as long as drawn.
//!
//! ```text
//! | arm + rocker e^(iβ) − crank e^(iα) | = rod,       α = α_0 + q_joint ± q_driver         δ = β − α
//! ```
//!
//! Lengths are in units of the rocker, which is as drawn; the arm is along the real axis. Solved by Newton's rule from β = α, the branch of the
//! parallelogram. Source: Hartenberg and Denavit, *Kinematic Synthesis of Linkages*, chapter 10 (loop closure).

/// A four-bar linkage that is nearly a parallelogram.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FourBar {
    /// Place of the driving joint in the chain, from 0.
    pub driver: usize,
    /// +1 or −1: how its value enters the angle.
    pub sign: f64,
    /// Angle between crank and arm where both joints are zero, rad.
    pub offset: f64,
    /// Length of the arm over that of the rocker.
    pub arm: f64,
    /// Crank less rocker, rod less arm; over the rocker.
    pub longer: [f64; 2],
}

impl FourBar {
    /// The driven joint's error at these values of both, rad.
    pub fn error(&self, joint: f64, driver: f64) -> f64 {
        let alpha = self.offset + joint + self.sign * driver;
        let (crank, rod) = (1.0 + self.longer[0], self.arm + self.longer[1]);
        let mut beta = alpha;
        for _ in 0..30 {
            let (x, y) = (self.arm + beta.cos() - crank * alpha.cos(), beta.sin() - crank * alpha.sin());
            let gap = x.hypot(y) - rod;
            let slope = (-x * beta.sin() + y * beta.cos()) / x.hypot(y);
            if slope.abs() < 1e-3 {
                break;
            }
            beta -= gap / slope;
        }
        beta - alpha
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loop_closes_and_a_parallelogram_has_no_error() {
        let exact = FourBar { driver: 1, sign: -1.0, offset: 1.5, arm: 3.0, longer: [0.0; 2] };
        assert!(exact.error(0.4, 0.1).abs() < 1e-12);
        let off = FourBar { longer: [2e-3, -1e-3], ..exact };
        for (joint, driver) in [(0.4, 0.1), (-0.5, 0.2), (0.1, -0.6)] {
            let alpha = 1.5 + joint - driver;
            let beta = alpha + off.error(joint, driver);
            let rod = (3.0 + beta.cos() - 1.002 * alpha.cos()).hypot(beta.sin() - 1.002 * alpha.sin());
            assert!((rod - 2.999).abs() < 1e-12, "{rod}");
        }
    }
}
