//! Functions of one variable u.
//!
//! | basis | functions | source |
//! | --- | --- | --- |
//! | powers | `u^a` | Eq. (17) |
//! | fourier | `sin(2π h u / P)`, `cos(2π h u / P)` | |
//! | chebyshev | `T_d(x)`, x = u mapped from [lower, upper] to [−1, 1], clamped | Rivlin 1974 |
//! | spline | uniform B-splines of a degree on [lower, upper], clamped | de Boor 1978 |

use crate::MOST_UNKNOWNS;
use crate::lanes::LANES;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A family of functions of one variable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Basis {
    /// These powers.
    Powers(Vec<u32>),
    /// Sine and cosine of these harmonics of a period.
    Fourier {
        /// In the unit of the variable.
        period: f64,
        /// 1 is the period itself.
        harmonics: Vec<u32>,
    },
    /// Chebyshev polynomials of these degrees on a range.
    Chebyshev {
        /// Lower end.
        lower: f64,
        /// Upper end.
        upper: f64,
        /// 0 is the constant.
        degrees: Vec<u32>,
    },
    /// Uniform B-splines: `pieces + degree` functions that sum to one on the range.
    Spline {
        /// Lower end.
        lower: f64,
        /// Upper end.
        upper: f64,
        /// Equal pieces into which the range is cut.
        pieces: usize,
        /// 1 linear, 2 quadratic, 3 cubic.
        degree: usize,
    },
}

/// Highest degree of a spline.
const MAX_DEGREE: usize = 5;

impl Basis {
    /// How many functions.
    pub fn len(&self) -> usize {
        match self {
            Basis::Powers(list) => list.len(),
            Basis::Fourier { harmonics, .. } => 2 * harmonics.len(),
            Basis::Chebyshev { degrees, .. } => degrees.len(),
            Basis::Spline { pieces, degree, .. } => pieces.saturating_add(*degree),
        }
    }

    /// True without any function.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Calls `each(index, value)` for every function that is not zero at u.
    pub fn for_each(&self, u: f64, mut each: impl FnMut(usize, f64)) {
        match self {
            Basis::Powers(list) => {
                list.iter().enumerate().for_each(|(k, &power)| each(k, u.powi(power as i32)));
            }
            Basis::Fourier { period, harmonics } => {
                for (k, &harmonic) in harmonics.iter().enumerate() {
                    let (s, c) = (TAU * f64::from(harmonic) * u / period).sin_cos();
                    each(2 * k, s);
                    each(2 * k + 1, c);
                }
            }
            Basis::Chebyshev { lower, upper, degrees } => {
                for (k, &degree) in degrees.iter().enumerate() {
                    each(k, Basis::chebyshev(degree, u, [*lower, *upper]));
                }
            }
            Basis::Spline { lower, upper, pieces, degree } => {
                let x = ((u - lower) / (upper - lower)).clamp(0.0, 1.0) * *pieces as f64;
                let cell = (x.floor() as usize).min(pieces - 1);
                let values = uniform_spline(x - cell as f64, *degree);
                for (k, &value) in values.iter().take(degree + 1).enumerate() {
                    each(cell + k, value);
                }
            }
        }
    }

    /// All functions at many values, `LANES` numbers a function, of which the first ones count; into zeros.
    pub(in crate::effects) fn of_block(&self, u: &[f64], into: &mut [f64]) {
        match self {
            Basis::Powers(list) => {
                for (&power, into) in list.iter().zip(into.chunks_exact_mut(LANES)) {
                    raise(&mut into[..u.len()], u, power);
                }
            }
            _ => {
                for (lane, &u) in u.iter().enumerate() {
                    self.for_each(u, |index, value| into[index * LANES + lane] = value);
                }
            }
        }
    }

    /// Calls `each(index − 1, f(u) − f(reference))` for all functions but the first, in parts that have to be summed: of
    /// splines, which sum to one, this is everything but the constant, and it is zero at the reference.
    pub(in crate::effects) fn for_each_from(&self, reference: f64, u: f64, mut each: impl FnMut(usize, f64)) {
        for (at, sign) in [(u, 1.0), (reference, -1.0)] {
            self.for_each(at, |index, value| {
                if index > 0 && value != 0.0 {
                    each(index - 1, sign * value);
                }
            });
        }
    }

    /// `T_d(x)`, x = u mapped from a range to [−1, 1], clamped.
    pub(in crate::effects) fn chebyshev(degree: u32, u: f64, [lower, upper]: [f64; 2]) -> f64 {
        let x = (2.0 * (u - lower) / (upper - lower) - 1.0).clamp(-1.0, 1.0);
        (f64::from(degree) * x.acos()).cos()
    }

    pub(in crate::effects) fn check(&self) -> Result<(), String> {
        let range = |lower: f64, upper: f64| {
            if lower.is_finite() && upper.is_finite() && lower < upper {
                Ok(())
            } else {
                Err(format!("the range [{lower}, {upper}] of a basis has to be finite and ascending"))
            }
        };
        if self.len() > MOST_UNKNOWNS {
            return Err(format!("a basis has at most {MOST_UNKNOWNS} functions, not {}", self.len()));
        }
        match self {
            Basis::Powers(list) if list.iter().any(|&power| power > 20) => {
                Err("powers above 20 are not supported: use a spline".into())
            }
            Basis::Fourier { period, harmonics } => {
                if !period.is_finite() || *period <= 0.0 {
                    return Err(format!("a period has to be positive, not {period}"));
                }
                if harmonics.contains(&0) { Err("harmonics count from 1".into()) } else { Ok(()) }
            }
            Basis::Chebyshev { lower, upper, .. } => range(*lower, *upper),
            Basis::Spline { lower, upper, pieces, degree } => {
                if *pieces == 0 || *degree > MAX_DEGREE {
                    return Err(format!("a spline has at least 1 piece and a degree up to {MAX_DEGREE}"));
                }
                range(*lower, *upper)
            }
            Basis::Powers(_) => Ok(()),
        }
    }

    pub(super) fn words(&self, u: &str) -> Vec<String> {
        match self {
            Basis::Powers(list) => list
                .iter()
                .map(|power| match power {
                    0 => String::new(),
                    1 => u.into(),
                    _ => format!("{u}^{power}"),
                })
                .collect(),
            Basis::Fourier { harmonics, .. } => {
                harmonics.iter().flat_map(|h| [format!("sin{h}({u})"), format!("cos{h}({u})")]).collect()
            }
            Basis::Chebyshev { degrees, .. } => degrees
                .iter()
                .map(|degree| if *degree == 0 { String::new() } else { format!("T{degree}({u})") })
                .collect(),
            Basis::Spline { pieces, degree, .. } => {
                (1..=pieces + degree).map(|k| format!("B{k}({u})")).collect()
            }
        }
    }

    /// Units of the functions; only powers have one.
    pub(super) fn units(&self, unit: &str) -> Vec<String> {
        match self {
            Basis::Powers(list) if !unit.is_empty() => list
                .iter()
                .map(|power| match power {
                    0 => String::new(),
                    1 => unit.into(),
                    _ => format!("{unit}^{power}"),
                })
                .collect(),
            _ => vec![String::new(); self.len()],
        }
    }

    /// Sizes of the functions where the variable has a typical size.
    pub(super) fn sizes(&self, typical: f64) -> Vec<f64> {
        match self {
            Basis::Powers(list) => list.iter().map(|&power| typical.powi(power as i32)).collect(),
            _ => vec![1.0; self.len()],
        }
    }
}

/// `u^power` by squaring, as [`f64::powi`] does one by one.
fn raise(into: &mut [f64], u: &[f64], power: u32) {
    if power == 1 {
        into.copy_from_slice(u);
        return;
    }
    for (into, &u) in into.iter_mut().zip(u) {
        let (mut left, mut square, mut value) = (power, u, 1.0);
        while left > 0 {
            if left % 2 == 1 {
                value *= square;
            }
            square *= square;
            left /= 2;
        }
        *into = value;
    }
}

/// The degree + 1 uniform B-splines that are not zero in a cell, at t in [0, 1] of it (Cox–de Boor).
fn uniform_spline(t: f64, degree: usize) -> [f64; MAX_DEGREE + 1] {
    let mut b = [0.0; MAX_DEGREE + 1];
    b[0] = 1.0;
    for d in 1..=degree {
        let mut saved = 0.0;
        for (r, value) in b.iter_mut().enumerate().take(d) {
            // Knots to the left and right of the cell, at integer distances.
            let left = t + (d - 1 - r) as f64;
            let right = (r + 1) as f64 - t;
            let share = *value / (left + right);
            *value = saved + right * share;
            saved = left * share;
        }
        b[d] = saved;
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(basis: &Basis, u: f64) -> Vec<f64> {
        let mut values = vec![0.0; basis.len()];
        basis.for_each(u, |index, value| values[index] += value);
        values
    }

    proptest! {
        #[test]
        fn splines_sum_to_one_and_are_smooth(u in -0.5..1.5f64, pieces in 1usize..9, degree in 0usize..=5) {
            let basis = Basis::Spline { lower: 0.0, upper: 1.0, pieces, degree };
            let here = at(&basis, u);
            prop_assert!((here.iter().sum::<f64>() - 1.0).abs() < 1e-13);
            prop_assert!(here.iter().all(|&v| v >= -1e-15));
            if degree > 0 {
                let there = at(&basis, u + 1e-9);
                prop_assert!(here.iter().zip(&there).all(|(a, b)| (a - b).abs() < 1e-7));
            }
        }

        #[test]
        fn a_cubic_spline_reproduces_straight_lines(u in 0.0..1.0f64) {
            // Greville abscissae of uniform cubic splines: (k − 1) / pieces.
            let basis = Basis::Spline { lower: 0.0, upper: 1.0, pieces: 5, degree: 3 };
            let line: f64 = at(&basis, u).iter().enumerate().map(|(k, b)| b * (k as f64 - 1.0) / 5.0).sum();
            prop_assert!((line - u).abs() < 1e-13);
        }
    }

    #[test]
    fn chebyshev_by_its_recurrence() {
        let basis = Basis::Chebyshev { lower: 1.0, upper: 3.0, degrees: vec![0, 1, 2, 3] };
        let x: f64 = 0.4;
        let expected = [1.0, x, 2.0 * x * x - 1.0, 4.0 * x * x * x - 3.0 * x];
        for (value, expect) in at(&basis, 2.0 + x).iter().zip(expected) {
            assert!((value - expect).abs() < 1e-14);
        }
    }
}
