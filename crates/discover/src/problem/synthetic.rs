//! Small data for tests: a six-axis arm, poses of one row and of several, some with an orientation, and waves for errors.

use crate::options::DiscoverOptions;
use truepose_errormodel::effects::{Geometric, JointCompliance};
use truepose_errormodel::{Dataset, ErrorModel};
use truepose_identify::{Fit, FitOptions, PriorStrength, fit};
use truepose_kinematics::{Chain, Conditions, Load, Payload, PostureBuffer, samples};
use truepose_solvers::PivotedQr;

/// A displacement of a row, m, from its pose, joints and number.
pub(crate) type Displacement<'a> = &'a dyn Fn(usize, &[f64], usize) -> [f64; 3];

/// A number of [−1, 1] that looks random and is not.
pub(crate) fn wave(k: usize) -> f64 {
    let hash = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let hash = (hash ^ (hash >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    2.0 * ((hash ^ (hash >> 29)) >> 11) as f64 / (1u64 << 53) as f64 - 1.0
}

/// A standard normal number: a sum of twelve uniform ones.
pub(crate) fn normal(k: usize) -> f64 {
    (0..12).map(|part| 0.5 * wave(12 * k + part)).sum()
}

/// Poses of one row, and every fourth of three, of an arm that carries 5 kg; every third with orientations. `error` displaces a row, m:
/// (pose, joints, row) to a displacement.
pub(crate) fn data(poses: usize, seed: usize, error: Displacement<'_>) -> (Chain, Dataset) {
    data_of(poses, seed, &<[f64]>::to_vec, error)
}

/// The same of an arm whose joints stand elsewhere than they report: `actual` are their true values, rad.
pub(crate) fn data_of(
    poses: usize,
    seed: usize,
    actual: &dyn Fn(&[f64]) -> Vec<f64>,
    error: Displacement<'_>,
) -> (Chain, Dataset) {
    let chain = samples::ur10();
    let mut data =
        Dataset { joints: vec![Vec::new(); 6], approach: vec![Vec::new(); 6], ..Dataset::default() };
    data.schema.time = true;
    let payload = Load::Payload(Payload { mass: 5.0, com: [0.0, 0.0, 0.05].into() });
    for pose in 0..poses {
        let joints: Vec<f64> = (0..6).map(|k| 2.0 * wave(1000 * seed + 6 * pose + k)).collect();
        for _ in 0..if pose % 4 == 0 { 3 } else { 1 } {
            let row = data.position.len();
            (0..6).for_each(|k| data.joints[k].push(joints[k]));
            data.approach.iter_mut().for_each(|column| column.push(0.0));
            data.load.push(payload);
            data.time.push(10.0 * pose as f64);
            data.visit.push(pose);
            data.target.push(None);
            data.position_sd.push([2e-5; 3]);
            data.orientation_sd.push([f64::NAN; 3]);
            data.position.push([f64::NAN; 3]);
            data.orientation.push(None);
            let conditions = Conditions { joints: actual(&joints), ..data.conditions(row) };
            let mut buffer = PostureBuffer::new(&chain);
            let tool = *buffer.update(&chain, &conditions).tool();
            let moved = error(pose, &joints, row);
            data.position[row] = std::array::from_fn(|axis| tool.translation[axis] + moved[axis]);
            if pose % 3 == 0 {
                let small = nalgebra::Rotation3::from_scaled_axis(nalgebra::Vector3::from(moved) * 2.0);
                let turn = nalgebra::UnitQuaternion::from_matrix(&(small.matrix() * tool.rotation));
                data.orientation[row] = Some([turn.w, turn.i, turn.j, turn.k]);
            }
        }
    }
    (chain, data)
}

/// Constant errors of all frames and compliances of all joints, fitted with a prior.
pub(crate) fn fitted(chain: &Chain, data: &Dataset) -> Fit {
    let model = ErrorModel::new(
        chain.clone(),
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())],
    )
    .expect("fits the robot");
    let options =
        FitOptions { prior: PriorStrength::Fixed(10.0), max_iterations: 4, ..DiscoverOptions::default().fit };
    fit(&model, data, &PivotedQr::default(), &options).expect("a fit")
}
