//! What this machine can do at most on one thread: multiplications with additions a second, and bytes written a second.

use pulp::{Arch, Simd, WithSimd};
use std::hint::black_box;
use truepose_micro::clock::timed;

/// Measured limits of one thread.
#[derive(Debug, Clone, Copy, serde::Serialize, serde::Deserialize)]
pub struct Peaks {
    /// Floating-point operations a second.
    pub flops: f64,
    /// Bytes a second, copied into memory that does not fit into any cache.
    pub bytes: f64,
}

struct Multiply(usize);

impl WithSimd for Multiply {
    /// How many operations were made.
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let (m, q) = (simd.splat_f64s(black_box(0.999_999)), simd.splat_f64s(black_box(1e-6)));
        let mut v = [m; 16];
        for _ in 0..self.0 {
            for v in &mut v {
                *v = simd.mul_add_f64s(*v, m, q);
            }
        }
        let sum = v.iter().fold(q, |a, &b| simd.add_f64s(a, b));
        black_box(simd.reduce_sum_f64s(sum));
        2.0 * (16 * self.0 * S::F64_LANES) as f64
    }
}

/// The best of some tries.
pub fn measure() -> Peaks {
    let flops =
        (0..5).map(|_| timed(|| Arch::new().dispatch(Multiply(2_000_000)))).map(|(cpu, _, n)| n / cpu);
    let source = vec![1.0_f64; 1 << 13];
    let mut target = vec![0.0_f64; 1 << 24];
    let size = 8.0 * target.len() as f64;
    let bytes = (0..5).map(|_| {
        let (cpu, ..) =
            timed(|| target.chunks_exact_mut(source.len()).for_each(|c| c.copy_from_slice(&source)));
        black_box(&target);
        size / cpu
    });
    Peaks { flops: flops.fold(0.0, f64::max), bytes: bytes.fold(0.0, f64::max) }
}
