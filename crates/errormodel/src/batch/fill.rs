//! The design matrix of a block, component by component: `w (P J_e Φ)` and `w (y − y(c))`.
//!
//! A component (0…2 position, 3…5 orientation) has its own columns: those that are not zero in the whole block. A column stands
//! as `LANES` numbers, of which the first ones, one a row, count; behind the last column stands the residual.

use crate::lanes::{LANES, LaneEmission, LaneEntry, LaneErrors, Store};
use nalgebra::Matrix3;
use truepose_kinematics::lanes::Lane;
use truepose_kinematics::pulp::{Simd, WithSimd};
use truepose_kinematics::{rotation_log, three};

/// One component of all rows of a block.
#[derive(Debug, Clone, Copy)]
pub struct Component<'a> {
    /// 0…2 position, 3…5 orientation.
    pub index: usize,
    /// Which columns there are, in the numbering that was asked for.
    pub active: &'a [usize],
    /// Rows that count.
    pub rows: usize,
    /// `LANES` numbers a column, in the order of `active`; the residual comes last.
    pub numbers: &'a [f64],
}

/// Memory for columns.
#[derive(Debug, Clone, Default)]
pub(super) struct Fill {
    pub(super) active: [Vec<usize>; 6],
    pub(super) numbers: [Vec<f64>; 6],
    pub(super) slots: Vec<usize>,
    /// Per row of the store: not looked at, zero, not zero.
    pub(super) known: Vec<Option<bool>>,
    pub(super) values: Vec<bool>,
    pub(super) frames: Vec<bool>,
    /// Position and rotation (by columns) as measured.
    pub(super) measured: Vec<f64>,
    pub(super) rows: usize,
    /// Whether any orientation was measured.
    pub(super) turned: bool,
    /// Where some row measured one number along a direction: what such a row sees, in the place of x.
    pub(super) along: Along,
}

/// Rows that measured one number: their first component is that along their direction; of other rows it is x.
#[derive(Debug, Clone, Default)]
pub(super) struct Along {
    /// Whether there are any in the block.
    pub(super) any: bool,
    /// w of each lane: `LANES` numbers a component; (1, 0, 0) where no direction was measured along.
    pub(super) direction: Vec<f64>,
    /// w·p and w·P.
    pub(super) point: Vec<f64>,
    pub(super) measured: Vec<f64>,
    /// w·J_e of the sites that count, `LANES` numbers a site.
    pub(super) levers: Vec<f64>,
}

impl Along {
    /// The lever of a site.
    #[inline(always)]
    pub(super) fn lever(&self, site: usize) -> &[f64] {
        &self.levers[site * LANES..][..LANES]
    }
}

pub(super) struct Left<'a> {
    pub(super) store: &'a Store,
    pub(super) change: &'a LaneErrors,
    pub(super) fill: &'a Fill,
    pub(super) into: &'a mut [f64],
}

impl WithSimd for Left<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Left { store, change, fill, into } = self;
        let vectors = fill.rows.div_ceil(S::F64_LANES);
        let turn = rotations(simd, store, fill);
        for (component, into) in into.chunks_exact_mut(LANES).take(6).enumerate() {
            let along = component == 0 && fill.along.any;
            if component < 3 {
                let (point, measured) = match along {
                    true => (&*fill.along.point, &*fill.along.measured),
                    false => {
                        (store.row(store.point() + component), &fill.measured[component * LANES..][..LANES])
                    }
                };
                into.iter_mut().zip(measured).zip(point).for_each(|((into, y), p)| *into = y - p);
            } else {
                into.copy_from_slice(&turn[(component - 3) * LANES..][..LANES]);
                if !fill.turned {
                    continue;
                }
            }
            let into = S::as_mut_simd_f64s(into).0;
            for site in 0..change.sites() {
                let (same, lanes) = change.at(site);
                if same == 0.0 && lanes.is_none() {
                    continue;
                }
                let Some(row) = store.of_site(store.site(site), component) else { continue };
                let lever = if along { fill.along.lever(site) } else { store.row(row) };
                let lever = S::as_simd_f64s(lever).0;
                let same = simd.splat_f64s(same);
                for v in 0..vectors {
                    let by = match lanes {
                        Some(lanes) => simd.add_f64s(same, S::as_simd_f64s(lanes).0[v]),
                        None => same,
                    };
                    into[v] = simd.negate_mul_add_e_f64s(lever[v], by, into[v]);
                }
            }
        }
    }
}

pub(super) struct Columns<'a> {
    pub(super) store: &'a Store,
    pub(super) emission: &'a LaneEmission,
    pub(super) fill: &'a mut Fill,
    pub(super) weights: &'a [f64],
    pub(super) places: &'a [Option<usize>],
}

impl WithSimd for Columns<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Columns { store, emission, fill, weights, places } = self;
        let rows = fill.rows;
        let vectors = rows.div_ceil(S::F64_LANES);
        let width = LANES / S::F64_LANES;
        let rotation = rotations(simd, store, fill);
        for component in 0..6 {
            let weight = &weights[component * LANES..][..LANES];
            let active = &mut fill.active[component];
            active.clear();
            if weight[..rows].iter().all(|&w| w == 0.0) {
                fill.numbers[component].clear();
                continue;
            }
            let along = component == 0 && fill.along.any;
            let alike = weight[..rows].iter().all(|&w| is_one(w));
            let numbers = &mut fill.numbers[component];
            numbers.resize((fill.slots.len() + 1) * LANES, 0.0);
            let weight = S::as_simd_f64s(weight).0;
            let into = S::as_mut_simd_f64s(numbers).0;
            for &LaneEntry { column, site, value, factor } in &emission.entries {
                let Some(place) = places[column as usize] else { continue };
                let Some(row) = store.of_site(site, component) else { continue };
                if fill.values[value.0 as usize] {
                    continue;
                }
                let lever = if along { fill.along.lever(store.index(site)) } else { store.row(row) };
                let zero = match along {
                    true => lever[..rows].iter().all(|&v| v == 0.0),
                    false => *fill.known[row].get_or_insert_with(|| lever[..rows].iter().all(|&v| v == 0.0)),
                };
                if zero {
                    continue;
                }
                let first = fill.slots[place] == usize::MAX;
                if first {
                    fill.slots[place] = active.len();
                    active.push(place);
                }
                let into = &mut into[fill.slots[place] * width..][..vectors];
                let lever = &S::as_simd_f64s(lever).0[..vectors];
                let value = match value == LaneEmission::ONE {
                    true => None,
                    false => Some(&S::as_simd_f64s(emission.numbers(value)).0[..vectors]),
                };
                match (value, alike && is_one(factor), first) {
                    (None, true, true) => into.copy_from_slice(lever),
                    (Some(value), true, true) => {
                        for ((into, &a), &b) in into.iter_mut().zip(lever).zip(value) {
                            *into = simd.mul_f64s(a, b);
                        }
                    }
                    _ => {
                        let factor = simd.splat_f64s(factor);
                        for v in 0..vectors {
                            let mut made = simd.mul_f64s(lever[v], factor);
                            if let Some(value) = value {
                                made = simd.mul_f64s(made, value[v]);
                            }
                            made = if alike { made } else { simd.mul_f64s(made, weight[v]) };
                            into[v] = if first { made } else { simd.add_f64s(into[v], made) };
                        }
                    }
                }
            }
            let last = &mut into[active.len() * width..][..vectors];
            if component < 3 {
                let (measured, point) = match along {
                    true => (&*fill.along.measured, &*fill.along.point),
                    false => {
                        (&fill.measured[component * LANES..][..LANES], store.row(store.point() + component))
                    }
                };
                let (measured, point) = (S::as_simd_f64s(measured).0, S::as_simd_f64s(point).0);
                for v in 0..vectors {
                    last[v] = simd.mul_f64s(simd.sub_f64s(measured[v], point[v]), weight[v]);
                }
            } else {
                let turn = S::as_simd_f64s(&rotation[(component - 3) * LANES..]).0;
                for v in 0..vectors {
                    last[v] = simd.mul_f64s(turn[v], weight[v]);
                }
            }
            active.iter().for_each(|&place| fill.slots[place] = usize::MAX);
        }
    }
}

/// A factor that changes nothing.
#[inline(always)]
fn is_one(factor: f64) -> bool {
    factor.to_bits() == 1.0_f64.to_bits()
}

/// Where the sine's series is right to the last digit, squared.
const SMALL: f64 = 1e-2;

/// Rotation vectors from the model's orientation to the measured one, measurement frame, rad.
#[inline(always)]
fn rotations<S: Simd>(simd: S, store: &Store, fill: &Fill) -> [f64; 3 * LANES] {
    let mut out = [0.0; 3 * LANES];
    if !fill.turned {
        return out;
    }
    let (vectors, width) = (fill.rows.div_ceil(S::F64_LANES), LANES / S::F64_LANES);
    let tool = store.tool().0;
    let (numbers, measured) = (S::as_simd_f64s(&store.numbers).0, S::as_simd_f64s(&fill.measured).0);
    let mut trace = [0.0; LANES];
    {
        let (turn, trace) = (S::as_mut_simd_f64s(&mut out).0, S::as_mut_simd_f64s(&mut trace).0);
        for v in 0..vectors {
            // D = R_measured R_modelᵀ, row by row of both.
            let m = three!(i => three!(k => Lane::read(simd, measured, 3 + 3 * k + i, width, v)));
            let r = three!(j => three!(k => Lane::read(simd, numbers, tool + 3 * k + j, width, v)));
            let w = [
                (dot(m[2], r[1]) - dot(m[1], r[2])).times(0.5),
                (dot(m[0], r[2]) - dot(m[2], r[0])).times(0.5),
                (dot(m[1], r[0]) - dot(m[0], r[1])).times(0.5),
            ];
            let z = dot(w, w);
            // asin(s)/s by powers of s².
            let mut series = Lane::splat(simd, ASIN[ASIN.len() - 1]);
            for &c in ASIN.iter().rev().skip(1) {
                series = series.mul_add(z, Lane::splat(simd, c));
            }
            for (k, w) in w.iter().enumerate() {
                turn[k * width + v] = (*w * series).value();
            }
            trace[v] = (dot(m[0], r[0]) + dot(m[1], r[1]) + dot(m[2], r[2])).value();
        }
    }
    // 1 + 2 cos of the angle, where the sine is small.
    let near = 1.0 + 2.0 * (1.0 - SMALL).sqrt();
    for lane in 0..fill.rows {
        // What was not measured is a matrix of zeros, and turned by nothing.
        let seen = fill.measured[3 * LANES..].chunks_exact(LANES).any(|row| row[lane] != 0.0);
        if trace[lane] < near && seen {
            let at = |row: usize| Matrix3::from_fn(|i, k| store.row(row + 3 * k + i)[lane]);
            let measured = Matrix3::from_fn(|i, k| fill.measured[(3 + 3 * k + i) * LANES + lane]);
            let turn = rotation_log(&(measured * at(tool).transpose()));
            (0..3).for_each(|k| out[k * LANES + lane] = turn[k]);
        }
    }
    out
}

#[inline(always)]
fn dot<S: Simd>(a: [Lane<S>; 3], b: [Lane<S>; 3]) -> Lane<S> {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// (2k)! / (4^k k!² (2k + 1)).
const ASIN: [f64; 9] = [
    1.0,
    1.0 / 6.0,
    3.0 / 40.0,
    15.0 / 336.0,
    105.0 / 3456.0,
    945.0 / 42240.0,
    10395.0 / 599_040.0,
    135_135.0 / 9_676_800.0,
    2_027_025.0 / 175_472_640.0,
];
