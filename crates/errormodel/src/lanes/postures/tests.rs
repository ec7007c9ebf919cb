//! Against [`ErrorJacobian`], one posture after the other.

use super::*;
use crate::{ErrorJacobian, GeneralizedErrors, RealPosture};
use nalgebra::DMatrix;
use truepose_kinematics::{Conditions, PostureBuffer, samples};

/// The sample robots and one that branches.
fn robots() -> Vec<Chain> {
    samples::all().into_iter().chain([samples::dual()]).collect()
}

/// Values of each movable joint.
fn joints(chain: &Chain, postures: usize) -> Vec<Vec<f64>> {
    let value = |joint: usize, row: usize| 1.5 * ((row * (joint + 3) + joint) as f64).sin();
    (0..chain.movable().len()).map(|joint| (0..postures).map(|row| value(joint, row)).collect()).collect()
}

/// J_e of the joints' frames in each posture, 6 × 6n.
fn one_by_one(chain: &Chain, joints: &[Vec<f64>]) -> Vec<DMatrix<f64>> {
    let mut buffer = PostureBuffer::new(chain);
    let mut real = RealPosture::new(chain);
    let errors = GeneralizedErrors::zero(chain);
    let columns = 6 * chain.joints().len();
    (0..joints[0].len())
        .map(|row| {
            let q: Vec<f64> = joints.iter().map(|column| column[row]).collect();
            let conditions = Conditions::at(chain, &q);
            let posture = buffer.update(chain, &conditions);
            real.update(&posture, &errors);
            ErrorJacobian::new(chain, &real, &errors, None).matrix(chain).columns(6, columns).into_owned()
        })
        .collect()
}

fn slices(joints: &[Vec<f64>]) -> Vec<&[f64]> {
    joints.iter().map(Vec::as_slice).collect()
}

/// Two full blocks and some postures of a third.
const POSTURES: usize = 2 * LANES + 37;

#[test]
fn both_layouts_have_the_numbers_of_one_posture_after_the_other() {
    for chain in robots() {
        let joints = joints(&chain, POSTURES);
        let frames = chain.joints().len();
        let blocks = POSTURES.div_ceil(LANES);
        let mut whole = vec![f64::NAN; blocks * 36 * frames * LANES];
        let mut packed = vec![f64::NAN; blocks * PACKED * frames * LANES];
        error_jacobians(&chain, &slices(&joints), &mut whole).expect("sizes fit");
        error_jacobians_packed(&chain, &slices(&joints), &mut packed).expect("sizes fit");
        for (row, jacobian) in one_by_one(&chain, &joints).iter().enumerate() {
            let (block, lane) = (row / LANES, row % LANES);
            for site in 0..6 * frames {
                let frame = block * frames + site / 6;
                let axis = |c: usize| packed[(PACKED * frame + 3 * (site % 3) + c) * LANES + lane];
                let lever = |c: usize| packed[(PACKED * frame + 9 + 3 * (site % 3) + c) * LANES + lane];
                for c in 0..6 {
                    let expected = jacobian[(c, site)];
                    let number = whole[(36 * frame + 6 * (site % 6) + c) * LANES + lane];
                    let unpacked = match (site % 6, c) {
                        (0..3, 0..3) => axis(c),
                        (0..3, _) => 0.0,
                        (_, 0..3) => lever(c),
                        _ => axis(c - 3),
                    };
                    assert!((number - expected).abs() < 1e-13, "{} {row} {site} {c}", chain.name());
                    assert!((unpacked - expected).abs() < 1e-13, "{} {row} {site} {c}", chain.name());
                }
            }
        }
    }
}

#[test]
fn sums_and_variances_are_those_of_one_posture_after_the_other() {
    for chain in robots() {
        let joints = joints(&chain, POSTURES);
        let size = 6 * chain.joints().len();
        let spread = DMatrix::from_fn(size, size / 2, |i, k| 1e-3 * ((3 * i + 5 * k) as f64).cos());
        // Half of the directions are known exactly, then none is.
        let covariance = &spread * spread.transpose();
        let full = DMatrix::from_fn(size, size, |i, k| 1e-3 * ((i as f64 + 1.0) * (k as f64 + 2.0)).cos());
        let full = &full * full.transpose() + DMatrix::identity(size, size) * 1e-7;
        let mut of_full = vec![f64::NAN; 6 * POSTURES];
        error_variances(&chain, &slices(&joints), &full, &mut of_full).expect("a covariance");
        let gram = JacobianGram::of(&chain, &slices(&joints)).expect("sizes fit");
        let mut variances = vec![f64::NAN; 6 * POSTURES];
        error_variances(&chain, &slices(&joints), &covariance, &mut variances).expect("a covariance");
        let mut sums = [DMatrix::zeros(size, size), DMatrix::zeros(size, size)];
        for (row, jacobian) in one_by_one(&chain, &joints).iter().enumerate() {
            for (part, sum) in sums.iter_mut().enumerate() {
                let rows = jacobian.rows(3 * part, 3);
                *sum += rows.transpose() * rows;
            }
            for (covariance, variances) in [(&covariance, &variances), (&full, &of_full)] {
                let expected = jacobian * covariance * jacobian.transpose();
                for c in 0..6 {
                    let (found, expected) = (variances[c * POSTURES + row], expected[(c, c)]);
                    assert!(
                        (found - expected).abs() < 1e-9 * expected + 1e-18,
                        "{} {row} {c}: {found} {expected}",
                        chain.name()
                    );
                }
            }
        }
        assert_eq!(gram.postures(), POSTURES);
        let near = |a: &DMatrix<f64>, b: &DMatrix<f64>| (a - b).amax() < 1e-12 * b.amax();
        assert!(near(gram.position(), &sums[0]), "{}", chain.name());
        assert!(near(&gram.rotation(), &sums[1]), "{}", chain.name());
        let both = &sums[0] * 1e8 + &sums[1] * 1e6;
        assert!(near(&gram.whitened(1e-4, 1e-3), &both), "{}", chain.name());
    }
}

#[test]
fn sums_of_parts_add_up() {
    let chain = samples::ur10();
    let joints = joints(&chain, POSTURES);
    let of = |rows: std::ops::Range<usize>| {
        let part: Vec<&[f64]> = joints.iter().map(|column| &column[rows.clone()]).collect();
        JacobianGram::of(&chain, &part).expect("sizes fit")
    };
    let (mut parts, whole) = (of(0..100), of(0..POSTURES));
    parts.add(&of(100..POSTURES)).expect("the same robot");
    assert_eq!(parts.postures(), POSTURES);
    assert!((parts.position() - whole.position()).amax() < 1e-12 * whole.position().amax());
    assert!(of(0..0).position().amax() < f64::MIN_POSITIVE);
    let other = samples::seven();
    let other = JacobianGram::of(&other, &slices(&self::joints(&other, 2))).expect("sizes fit");
    assert!(parts.add(&other).is_err());
}

#[test]
fn what_is_no_covariance_is_refused() {
    let chain = samples::ur10();
    let joints = joints(&chain, 3);
    let size = 6 * chain.joints().len();
    let mut into = vec![0.0; 18];
    let mut of = |covariance: &DMatrix<f64>| error_variances(&chain, &slices(&joints), covariance, &mut into);
    assert!(of(&DMatrix::identity(size, size)).is_ok());
    for (row, column, value) in
        [(3, 3, -1e-9), (5, 5, f64::NAN), (7, 4, 2.0), (4, 0, f64::INFINITY), (9, 8, 0.1)]
    {
        let mut wrong = DMatrix::identity(size, size);
        wrong[(8, 8)] = 0.0;
        (wrong[(row, column)], wrong[(column, row)]) = (value, value);
        assert!(matches!(of(&wrong), Err(ModelError::NotACovariance)), "{row} {column} {value}");
    }
    let mut lopsided = DMatrix::identity(size, size);
    lopsided[(0, 5)] = 0.1;
    assert!(matches!(of(&lopsided), Err(ModelError::NotACovariance)));
    assert!(matches!(of(&DMatrix::identity(6, 6)), Err(ModelError::Shape { .. })));
}
