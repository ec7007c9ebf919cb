//! Transmission error of a strain wave gear with a planetary stage in front: periods that do not divide a turn, and an
//! amplitude that grows with the load.
//!
//! ```text
//! δ(q, τ) = (1 + b a/(1 + a)) Σ_k A_k w(ν_k q − φ_k),     a = |τ|/τ_0,     w(x) = asin(κ sin x)/asin κ
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | A_k, ν_k, φ_k | `waves`: amplitude, periods a turn (any number; slides: a metre), phase | rad or m, 1/turn, rad |
//! | κ | `edge`: 0 a sine, 1 a triangle | 1 |
//! | b, τ_0 | `by_load`, `load` | 1, N·m or N |
//!
//! Two stages of 11 and 101 teeth beat with 101/11 periods a turn: no harmonic of one period of the joint. Under load more
//! teeth deflect, so that the amplitude rises and then stays. Source: Tuttle, *Understanding and modeling the behavior of a
//! harmonic drive gear transmission* (1992), section 3.3 (kinematic error, its change with load).

use truepose_kinematics::JointKind;

/// One wave of the error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// rad or m.
    pub amplitude: f64,
    /// Periods a turn of the joint; of a slide, periods a metre. Any number.
    pub cycles: f64,
    /// rad.
    pub phase: f64,
}

/// A transmission error whose amplitude follows the load.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedWaves {
    /// The waves.
    pub waves: Vec<Wave>,
    /// Shape of a wave: near 0 a sine, 1 a triangle.
    pub edge: f64,
    /// Growth of the amplitude under a large load, as a fraction.
    pub by_load: f64,
    /// Load at which half of the growth is reached, N·m or N.
    pub load: f64,
}

impl LoadedWaves {
    /// The joint's error at this value of its variable and this load about or along its axis, rad or m.
    pub fn error(&self, kind: JointKind, q: f64, load: f64) -> f64 {
        let turn = if kind == JointKind::Revolute { 1.0 } else { std::f64::consts::TAU };
        let edge = self.edge.clamp(1e-6, 1.0);
        let wave = |wave: &Wave| {
            let x = wave.cycles * turn * q - wave.phase;
            wave.amplitude * (edge * x.sin()).asin() / edge.asin()
        };
        let ratio = load.abs() / self.load;
        let growth = 1.0 + self.by_load * ratio / (1.0 + ratio);
        growth * self.waves.iter().map(wave).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    fn waves(edge: f64) -> LoadedWaves {
        let wave = Wave { amplitude: 1e-4, cycles: 101.0 / 11.0, phase: 0.3 };
        LoadedWaves { waves: vec![wave], edge, by_load: 0.8, load: 40.0 }
    }

    #[test]
    fn its_period_divides_no_turn() {
        let at = |q: f64| waves(0.9).error(JointKind::Revolute, q, 0.0);
        assert!((at(0.4) - at(0.4 + TAU * 11.0 / 101.0)).abs() < 1e-16);
        assert!((at(0.4) - at(0.4 + TAU)).abs() > 1e-5);
    }

    #[test]
    fn the_amplitude_grows_with_the_load_and_then_stays() {
        let at = |load: f64| waves(0.9).error(JointKind::Revolute, 0.2, load);
        assert!((at(40.0) / at(0.0) - 1.4).abs() < 1e-12);
        assert!((at(-40.0) / at(40.0) - 1.0).abs() < 1e-12);
        assert!((at(4e7) / at(0.0) - 1.8).abs() < 1e-5);
    }

    #[test]
    fn its_shape_goes_from_a_sine_to_a_triangle() {
        let at = |edge: f64, x: f64| {
            let one = Wave { amplitude: 1.0, cycles: 1.0, phase: 0.0 };
            let waves = LoadedWaves { waves: vec![one], edge, by_load: 0.0, load: 1.0 };
            waves.error(JointKind::Revolute, x, 5.0)
        };
        assert!((at(0.0, 0.7) - 0.7f64.sin()).abs() < 1e-9);
        assert!((at(1.0, PI / 4.0) - 0.5).abs() < 1e-12);
        assert!((at(0.7, PI / 2.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_slide_counts_periods_a_metre() {
        let one = Wave { amplitude: 1e-5, cycles: 100.0, phase: 0.0 };
        let waves = LoadedWaves { waves: vec![one], edge: 0.5, by_load: 0.0, load: 1.0 };
        let at = |q: f64| waves.error(JointKind::Prismatic, q, 0.0);
        assert!((at(0.1234) - at(0.1334)).abs() < 1e-17);
    }
}
