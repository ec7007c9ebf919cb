//! What is made of a million error Jacobians, beside the Jacobians themselves (W5): their sums of products, variances of poses, and the packed
//! layout. The peers are in `jacobian_peers.py`.

use super::shared;
use crate::robots::robot;
use crate::table::Table;
use crate::workload::{Bound, Declared, Failure, Way, Workload};
use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;
use truepose_errormodel::lanes::{JacobianGram, LANES, PACKED, error_jacobians_packed, error_variances};
use truepose_kinematics::Chain;
use truepose_kinematics::nalgebra::DMatrix;

fn postures(folder: &Path) -> Result<(Chain, Vec<Vec<f64>>), Failure> {
    let chain = robot(&folder.join("arm6r.json"))?;
    Ok((chain, Table::read(&folder.join("w5.csv"))?.series("q", 1..7)?))
}

fn columns(joints: &[Vec<f64>]) -> Vec<&[f64]> {
    joints.iter().map(Vec::as_slice).collect()
}

fn gram(folder: &Path) -> Result<Way, Failure> {
    let (chain, joints) = postures(folder)?;
    shared(move || {
        let gram = JacobianGram::of(&chain, &columns(&joints))?;
        let both = gram.whitened(1.0, 1.0);
        Ok([("checksum".into(), both.iter().map(|v| v.abs()).sum())].into())
    })
}

fn variances(folder: &Path) -> Result<Way, Failure> {
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

fn packed(folder: &Path) -> Result<Way, Failure> {
    let (chain, joints) = postures(folder)?;
    let rows = joints[0].len();
    let size = PACKED * chain.joints().len();
    let into = Rc::new(RefCell::new(vec![0.0; rows.div_ceil(LANES) * size * LANES]));
    let made = into.clone();
    let run = move || Ok(error_jacobians_packed(&chain, &columns(&joints), &mut made.borrow_mut())?);
    let check = move || {
        // Postures that are not there fill the last block.
        let sum = |(row, numbers): (usize, &[f64])| -> f64 {
            numbers[..LANES.min(rows - row / size * LANES)].iter().map(|v| v.abs()).sum()
        };
        Ok([("checksum".into(), into.borrow().chunks_exact(LANES).enumerate().map(sum).sum())].into())
    };
    Ok(Way { run: Box::new(run), check: Box::new(check) })
}

/// Σ JᵀJ, of which singular values and observability indices are a matter of microseconds.
pub const GRAM: Workload = Workload {
    name: "J-gram",
    about: "sums of products of a million error Jacobians, 36 × 36",
    bound: Bound { flops: 4.8e9, bytes: 0.0 },
    agree: &[("checksum", 9)],
    ways: &[Declared {
        name: "fused",
        asked: &[("numba-blas", 0.2), ("numba-loops", 0.2), ("numpy", 0.2)],
        prepare: gram,
    }],
};

/// Variances of the tool's pose.
pub const VARIANCES: Workload = Workload {
    name: "J-variances",
    about: "variances of a million poses, of the covariance of 36 errors",
    bound: Bound { flops: 5.9e9, bytes: 0.0 },
    agree: &[("checksum", 9)],
    ways: &[Declared { name: "fused", asked: &[("numba-blas", 0.2)], prepare: variances }],
};

/// Half of W5's numbers.
pub const PACKED_JACOBIANS: Workload = Workload {
    name: "J-packed",
    about: "a million error Jacobians without zeros and copies (6 × 18) into a warm buffer",
    bound: Bound { flops: 900e6, bytes: 0.864e9 },
    agree: &[("checksum", 9)],
    ways: &[Declared { name: "packed", asked: &[("numba", 0.5)], prepare: packed }],
};
