//! A log of joint values that is filtered, and read some time after the robot has stopped.
//!
//! ```text
//! q̂(t) = ∫ q(t − s) e^(−s/τ)/τ ds          read at t = T + w,     q(t) a move of duration T from the last pose
//! T = T_0 + max_j |Δ_j|/v                   all joints start and stop together
//! q(t) = q_0 + Δ (t/T − sin(2πt/T)/2π)      0 ≤ t ≤ T
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | τ | `time_constant`: of the filter | s |
//! | w | `wait`: from the end of the move until the value is read | s |
//! | T_0, v | `least`, `speed` | s; rad/s or m/s |
//!
//! What is missing at the end, `Δ e^(−w/τ) (τ/T) φ(τ/T)`, depends on the duration of the move, which the longest move of all joints
//! determines: it is no fixed fraction of the last move. Source: Biagiotti and Melchiorri, *Trajectory Planning for Automatic Machines and
//! Robots* (2008), cycloidal motion.

use std::f64::consts::TAU;

/// A filtered log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogLag {
    /// Time constant of the filter, s.
    pub time_constant: f64,
    /// From the end of the move until the value is read, s.
    pub wait: f64,
    /// Shortest duration of a move, s.
    pub least: f64,
    /// Speed beyond it, rad/s or m/s.
    pub speed: f64,
}

impl LogLag {
    /// Recorded over true joints, which came from `before` to `here` all together, rad or m.
    pub(crate) fn recorded(&self, before: &[f64], here: &[f64]) -> Vec<f64> {
        let moves = before.iter().zip(here).map(|(before, here)| here - before);
        let longest = moves.clone().map(f64::abs).fold(0.0, f64::max);
        let duration = self.least + longest / self.speed;
        // The speed is (Δ/T)(1 − cos ωt); what lags at T is ∫ speed e^(−(T−t)/τ) dt.
        let (rate, omega) = (1.0 / self.time_constant, TAU / duration);
        let past = 1.0 - (-rate * duration).exp();
        let missing = past / duration * (1.0 / rate - rate / (rate * rate + omega * omega));
        let part = missing * (-rate * self.wait).exp();
        here.iter().zip(moves).map(|(here, step)| here - part * step).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_filter_of_the_move() {
        let log = LogLag { time_constant: 0.2, wait: 0.1, least: 0.5, speed: 2.0 };
        let (before, here) = ([0.1, -0.4], [0.9, -0.5]);
        let duration = 0.5 + 0.8 / 2.0;
        let found = log.recorded(&before, &here);
        for k in 0..2 {
            // The differential equation in small steps.
            let (mut filtered, count) = (before[k], 200_000);
            let step = (duration + 0.1) / f64::from(count);
            for n in 0..count {
                let t = ((f64::from(n) + 0.5) * step).min(duration) / duration;
                let q = before[k] + (here[k] - before[k]) * (t - (TAU * t).sin() / TAU);
                filtered += step * (q - filtered) / 0.2;
            }
            assert!((found[k] - filtered).abs() < 1e-5, "{k}: {} {filtered}", found[k]);
        }
    }
}
