//! What a fit does not depend on: the order of the rows, the numbers of the visits, and where the base stands.

use proptest::prelude::*;
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{Dataset, DatasetBuilder, ErrorModel, Measurement};
use truepose_identify::{Fit, FitOptions, fit};
use truepose_kinematics::{Chain, Placed, Pose, samples};
use truepose_solvers::PivotedQr;

const VISITS: usize = 30;

/// A number in ±1 that looks drawn at random.
fn noise(seed: u64, k: usize) -> f64 {
    let mut z = seed.wrapping_add((k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Poses of a robot whose encoders are off by a milliradian, measured to 50 µm, in this order.
fn measured(chain: &Chain, seed: u64, order: &[usize], number: impl Fn(usize) -> u64) -> Dataset {
    let mut builder = DatasetBuilder::new(chain);
    for &visit in order {
        let joints: Vec<f64> = (0..6).map(|j| 1.5 * noise(seed, 6 * visit + j)).collect();
        let real: Vec<f64> =
            joints.iter().enumerate().map(|(j, q)| q + 1e-3 * noise(seed, 1000 + j)).collect();
        let tool = chain.forward(&real);
        // In the axes of the base, so that a robot that stands elsewhere has the same noise.
        let jitter = chain.base().pose.rotation
            * nalgebra::Vector3::from_fn(|k, _| 5e-5 * noise(seed, 2000 + 3 * visit + k));
        let row = Measurement::at(joints).position(tool.translation + jitter);
        builder.push(row.visit(number(visit))).expect("a row that fits the robot");
    }
    builder.finish()
}

fn fitted(chain: &Chain, data: &Dataset) -> Fit {
    let model = ErrorModel::new(chain.clone(), vec![Box::new(Geometric::default())])
        .expect("effects that fit the robot");
    fit(&model, data, &PivotedQr::default(), &FitOptions::default()).expect("a fit")
}

/// The same unknowns are kept, and no coefficient differs by more than this share of its 95 % half width.
fn same(one: &Fit, other: &Fit, share: f64) -> Result<(), TestCaseError> {
    prop_assert_eq!(&one.reduction.kept, &other.reduction.kept);
    let pairs = one.fitted.coefficients().iter().zip(other.fitted.coefficients());
    for ((a, b), width) in pairs.zip(one.half_widths()) {
        prop_assert!((a - b).abs() <= share * width, "{} and {} ± {}", a, b, width);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    #[test]
    fn the_order_of_the_rows_and_the_numbers_of_visits_do_not_matter(
        seed in any::<u64>(),
        order in Just((0..VISITS).collect::<Vec<usize>>()).prop_shuffle(),
    ) {
        let chain = samples::ur10();
        let sorted: Vec<usize> = (0..VISITS).collect();
        let one = fitted(&chain, &measured(&chain, seed, &sorted, |visit| visit as u64));
        let other = fitted(&chain, &measured(&chain, seed, &order, |visit| 1000 - 7 * visit as u64));
        // Sums in another order, and iterations that end within a thousandth of a standard deviation.
        same(&one, &other, 1e-2)?;
    }

    #[test]
    fn where_the_base_stands_does_not_matter(
        seed in any::<u64>(),
        at in prop::array::uniform3(-3.0..3.0_f64),
        turn in prop::array::uniform3(-3.0..3.0_f64),
    ) {
        let chain = samples::ur10();
        let elsewhere = chain
            .clone()
            .with_base(Placed { pose: Pose::from_xyz_rpy(at, turn), known: true })
            .unwrap();
        let order: Vec<usize> = (0..VISITS).collect();
        let one = fitted(&chain, &measured(&chain, seed, &order, |visit| visit as u64));
        let other = fitted(&elsewhere, &measured(&elsewhere, seed, &order, |visit| visit as u64));
        same(&one, &other, 1e-2)?;
    }
}
