//! Sine and cosine of several angles at once: the polynomials of `truepose_kinematics::sin_cos`, and nothing else beside them.

use super::vector::{Lanes, Wide};
use pulp::Simd;
use std::f64::consts::FRAC_2_PI;
use truepose_kinematics::sines::{LARGEST, P, PI_1, PI_2, PI_3, Q, ROUND};

/// What [`Wide::sin_cos_small`] is good for, rad.
pub(super) const SMALL: f64 = 0.03;

impl<S: Simd> Wide<S> {
    /// Sine and cosine, as `truepose_kinematics::sin_cos` up to its largest angle, and whether the lane lies within that.
    #[inline(always)]
    pub fn sin_cos(self) -> (Self, Self, Lanes<S>) {
        let s = self.simd;
        let all = |value| Wide::all(s, value);
        let shifted = self.times_plus(all(FRAC_2_PI), all(ROUND));
        let n = shifted - all(ROUND);
        let r = n.times_from(all(PI_3), n.times_from(all(PI_2), n.times_from(all(PI_1), self)));
        let z = r * r;
        let polynomial = |c: &[f64; 6]| {
            let mut sum = all(c[5]);
            for k in (0..5).rev() {
                sum = sum.times_plus(z, all(c[k]));
            }
            sum
        };
        let sine = (r * z).times_plus(polynomial(&P), r);
        let cosine = all(1.0) - ((z * z).times_from(polynomial(&Q), z.scaled(0.5)));
        let quadrant = s.transmute_u64s_f64s(shifted.v);
        let bit = |of: S::u64s, which: u64| Lanes {
            simd: s,
            m: s.equal_u64s(s.and_u64s(of, s.splat_u64s(which)), s.splat_u64s(which)),
        };
        let odd = bit(quadrant, 1);
        let (a, b) = (odd.pick(cosine, sine), odd.pick(sine, cosine));
        // Sine changes its sign in quadrants 2 and 3, cosine in 1 and 2.
        let next = s.add_u64s(quadrant, s.splat_u64s(1));
        let (a, b) = (bit(quadrant, 2).pick(-a, a), bit(next, 2).pick(-b, b));
        (a, b, self.abs().at_most(all(LARGEST)))
    }

    /// Sine and cosine below 0.03 rad by their series, to the last digit.
    #[inline(always)]
    pub fn sin_cos_small(self) -> (Self, Self) {
        let all = |value| Wide::all(self.simd, value);
        let t = self * self;
        let shrink = |by: f64, inner: Self| (t.scaled(by)).times_from(inner, all(1.0));
        let s = self * shrink(1.0 / 6.0, shrink(1.0 / 20.0, all(1.0) - t.scaled(1.0 / 42.0)));
        let c = shrink(0.5, shrink(1.0 / 12.0, shrink(1.0 / 30.0, all(1.0) - t.scaled(1.0 / 56.0))));
        (s, c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both of them at four angles a time, on the processor's own lanes.
    struct At<'a>(&'a [f64], bool);

    impl pulp::WithSimd for At<'_> {
        type Output = Vec<(f64, f64)>;
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let mut out = Vec::new();
            for chunk in self.0.chunks_exact(8).flat_map(|eight| eight.chunks_exact(S::F64_LANES)) {
                let x = Wide::of(simd, chunk);
                let (s, c) = if self.1 {
                    x.sin_cos_small()
                } else {
                    let (s, c, within) = x.sin_cos();
                    assert!(within.everywhere());
                    (s, c)
                };
                let (mut sine, mut cosine) = ([0.0; 8], [0.0; 8]);
                s.store(&mut sine[..S::F64_LANES]);
                c.store(&mut cosine[..S::F64_LANES]);
                out.extend(sine.into_iter().zip(cosine).take(S::F64_LANES));
            }
            out
        }
    }

    #[test]
    fn they_are_those_of_one_angle() {
        let angles: Vec<f64> =
            (-40_000..40_000).map(|k| 0.000_37 * f64::from(k) * f64::from(k % 7)).collect();
        let small: Vec<f64> = (-296..296).map(|k| 1e-4 * f64::from(k)).collect();
        for (x, series) in [(angles, false), (small, true)] {
            for arch in [pulp::Arch::new(), pulp::Arch::Scalar] {
                let found = arch.dispatch(At(&x, series));
                assert_eq!(found.len(), x.len());
                for (&x, (s, c)) in x.iter().zip(found) {
                    let (sine, cosine) = x.sin_cos();
                    assert!((s - sine).abs() <= 2.3e-16 && (c - cosine).abs() <= 2.3e-16, "{x}: {s} {c}");
                }
            }
        }
    }

    #[test]
    fn what_is_far_or_no_number_is_marked() {
        struct Within(f64);
        impl pulp::WithSimd for Within {
            type Output = bool;
            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) -> bool {
                Wide::all(simd, self.0).sin_cos().2.everywhere()
            }
        }
        for (x, good) in [(99_999.0, true), (1e6, false), (f64::NAN, false), (f64::NEG_INFINITY, false)] {
            assert_eq!(pulp::Arch::new().dispatch(Within(x)), good, "{x}");
        }
    }
}
