//! A gas spring that balances a joint, and is not in the robot's description.
//!
//! ```text
//! F = F_0 (V/(V − A (l_max − l)))^n          τ = −F dl/dq,          l² = a² + b² + 2 a b cos(q − φ)
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | F_0 | `force` where it is longest, pushing | N |
//! | a, b, φ | `levers`, `offset` | m, rad |
//! | V/A, n | `column` of gas, `exponent` of its compression | m, 1 |
//!
//! Source: Stabilus, *Gas springs: technical information* (progression of the force by polytropic compression).

/// A gas spring over a crank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GasSpring {
    /// N.
    pub force: f64,
    /// m.
    pub levers: [f64; 2],
    /// rad.
    pub offset: f64,
    /// m.
    pub column: f64,
    /// 1.
    pub exponent: f64,
}

impl GasSpring {
    /// Torque about the joint at this value, N·m.
    pub fn torque(&self, q: f64) -> f64 {
        let [a, b] = self.levers;
        let x = q - self.offset;
        let length = (a * a + b * b + 2.0 * a * b * x.cos()).sqrt();
        let stroke = a + b - length;
        let force = self.force * (self.column / (self.column - stroke)).powf(self.exponent);
        // dl/dq = −a b sin x / l; a spring that pushes turns towards the longer length.
        -force * a * b * x.sin() / length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_turns_to_where_it_is_longest_and_pushes_more_when_it_is_short() {
        let spring = GasSpring { force: 1000.0, levers: [0.5, 0.2], offset: 0.3, column: 1.5, exponent: 1.2 };
        assert!(spring.torque(0.3).abs() < 1e-12);
        assert!(spring.torque(0.8) < 0.0 && spring.torque(-0.2) > 0.0);
        // Half way round: 1000 N · (1.5/(1.5 − 0.7 + √0.29))^1.2 over the lever 0.1/√0.29.
        let length = 0.29f64.sqrt();
        let expected = -1000.0 * (1.5 / (1.5 - 0.7 + length)).powf(1.2) * 0.1 / length;
        assert!((spring.torque(0.3 + std::f64::consts::FRAC_PI_2) - expected).abs() < 1e-9);
    }
}
