use super::*;
use truepose_errormodel::effects::Geometric;
use truepose_kinematics::samples;

fn prior() -> (Prior, usize) {
    let chain = samples::scara();
    let model = ErrorModel::new(chain, vec![Box::new(Geometric::default())]).unwrap();
    let reduction = Reduction::none(model.columns().len());
    (Prior::new(&model, &reduction, PriorStrength::Evidence), model.columns().len())
}

#[test]
fn evidence_finds_the_size_that_was_drawn() {
    let (prior, n) = prior();
    // Coefficients of 5 expected sizes each, alternately; data that determines them 100 times better.
    let spread = prior.unit.clone().try_inverse().unwrap();
    let truth = &spread * DVector::from_fn(n, |k, _| if k % 2 == 0 { 5.0 } else { -5.0 });
    let mut data = Triangular::new(n, 1);
    let a = &prior.unit * 20.0;
    let y = &a * &truth;
    data.update(&a, &DMatrix::from_column_slice(n, 1, y.as_slice())).unwrap();
    let kappa = prior.from_evidence(&data.finish()).unwrap().kappa;
    assert!((kappa - 5.0).abs() < 0.05, "{kappa}");
}

#[test]
fn groups_are_shared_out_as_their_members_sizes_say() {
    let (prior, n) = prior();
    // The first group is the sum of the first two errors; all others stand alone.
    let groups =
        DMatrix::from_fn(n - 1, n, |i, j| if (i == 0 && j < 2) || (i > 0 && j == i + 1) { 1.0 } else { 0.0 });
    let values: Vec<f64> = (0..n - 1).map(|k| 1e-3 * (k as f64 + 1.0)).collect();
    let shared = prior.shared_out(&groups, &values).unwrap();
    let variance = |k: usize| (&prior.spread * prior.spread.transpose())[(k, k)];
    let share = variance(0) / (variance(0) + variance(1));
    assert!((shared[0] - share * values[0]).abs() < 1e-12 && (&groups * &shared)[0] - values[0] < 1e-15);
    assert!((2..n).all(|k| (shared[k] - values[k - 1]).abs() < 1e-12));
}

/// `min ‖R δ − z‖² + rss + (β₀ + δ)ᵀ Σ⁻¹ (β₀ + δ)` with `Σ = κ² S²` where every group is one column: the joined factor has its normal
/// equations and its constant. Without a prior Σ⁻¹ is zero.
#[test]
fn what_is_joined_is_the_prior_and_nothing_where_there_is_none() {
    let model = ErrorModel::new(samples::scara(), vec![Box::new(Geometric::default())]).unwrap();
    let n = model.columns().len();
    let wave = |k: usize| (1.7 * k as f64 + 0.3).sin();
    let at: Vec<f64> = (0..n).map(|k| model.columns()[k].scale * wave(k)).collect();
    let mut data = Triangular::new(n, 1);
    let a = DMatrix::from_fn(3 * n, n, |i, j| wave(i * j + 7 * i + j) / model.columns()[j].scale);
    data.update(&a, &DMatrix::from_fn(3 * n, 1, |i, _| 2.0 * wave(i))).unwrap();
    let factor = data.finish();
    for (strength, kappa) in [
        (PriorStrength::Fixed(0.5), 0.5),
        (PriorStrength::Fixed(20.0), 20.0),
        (PriorStrength::None, f64::INFINITY),
    ] {
        let prior = Prior::new(&model, &Reduction::none(n), strength);
        let precision =
            DMatrix::from_fn(
                n,
                n,
                |i, j| {
                    if i == j { (kappa * model.columns()[i].scale).powi(-2) } else { 0.0 }
                },
            );
        let joined = prior.joined(&factor, &at).unwrap();
        let at = DVector::from_column_slice(&at);
        let normal = factor.r.tr_mul(&factor.r) + &precision;
        let right = factor.r.tr_mul(&factor.z) - &precision * &at;
        let penalty = at.dot(&(&precision * &at));
        let constant = factor.z.norm_squared() + factor.rss[0] + penalty;
        let size = |k: usize| normal[(k, k)].sqrt();
        let (have, moved) = (joined.r.tr_mul(&joined.r), joined.r.tr_mul(&joined.z));
        for i in 0..n {
            assert!((moved[i] - right[i]).abs() < 1e-9 * size(i) * constant.sqrt(), "{kappa} {i}");
            (0..n).for_each(|j| {
                assert!((have[(i, j)] - normal[(i, j)]).abs() < 1e-9 * size(i) * size(j), "{kappa} {i} {j}");
            });
        }
        assert!((joined.z.norm_squared() + joined.rss[0] - constant).abs() < 1e-9 * constant, "{kappa}");
        assert!((prior.penalty(at.as_slice()) - penalty).abs() <= 1e-9 * penalty, "{kappa}");
    }
}
