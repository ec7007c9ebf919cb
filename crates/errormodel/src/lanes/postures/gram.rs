//! Σ J_eᵀJ_e over many postures, without J_e in memory.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | A_i = [ω_x ω_y ω_z], L_i = [l_x l_y l_z] of frame i | axes and levers of a block | 3 × 3 | 1, m |
//! | Σ J_pᵀJ_p | [`JacobianGram::position`] | 6n × 6n | 1, m, m² |
//! | Σ J_φᵀJ_φ | [`JacobianGram::rotation`] | 6n × 6n | 1 |
//!
//! ```text
//! Σ J_pᵀJ_p, frames i and j:  [ Σ A_iᵀA_j  Σ A_iᵀL_j ]      Σ J_φᵀJ_φ:  [ 0      0     ]
//!                             [ Σ L_iᵀA_j  Σ L_iᵀL_j ]                  [ 0  Σ A_iᵀA_j ]
//! ```
//!
//! The rotations' products are those of the axes: 72 + 9 sums of three products for two frames in place of 216 products.

use super::{Blocks, fits};
use crate::ModelError;
use crate::lanes::{LANES, Store};
use nalgebra::DMatrix;
use truepose_kinematics::lanes::Lane;
use truepose_kinematics::pulp::{Simd, WithSimd};
use truepose_kinematics::{Chain, three};

/// Registers hold at most so many numbers.
const WIDEST: usize = 8;

/// Σ J_eᵀJ_e of the tool over postures of the nominal robot (J_e of Eq. 7), which can be added: of parts of a set of postures, on several threads or
/// machines.
///
/// 6n × 6n for n joints, fixed ones included: of each joint's frame x, y, z (m) and rx, ry, rz (rad), everything in the measurement frame.
/// Products are sums of squares of m per m, m per rad and rad per rad.
#[derive(Debug, Clone, PartialEq)]
pub struct JacobianGram {
    postures: usize,
    /// Of the positions, symmetric.
    position: DMatrix<f64>,
}

impl JacobianGram {
    /// Of the robot's first tool at these values of the joints' variables, rad or m: a column a movable joint, all of one length.
    ///
    /// # Errors
    /// When sizes do not fit.
    pub fn of(chain: &Chain, joints: &[&[f64]]) -> Result<Self, ModelError> {
        let mut blocks = Blocks::new(chain, joints)?;
        let frames = blocks.frames();
        let mut sums = vec![0.0; frames * (frames + 1) / 2 * PAIR * WIDEST];
        for block in 0..blocks.count() {
            let (store, count) = blocks.at(block);
            if count < LANES {
                store.forget(frames, count);
            }
            let arch = store.arch;
            arch.dispatch(Products { store, frames, sums: &mut sums });
        }
        let mut position = DMatrix::zeros(6 * frames, 6 * frames);
        let mut pairs = sums.chunks_exact(PAIR * WIDEST);
        for i in 0..frames {
            for (j, pair) in (i..frames).zip(&mut pairs) {
                for (number, lanes) in pair.chunks_exact(WIDEST).enumerate() {
                    let (part, k, l) = (number / 9, number / 3 % 3, number % 3);
                    let (row, column) = (6 * i + 3 * (part / 2) + k, 6 * j + 3 * (part % 2) + l);
                    let sum: f64 = lanes.iter().sum();
                    (position[(row, column)], position[(column, row)]) = (sum, sum);
                }
            }
        }
        Ok(JacobianGram { postures: blocks.postures, position })
    }

    /// Adds the sums over other postures of the same robot.
    ///
    /// # Errors
    /// When they are of a robot with another number of joints.
    pub fn add(&mut self, other: &Self) -> Result<(), ModelError> {
        fits("columns of the sums", other.position.ncols(), self.position.ncols())?;
        self.postures += other.postures;
        self.position += &other.position;
        Ok(())
    }

    /// How many postures they are of.
    pub fn postures(&self) -> usize {
        self.postures
    }

    /// Σ J_pᵀJ_p, of the rows of position.
    pub fn position(&self) -> &DMatrix<f64> {
        &self.position
    }

    /// Σ J_φᵀJ_φ, of the rows of rotation.
    pub fn rotation(&self) -> DMatrix<f64> {
        let size = self.position.nrows();
        DMatrix::from_fn(size, size, |row, column| match (row % 6, column % 6) {
            (3.., 3..) => self.position[(row - 3, column - 3)],
            _ => 0.0,
        })
    }

    /// Σ J_pᵀJ_p/σ_p² + Σ J_φᵀJ_φ/σ_φ²: positions with this standard deviation of a component, m, and rotations with theirs, rad; infinite where they are
    /// not measured.
    pub fn whitened(&self, position_sd: f64, rotation_sd: f64) -> DMatrix<f64> {
        let both = &self.position / position_sd.powi(2);
        if rotation_sd.is_finite() { both + self.rotation() / rotation_sd.powi(2) } else { both }
    }
}

/// Sums of two frames: AᵀA, AᵀL, LᵀA, LᵀL.
const PAIR: usize = 36;

struct Products<'a> {
    store: &'a Store,
    frames: usize,
    sums: &'a mut [f64],
}

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Products { store, frames, sums } = self;
        let width = LANES / S::F64_LANES;
        let numbers = S::as_simd_f64s(&store.numbers).0;
        let mut pairs = sums.chunks_exact_mut(PAIR * WIDEST);
        for i in 0..frames {
            for (j, pair) in (i..frames).zip(&mut pairs) {
                let of = |frame: usize| [store.before(frame + 1), store.lever(frame + 1)];
                for (a, first) in of(i).into_iter().enumerate() {
                    for (b, second) in of(j).into_iter().enumerate() {
                        let from = (2 * a + b) * 9 * WIDEST;
                        let sums = S::as_mut_simd_f64s(&mut pair[from..from + 9 * WIDEST]).0;
                        block(simd, numbers, (first, second), width, sums);
                    }
                }
            }
        }
    }
}

/// Adds the nine sums of three products of the columns of two 3 × 3 blocks.
#[inline(always)]
fn block<S: Simd>(
    simd: S,
    numbers: &[S::f64s],
    (first, second): (usize, usize),
    width: usize,
    sums: &mut [S::f64s],
) {
    let a = &numbers[first * width..][..9 * width];
    let b = &numbers[second * width..][..9 * width];
    let zero = Lane::splat(simd, 0.0);
    let mut made = [[zero; 3]; 3];
    for v in 0..width {
        for c in 0..3 {
            let x = three!(k => Lane::read(simd, a, 3 * k + c, width, v));
            let y = three!(l => Lane::read(simd, b, 3 * l + c, width, v));
            made = three!(k => three!(l => x[k].mul_add(y[l], made[k][l])));
        }
    }
    let stride = WIDEST / S::F64_LANES;
    for (k, made) in made.iter().enumerate() {
        for (l, made) in made.iter().enumerate() {
            let sum = &mut sums[(3 * k + l) * stride];
            *sum = (Lane::of(simd, *sum) + *made).value();
        }
    }
}
