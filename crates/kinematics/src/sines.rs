//! Sine and cosine together, without a call and without a branch that depends on the angle.
//!
//! ```text
//! n = nearest integer of 2x/π,   r = ((x − n π_1) − n π_2) − n π_3,   π_1 + π_2 + π_3 = π/2
//! sin r ≈ r + r³ P(r²),   cos r ≈ 1 − r²/2 + r⁴ Q(r²),   |r| ≤ π/4;   n mod 4 says which is which
//! ```
//!
//! π_1 and π_2 have 33 bits, so that their products with n are exact as long as n has no more than 20. Within that range
//! the result is that of a mathematical library to 2e-16; beyond it, and for what is no number, the library is asked.
//! Sources: Cody and Waite, *Software Manual for the Elementary Functions* (1980); the coefficients are those of fdlibm (1993).

use std::f64::consts::FRAC_2_PI;

/// π/2 in three parts, rad: the first and second have 33 bits.
pub const PI_1: f64 = 1.570_796_326_734_125_6;
/// The second part, rad.
pub const PI_2: f64 = 6.077_100_506_303_966e-11;
/// The third part, rad.
pub const PI_3: f64 = 2.022_266_248_795_950_6e-21;

/// Angle beyond which the reduction would lose digits, rad.
pub const LARGEST: f64 = 1e5;

/// Adding and subtracting it rounds to an integer, which then stands in the last bits of the sum.
pub const ROUND: f64 = 6_755_399_441_055_744.0;

/// Coefficients of P, from the lowest power of r² on.
pub const P: [f64; 6] = [
    -0.166_666_666_666_666_32,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];

/// Coefficients of Q, from the lowest power of r² on.
pub const Q: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// Sine and cosine of an angle, rad.
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    if x.abs() > LARGEST || x.is_nan() {
        return x.sin_cos();
    }
    sin_cos_near(x)
}

/// The same for an angle within the range of the reduction.
#[inline(always)]
pub(crate) fn sin_cos_near(x: f64) -> (f64, f64) {
    let shifted = x * FRAC_2_PI + ROUND;
    let n = shifted - ROUND;
    let r = ((x - n * PI_1) - n * PI_2) - n * PI_3;
    let z = r * r;
    let polynomial = |c: &[f64; 6]| c[0] + z * (c[1] + z * (c[2] + z * (c[3] + z * (c[4] + z * c[5]))));
    let sine = r + r * z * polynomial(&P);
    let cosine = 1.0 - (0.5 * z - z * z * polynomial(&Q));
    let quadrant = shifted.to_bits();
    let (s, c) = if quadrant & 1 == 0 { (sine, cosine) } else { (cosine, sine) };
    // Sine changes its sign in quadrants 2 and 3, cosine in 1 and 2.
    let flip = |value: f64, bit: u64| f64::from_bits(value.to_bits() ^ (bit << 63));
    (flip(s, quadrant >> 1 & 1), flip(c, (quadrant ^ quadrant >> 1) & 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    #[track_caller]
    fn check(x: f64) {
        let ((s, c), (sine, cosine)) = (sin_cos(x), x.sin_cos());
        assert!(
            (s - sine).abs() <= 2.3e-16 && (c - cosine).abs() <= 2.3e-16,
            "{x}: {s} {sine}, {c} {cosine}"
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn is_that_of_the_library(x in -10.0..10.0f64, far in -1e5..1e5f64, small in -1e-3..1e-3f64) {
            [x, far, small].into_iter().for_each(check);
        }
    }

    #[test]
    fn quarter_turns_and_their_neighbours() {
        for k in -20_000..20_000 {
            let x = f64::from(k) * FRAC_PI_2;
            [x, x.next_up(), x.next_down(), x + 1e-9, 0.5 * x].into_iter().for_each(check);
        }
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        assert!((sin_cos(1e-200).0 - 1e-200).abs() < 1e-215);
    }

    #[test]
    fn what_is_far_or_no_number_is_the_librarys() {
        for x in [1e6, -1e22, f64::MAX] {
            assert_eq!(sin_cos(x), x.sin_cos());
        }
        assert!(sin_cos(f64::NAN).0.is_nan() && sin_cos(f64::INFINITY).1.is_nan());
    }
}
