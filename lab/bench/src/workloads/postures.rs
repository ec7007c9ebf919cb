//! W5: a million error Jacobians; and what is made of them: their sums of products, variances of poses, the packed layout. The peers are in `jacobian_peers.py`.

use super::shared;
use crate::prelude::*;
use truepose_errormodel::lanes::{
    JacobianGram, LANES, PACKED, error_jacobians, error_jacobians_packed, error_variances,
};

fn postures(folder: &Path) -> Outcome<(Chain, Vec<Vec<f64>>)> {
    let chain = robot(&folder.join("arm6r.json"))?;
    Ok((chain, Table::read(&folder.join("w5.csv"))?.series("q", 1..7)?))
}

fn columns(joints: &[Vec<f64>]) -> Vec<&[f64]> {
    joints.iter().map(Vec::as_slice).collect()
}

fn gram(folder: &Path) -> Outcome<Way> {
    let (chain, joints) = postures(folder)?;
    shared(move || {
        let gram = JacobianGram::of(&chain, &columns(&joints))?;
        let both = gram.whitened(1.0, 1.0);
        Ok([("checksum".into(), both.iter().map(|v| v.abs()).sum())].into())
    })
}

fn variances(folder: &Path) -> Outcome<Way> {
    let (chain, joints) = postures(folder)?;
    // Within each frame alone and the same along its axes: the peers' frames are turned by right angles. Nobody makes use of the zeros.
    let covariance =
        DMatrix::from_fn(36, 36, |i, k| match (i / 6 == k / 6 && i % 3 == k % 3, i % 6 < 3, k % 6 < 3) {
            (false, ..) => 0.0,
            (_, true, true) => 1e-8 * (1 + i / 6) as f64,
            (_, false, false) => 1e-6,
            _ => 3e-8,
        });
    let mut into = vec![0.0; 6 * joints[0].len()];
    shared(move || {
        error_variances(&chain, &columns(&joints), &covariance, &mut into)?;
        Ok([("checksum".into(), into.iter().sum())].into())
    })
}

fn full(folder: &Path) -> Outcome<Way> {
    jacobians(folder, 36 * 6, |chain, columns, into| Ok(error_jacobians(chain, columns, into)?))
}

fn packed(folder: &Path) -> Outcome<Way> {
    let size = PACKED * postures(folder)?.0.joints().len();
    jacobians(folder, size, |chain, columns, into| Ok(error_jacobians_packed(chain, columns, into)?))
}

/// Jacobians of this many numbers into a warm buffer.
fn jacobians(
    folder: &Path,
    size: usize,
    fill: impl Fn(&Chain, &[&[f64]], &mut [f64]) -> Outcome + 'static,
) -> Outcome<Way> {
    let (chain, joints) = postures(folder)?;
    let rows = joints[0].len();
    let into = Rc::new(RefCell::new(vec![0.0; rows.div_ceil(LANES) * size * LANES]));
    let made = into.clone();
    let run = move || fill(&chain, &columns(&joints), &mut made.borrow_mut());
    let check = move || {
        // Postures that are not there fill the last block.
        let sum = |(row, numbers): (usize, &[f64])| -> f64 {
            numbers[..LANES.min(rows - row / size * LANES)].iter().map(|v| v.abs()).sum()
        };
        Ok([("checksum".into(), into.borrow().chunks_exact(LANES).enumerate().map(sum).sum())].into())
    };
    Ok(Way { run: Box::new(run), check: Box::new(check) })
}

/// A million error Jacobians.
pub const W5: Workload = Workload::of(
    "W5",
    "a million error Jacobians (6 × 36) into a warm buffer",
    [900e6, 1.728e9],
    &[("checksum", 9)],
    &[Declared::of("lanes", &[("numba", 0.3), ("numpy", 0.3)], full)],
);

/// Σ JᵀJ, of which singular values and observability indices are a matter of microseconds.
pub const GRAM: Workload = Workload::of(
    "J-gram",
    "sums of products of a million error Jacobians, 36 × 36",
    [4.8e9, 0.0],
    &[("checksum", 9)],
    &[Declared::of("fused", &[("numba-blas", 0.2), ("numba-loops", 0.2), ("numpy", 0.2)], gram)],
);

/// Variances of the tool's pose.
pub const VARIANCES: Workload = Workload::of(
    "J-variances",
    "variances of a million poses, of the covariance of 36 errors",
    [5.9e9, 0.0],
    &[("checksum", 9)],
    &[Declared::of("fused", &[("numba-blas", 0.2)], variances)],
);

/// Half of W5's numbers.
pub const PACKED_JACOBIANS: Workload = Workload::of(
    "J-packed",
    "a million error Jacobians without zeros and copies (6 × 18) into a warm buffer",
    [900e6, 0.864e9],
    &[("checksum", 9)],
    &[Declared::of("packed", &[("numba", 0.5)], packed)],
);
