//! A machine that warms up itself: heat goes from the motors to their housings and on to the castings.
//!
//! ```text
//! τ_1 dH/dt = P(t) − H          τ_2 dC/dt = H − C          H(0) = C(0) = 0
//! rise = f H + (1 − f) C
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | P | `power`: the rise that the motors would cause for ever | K, on or off |
//! | τ_1, τ_2 | `housing_s`, `casting_s` | s |
//! | f | `near`: how much of the body follows the housing | 1 |
//!
//! P is on for a part of each cycle (the robot works, then waits for an operator). Two time constants that lie within a
//! factor of ten are no single exponential. Integrated with the exact step of a piecewise constant P.
//! Source: ISO 230-3, annex B (two time constants of a spindle's warm-up).

use super::curve::SmoothCurve;
use crate::SimulateError;

/// How a machine warms up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WarmUp {
    /// Rise of temperature that the motors would reach, K.
    pub power: f64,
    /// Time constant of the housings, s.
    pub housing_s: f64,
    /// Time constant of the castings, s.
    pub casting_s: f64,
    /// Part of the body that follows the housings; the rest follows the castings.
    pub near: f64,
    /// Length of a cycle of work and waiting, s; infinite works without a pause.
    pub cycle_s: f64,
    /// Fraction of a cycle that is work.
    pub working: f64,
}

impl WarmUp {
    /// Rise of temperature over `duration` seconds from a cold start, K.
    ///
    /// # Errors
    /// When a time constant or the duration is not positive.
    pub fn rise(&self, duration: f64) -> Result<SmoothCurve, SimulateError> {
        for (what, value) in [
            ("a time constant", self.housing_s),
            ("a time constant", self.casting_s),
            ("a duration", duration),
        ] {
            if !value.is_finite() || value <= 0.0 {
                return Err(SimulateError::Size { what, value, need: "positive" });
            }
        }
        let steps = 600;
        let h = duration / f64::from(steps);
        let (mut housing, mut casting) = (0.0, 0.0);
        let mut values = vec![0.0];
        for k in 0..steps {
            let place = (f64::from(k) * h / self.cycle_s).fract();
            let power = if self.cycle_s.is_infinite() || place < self.working { self.power } else { 0.0 };
            (housing, casting) = self.step(h, power, housing, casting);
            values.push(self.near * housing + (1.0 - self.near) * casting);
        }
        SmoothCurve::through(0.0, h, values)
    }

    /// Exact over a step of constant power: H = P + (H₀ − P) e^(−t/τ₁), which feeds the casting.
    fn step(&self, h: f64, power: f64, housing: f64, casting: f64) -> (f64, f64) {
        let (a, b) = (self.housing_s, self.casting_s);
        let (fast, slow) = ((-h / a).exp(), (-h / b).exp());
        let excess = housing - power;
        // Of equal time constants the particular solution is t e^(−t/τ)/τ.
        let through = if (a - b).abs() < 1e-9 * a { h / b * slow } else { a / (a - b) * (fast - slow) };
        (power + excess * fast, power + (casting - power) * slow + excess * through)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn warm(near: f64) -> WarmUp {
        WarmUp {
            power: 10.0,
            housing_s: 600.0,
            casting_s: 3000.0,
            near,
            cycle_s: f64::INFINITY,
            working: 1.0,
        }
    }

    #[test]
    fn two_bodies_in_series_have_two_time_constants() {
        let rise = warm(0.0).rise(9000.0).expect("a curve");
        for t in [300.0, 1500.0, 6000.0] {
            // P (1 − (τ_2 e^(−t/τ_2) − τ_1 e^(−t/τ_1))/(τ_2 − τ_1)).
            let (fast, slow) = ((-t / 600.0f64).exp(), (-t / 3000.0f64).exp());
            let expected = 10.0 * (1.0 - (3000.0 * slow - 600.0 * fast) / 2400.0);
            assert!((rise.value(t) - expected).abs() < 1e-5, "{t}: {} {expected}", rise.value(t));
        }
        let near = warm(1.0).rise(9000.0).expect("a curve");
        assert!((near.value(600.0) - 10.0 * (1.0 - (-1f64).exp())).abs() < 1e-4);
    }

    #[test]
    fn a_pause_cools() {
        let cycle = WarmUp { cycle_s: 3000.0, working: 0.5, ..warm(1.0) };
        let rise = cycle.rise(6000.0).expect("a curve");
        assert!(rise.value(1500.0) > rise.value(2900.0) && rise.value(2900.0) > 0.0);
        assert!(WarmUp { casting_s: 0.0, ..cycle }.rise(100.0).is_err());
    }
}
