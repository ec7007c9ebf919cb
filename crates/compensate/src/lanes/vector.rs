//! Numbers of several commands side by side: the arithmetic of `f64`, one operation for all of them.
//!
//! A lane never sees its neighbours: every operation is by elements, and so the result of a command is the same to the last bit
//! whoever it is computed with. Products and sums are fused where the processor can.

use pulp::Simd;
use std::ops::{Add, Mul, Neg, Sub};

/// One number a lane.
#[derive(Clone, Copy)]
pub(super) struct Wide<S: Simd> {
    pub simd: S,
    pub v: S::f64s,
}

impl<S: Simd> Wide<S> {
    /// The same in every lane.
    #[inline(always)]
    pub fn all(simd: S, value: f64) -> Self {
        Wide { simd, v: simd.splat_f64s(value) }
    }

    /// From as many numbers as there are lanes; zeros from fewer.
    #[inline(always)]
    pub fn of(simd: S, values: &[f64]) -> Self {
        match S::as_simd_f64s(values).0 {
            [v, ..] => Wide { simd, v: *v },
            [] => Wide::all(simd, 0.0),
        }
    }

    /// Into as many numbers as there are lanes.
    #[inline(always)]
    pub fn store(self, values: &mut [f64]) {
        self.simd.partial_store_f64s(values, self.v);
    }

    /// `self · b + c`.
    #[inline(always)]
    pub fn times_plus(self, b: Self, c: Self) -> Self {
        Wide { simd: self.simd, v: self.simd.mul_add_e_f64s(self.v, b.v, c.v) }
    }

    /// `c − self · b`.
    #[inline(always)]
    pub fn times_from(self, b: Self, c: Self) -> Self {
        Wide { simd: self.simd, v: self.simd.negate_mul_add_e_f64s(self.v, b.v, c.v) }
    }

    /// The same multiplied by a number.
    #[inline(always)]
    pub fn scaled(self, by: f64) -> Self {
        self * Wide::all(self.simd, by)
    }

    #[inline(always)]
    pub fn over(self, other: Self) -> Self {
        Wide { simd: self.simd, v: self.simd.div_f64s(self.v, other.v) }
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Wide { simd: self.simd, v: self.simd.sqrt_f64s(self.v) }
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Wide { simd: self.simd, v: self.simd.max_f64s(self.v, (-self).v) }
    }

    /// True where `self < other`; false where either is no number.
    #[inline(always)]
    pub fn below(self, other: Self) -> Lanes<S> {
        Lanes { simd: self.simd, m: self.simd.less_than_f64s(self.v, other.v) }
    }

    /// True where `self ≤ other`; false where either is no number.
    #[inline(always)]
    pub fn at_most(self, other: Self) -> Lanes<S> {
        Lanes { simd: self.simd, m: self.simd.less_than_or_equal_f64s(self.v, other.v) }
    }
}

impl<S: Simd> Add for Wide<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Wide { simd: self.simd, v: self.simd.add_f64s(self.v, other.v) }
    }
}

impl<S: Simd> Sub for Wide<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Wide { simd: self.simd, v: self.simd.sub_f64s(self.v, other.v) }
    }
}

impl<S: Simd> Mul for Wide<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Wide { simd: self.simd, v: self.simd.mul_f64s(self.v, other.v) }
    }
}

impl<S: Simd> Neg for Wide<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Wide { simd: self.simd, v: self.simd.sub_f64s(self.simd.splat_f64s(-0.0), self.v) }
    }
}

/// Yes or no for each lane.
#[derive(Clone, Copy)]
pub(super) struct Lanes<S: Simd> {
    pub simd: S,
    pub m: S::m64s,
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    pub fn none(simd: S) -> Self {
        Wide::all(simd, 1.0).below(Wide::all(simd, 0.0))
    }

    #[inline(always)]
    pub fn all(simd: S) -> Self {
        Wide::all(simd, 0.0).below(Wide::all(simd, 1.0))
    }

    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Lanes { simd: self.simd, m: self.simd.and_m64s(self.m, other.m) }
    }

    #[inline(always)]
    pub fn or(self, other: Self) -> Self {
        Lanes { simd: self.simd, m: self.simd.or_m64s(self.m, other.m) }
    }

    #[inline(always)]
    pub fn not(self) -> Self {
        Lanes { simd: self.simd, m: self.simd.not_m64s(self.m) }
    }

    /// One where it holds, the other where not.
    #[inline(always)]
    pub fn pick(self, yes: Wide<S>, no: Wide<S>) -> Wide<S> {
        Wide { simd: self.simd, v: self.simd.select_f64s(self.m, yes.v, no.v) }
    }

    /// True when it holds in every lane.
    #[inline(always)]
    pub fn everywhere(self) -> bool {
        self.simd.first_true_m64s(self.not().m) >= S::F64_LANES
    }
}

/// A vector in space for each lane.
#[derive(Clone, Copy)]
pub(super) struct Space<S: Simd> {
    pub x: Wide<S>,
    pub y: Wide<S>,
    pub z: Wide<S>,
}

impl<S: Simd> Space<S> {
    /// The same in every lane.
    #[inline(always)]
    pub fn all(simd: S, v: [f64; 3]) -> Self {
        Space { x: Wide::all(simd, v[0]), y: Wide::all(simd, v[1]), z: Wide::all(simd, v[2]) }
    }

    /// `self · by + plus`.
    #[inline(always)]
    pub fn times_plus(self, by: Wide<S>, plus: Self) -> Self {
        Space {
            x: self.x.times_plus(by, plus.x),
            y: self.y.times_plus(by, plus.y),
            z: self.z.times_plus(by, plus.z),
        }
    }

    /// `from − self · by`.
    #[inline(always)]
    pub fn times_from(self, by: Wide<S>, from: Self) -> Self {
        Space {
            x: self.x.times_from(by, from.x),
            y: self.y.times_from(by, from.y),
            z: self.z.times_from(by, from.z),
        }
    }

    #[inline(always)]
    pub fn times(self, by: Wide<S>) -> Self {
        Space { x: self.x * by, y: self.y * by, z: self.z * by }
    }

    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        Space { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }

    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Space { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> Wide<S> {
        self.x.times_plus(other.x, self.y.times_plus(other.y, self.z * other.z))
    }

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Space {
            x: self.z.times_from(other.y, self.y * other.z),
            y: self.x.times_from(other.z, self.z * other.x),
            z: self.y.times_from(other.x, self.x * other.y),
        }
    }
}
