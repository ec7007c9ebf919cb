//! One number of several postures.

use crate::sines::{LARGEST, sin_cos_near};
use pulp::Simd;
use std::ops::{Add, Mul, Neg, Sub};

/// One number of as many postures as a register holds.
#[derive(Debug, Clone, Copy)]
pub struct Lane<S: Simd> {
    simd: S,
    value: S::f64s,
}

impl<S: Simd> Lane<S> {
    /// The same in all.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Lane { simd, value: simd.splat_f64s(value) }
    }

    /// From memory.
    #[inline(always)]
    pub fn of(simd: S, value: S::f64s) -> Self {
        Lane { simd, value }
    }

    /// Register `at` of row `row`, in rows of `width` registers.
    #[inline(always)]
    pub fn read(simd: S, numbers: &[S::f64s], row: usize, width: usize, at: usize) -> Self {
        Lane { simd, value: numbers[row * width + at] }
    }

    /// The register.
    #[inline(always)]
    pub fn value(self) -> S::f64s {
        self.value
    }

    /// Times a constant.
    #[inline(always)]
    pub fn times(self, by: f64) -> Self {
        self * Lane::splat(self.simd, by)
    }

    /// self · b + c.
    #[inline(always)]
    pub fn mul_add(self, b: Self, c: Self) -> Self {
        Lane { value: self.simd.mul_add_e_f64s(self.value, b.value, c.value), ..self }
    }

    /// c − self · b.
    #[inline(always)]
    pub fn take_from(self, b: Self, c: Self) -> Self {
        Lane { value: self.simd.negate_mul_add_e_f64s(self.value, b.value, c.value), ..self }
    }

    /// self + by · other, for a constant that is often zero or one.
    #[inline(always)]
    pub fn plus(self, other: Self, by: f64) -> Self {
        match by {
            0.0 => self,
            1.0 => self + other,
            _ => other.mul_add(Lane::splat(self.simd, by), self),
        }
    }
}

/// `[e(0), e(1), e(2)]`. The closure of an array's `map` would not be compiled for wide registers.
#[macro_export]
macro_rules! three {
    ($k:ident => $e:expr) => {
        [
            {
                let $k = 0_usize;
                $e
            },
            {
                let $k = 1_usize;
                $e
            },
            {
                let $k = 2_usize;
                $e
            },
        ]
    };
}

impl<S: Simd> Add for Lane<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Lane { value: self.simd.add_f64s(self.value, other.value), ..self }
    }
}

impl<S: Simd> Sub for Lane<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Lane { value: self.simd.sub_f64s(self.value, other.value), ..self }
    }
}

impl<S: Simd> Mul for Lane<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Lane { value: self.simd.mul_f64s(self.value, other.value), ..self }
    }
}

impl<S: Simd> Neg for Lane<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Lane { value: self.simd.neg_f64s(self.value), ..self }
    }
}

/// Sines and cosines of many angles, rad. To be called from within `pulp`'s dispatch, where it is compiled for wide registers.
#[inline(always)]
pub fn sin_cos_of(angles: &[f64], sines: &mut [f64], cosines: &mut [f64]) {
    let largest = angles.iter().fold(0.0_f64, |most, &x| if x.abs() <= most { most } else { x.abs() });
    let numbers = sines.iter_mut().zip(cosines).zip(angles);
    if largest <= LARGEST {
        for ((s, c), &x) in numbers {
            (*s, *c) = sin_cos_near(x);
        }
    } else {
        for ((s, c), &x) in numbers {
            (*s, *c) = crate::sin_cos(x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_of_many_are_those_of_one() {
        for scale in [1.0, 1e6] {
            let angles: Vec<f64> = (0..37).map(|k| scale * (f64::from(k) - 18.0) * 0.37).collect();
            let (mut s, mut c) = (vec![0.0; 37], vec![0.0; 37]);
            sin_cos_of(&angles, &mut s, &mut c);
            for k in 0..37 {
                assert_eq!((s[k], c[k]), crate::sin_cos(angles[k]), "{}", angles[k]);
            }
        }
    }
}
