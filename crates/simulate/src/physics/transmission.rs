//! Transmission errors: periodic deviations of a joint from its commanded motion, once or many times per turn.
//!
//! ```text
//! eccentric    δ = atan2( ε sin(q − φ), 1 − ε cos(q − φ) )                 ε = eccentricity / radius
//! mesh         δ = A (1 + m cos(q − φ_m)) s(N q − φ),    s(x) = tanh(k (sin x + h sin² x)) / tanh k
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | q | the joint's variable | rad or m |
//! | ε | `ratio` | 1 |
//! | A, N | `amplitude`, `cycles` | rad or m, 1/turn (slides: turns of the screw a metre) |
//! | k, h | `sharpness`, `lean` | 1: flanks that are steeper than a sine, and two flanks that differ |
//! | m, φ_m | `runout`, `runout_phase` | 1, rad: the mesh swells once a turn of the wheel |
//!
//! An eccentric wheel or encoder disc of radius r whose centre lies e beside the axis reads the angle of
//! (r cos q − e cos φ, r sin q − e sin φ): exact geometry, with all its harmonics. The mesh is *not* a sine.
//! Source: Smith, *Gear Noise and Vibration*, chapter 2 (transmission error, runout side bands).

use crate::physics::curve::SmoothCurve;
use truepose_kinematics::JointKind;

/// An error of a joint that follows its own motion.
#[derive(Debug, Clone, PartialEq)]
pub enum TransmissionError {
    /// A wheel or encoder disc that is mounted beside the axis.
    Eccentric {
        /// Eccentricity over radius, 1.
        ratio: f64,
        /// Direction of the eccentricity, rad.
        phase: f64,
    },
    /// Teeth, a wave generator, or a screw that follow one another.
    Mesh {
        /// Size, rad or m.
        amplitude: f64,
        /// Periods a turn of the joint; of a slide, periods a metre.
        cycles: f64,
        /// rad.
        phase: f64,
        /// Steepness of the flanks; near zero it is a sine.
        sharpness: f64,
        /// How much the two flanks differ.
        lean: f64,
        /// Share by which the amplitude swells once a turn (turns only).
        runout: f64,
        /// rad.
        runout_phase: f64,
    },
    /// An encoder, a cable or a cam that errs smoothly over the travel; rad or m over the joint's value.
    Smooth(SmoothCurve),
}

impl TransmissionError {
    /// A mesh of a usual shape: flanks somewhat steeper than a sine's, ten per cent of runout.
    pub fn mesh(amplitude: f64, cycles: f64, phase: f64) -> Self {
        TransmissionError::Mesh {
            amplitude,
            cycles,
            phase,
            sharpness: 0.8,
            lean: 0.08,
            runout: 0.1,
            runout_phase: 0.5 * phase,
        }
    }

    /// The joint's error at this value of its variable, rad or m.
    pub fn error(&self, kind: JointKind, q: f64) -> f64 {
        match *self {
            TransmissionError::Smooth(ref curve) => curve.value(q),
            TransmissionError::Eccentric { ratio, phase } => {
                let x = q - phase;
                (ratio * x.sin()).atan2(1.0 - ratio * x.cos())
            }
            TransmissionError::Mesh { amplitude, cycles, phase, sharpness, lean, runout, runout_phase } => {
                let turn = kind == JointKind::Revolute;
                let x = cycles * q * if turn { 1.0 } else { std::f64::consts::TAU } - phase;
                let swell = if turn { 1.0 + runout * (q - runout_phase).cos() } else { 1.0 };
                let k = sharpness.max(1e-6);
                let wave = x.sin() + lean * x.sin().powi(2);
                amplitude * swell * (k * wave).tanh() / k.tanh()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, TAU};

    #[test]
    fn an_eccentric_disc_reads_the_angle_of_its_own_centre() {
        let gear = TransmissionError::Eccentric { ratio: 0.02, phase: 0.4 };
        for k in 0..12 {
            let q = 0.5 * f64::from(k) - 3.0;
            let (x, y) = (q.cos() - 0.02 * 0.4f64.cos(), q.sin() - 0.02 * 0.4f64.sin());
            let expected = (y.atan2(x) - q + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
            assert!((gear.error(JointKind::Revolute, q) - expected).abs() < 1e-14);
        }
        // Largest where sin δ = ε.
        let widest =
            (0..6283).map(|k| gear.error(JointKind::Revolute, 1e-3 * f64::from(k))).fold(0.0, f64::max);
        assert!((widest - 0.02f64.asin()).abs() < 1e-8);
    }

    #[test]
    fn a_mesh_repeats_and_is_no_sine() {
        let gear = TransmissionError::mesh(1e-4, 100.0, 0.3);
        let plain = TransmissionError::Mesh {
            amplitude: 1e-4,
            cycles: 100.0,
            phase: 0.3,
            sharpness: 0.0,
            lean: 0.0,
            runout: 0.0,
            runout_phase: 0.0,
        };
        let at = |gear: &TransmissionError, q| gear.error(JointKind::Revolute, q);
        assert!((at(&gear, 0.7) - at(&gear, 0.7 + TAU)).abs() < 1e-15);
        assert!((at(&plain, 0.7) - 1e-4 * (70.0 - 0.3f64).sin()).abs() < 1e-12);
        // The part of the mesh that its own sine and cosine do not explain.
        let samples: Vec<f64> = (0..1000).map(|k| TAU * f64::from(k) / 1000.0 / 100.0).collect();
        let flat = TransmissionError::Mesh {
            runout: 0.0,
            amplitude: 1e-4,
            cycles: 100.0,
            phase: 0.0,
            sharpness: 0.8,
            lean: 0.08,
            runout_phase: 0.0,
        };
        let part = |wave: fn(f64) -> f64| {
            samples.iter().map(|&q| at(&flat, q) * wave(100.0 * q)).sum::<f64>() / 500.0
        };
        let all = samples.iter().map(|&q| at(&flat, q).powi(2)).sum::<f64>() / 1000.0;
        let first = (part(f64::sin).powi(2) + part(f64::cos).powi(2)) / 2.0;
        assert!((0.002..0.02).contains(&(1.0 - first / all)), "{}", 1.0 - first / all);
    }

    #[test]
    fn a_lead_screw_error_repeats_with_each_lead() {
        let screw = TransmissionError::mesh(5e-6, 100.0, 0.0);
        let at = |q| screw.error(JointKind::Prismatic, q);
        assert!((at(0.1234) - at(0.1334)).abs() < 1e-17);
        assert!((at(0.0025) - at(0.0075 - 0.0)).abs() > 5e-6);
        assert!(at(FRAC_PI_2).is_finite());
    }
}
