//! A joint that heats itself: friction and load heat the motor, the motor heats the gear.
//!
//! ```text
//! P = (f + |τ|) |Δq| / h         τ_1 dM/dt = P − M         τ_2 dG/dt = M − G         δ = a (s M + (1 − s) G)
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | f | `friction`: torque or force that does not follow the load | N·m or N |
//! | M, G | rise of motor and gear, in units of power | W |
//! | τ_1, τ_2 | `motor_s`, `gear_s` | s |
//! | s | `near`: part that follows the motor | 1 |
//! | a | `rate` | rad/W or m/W |
//!
//! Between poses the power is constant; a twentieth of the shorter time constant is one step of Euler's rule. Source: ISO 230-3, annex B.

/// A joint that heats itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heating {
    /// N·m or N.
    pub friction: f64,
    /// s.
    pub motor_s: f64,
    /// s.
    pub gear_s: f64,
    /// Part that follows the motor.
    pub near: f64,
    /// rad/W or m/W.
    pub rate: f64,
    /// Whether the load adds to the friction.
    pub by_load: bool,
}

impl Heating {
    /// The error at each pose, rad or m, of poses at these times (s), joint values and loads; cold at the first.
    pub fn errors(&self, times: &[f64], joint: &[f64], loads: &[f64]) -> Vec<f64> {
        let (mut motor, mut gear) = (0.0, 0.0);
        let mut errors = vec![0.0];
        for k in 1..times.len() {
            let h = times[k] - times[k - 1];
            let load = if self.by_load { 0.5 * (loads[k].abs() + loads[k - 1].abs()) } else { 0.0 };
            let power = (self.friction + load) * (joint[k] - joint[k - 1]).abs() / h;
            let count = (20.0 * h / self.motor_s.min(self.gear_s)).ceil().max(1.0);
            let step = h / count;
            for _ in 0..count as usize {
                let before = motor;
                motor += step * (power - motor) / self.motor_s;
                gear += step * (0.5 * (before + motor) - gear) / self.gear_s;
            }
            errors.push(self.rate * (self.near * motor + (1.0 - self.near) * gear));
        }
        errors
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steady_work_heats_to_its_power() {
        let heating =
            Heating { friction: 5.0, motor_s: 300.0, gear_s: 900.0, near: 0.4, rate: 1e-5, by_load: true };
        let times: Vec<f64> = (0..300).map(|k| 60.0 * f64::from(k)).collect();
        let joint: Vec<f64> = (0..300).map(|k| if k % 2 == 0 { 0.0 } else { 1.2 }).collect();
        let errors = heating.errors(&times, &joint, &vec![10.0; 300]);
        // 15 N·m times 1.2 rad a minute: 0.3 W.
        assert!((errors[299] - 0.3e-5).abs() < 1e-8, "{}", errors[299]);
        assert!(errors[0] == 0.0 && errors[5] < errors[50]);
        let cold = Heating { by_load: false, ..heating }.errors(&times, &joint, &vec![10.0; 300]);
        assert!((cold[299] / errors[299] - 1.0 / 3.0).abs() < 1e-9);
    }
}
