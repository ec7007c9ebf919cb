use super::accumulate::by_blocks;
use super::{
    Blocks, ByVisits, Lineariser, accumulate, batches, by_visits, collect, dense, factorise, gram, left_out,
    left_over, refined,
};
use crate::NoiseModel;
use crate::streamed::{Equations, FitPass};
use nalgebra::{DMatrix, Vector3};
use truepose_errormodel::batch::Component;
use truepose_errormodel::effects::{Geometric, JointCompliance};
use truepose_errormodel::lanes::LANES;
use truepose_errormodel::{Dataset, ErrorModel, FittedModel, Visits};
use truepose_kinematics::Load;
use truepose_kinematics::lanes::levels;
use truepose_kinematics::{Payload, samples};
use truepose_solvers::RankRule;
use truepose_solvers::accumulator::{ColumnScale, Factor, Triangular};

fn visits(rows: usize, movable: usize) -> Dataset {
    let wave = |k: usize, row: usize| 1.9 * ((1 + k) as f64 * 1.3 + row as f64 * 0.37 * (1 + k) as f64).sin();
    let mut data = Dataset {
        joints: (0..movable).map(|k| (0..rows).map(|row| wave(k, row)).collect()).collect(),
        approach: vec![vec![0.0; rows]; movable],
        ..Dataset::default()
    };
    for row in 0..rows {
        data.position.push([0.3 + 1e-3 * wave(7, row), -0.2, 0.5]);
        data.orientation.push(None);
        data.position_sd.push([f64::NAN; 3]);
        data.orientation_sd.push([f64::NAN; 3]);
        data.target.push(None);
        data.visit.push(row);
        data.load.push(Load::Payload(Payload { mass: (row % 3) as f64, com: Vector3::new(0.1, 0.0, 0.2) }));
        data.time.push(0.0);
    }
    data.schema.load = true;
    data
}

/// A whole linear step of an identification on registers of every width.
#[test]
fn every_level_of_the_processor_gives_the_same_fit() {
    for chain in [samples::ur10(), samples::heavy(), samples::scara()] {
        let effects: Vec<Box<dyn truepose_errormodel::AnyEffect>> =
            vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())];
        let model = ErrorModel::new(chain, effects).unwrap();
        let scales: Vec<f64> = model.columns().iter().map(|column| column.scale).collect();
        let data = visits(300, model.chain().movable().len());
        let visits = Visits::of(&data);
        let zero = vec![0.0; scales.len()];
        let noise = NoiseModel::default();
        let batches = batches(&data, &visits, 0..visits.len()).unwrap();
        let step = |arch| {
            let mut blocks = Blocks::new(&model, &data, noise, &zero, None).unwrap().on(arch);
            let mut triangle = Triangular::new(scales.len(), 1);
            for batch in &batches {
                let each = |c: Component<'_>| {
                    let rows = nalgebra::DMatrix::from_fn(c.rows, scales.len(), |i, column| {
                        c.active
                            .iter()
                            .position(|a| *a == column)
                            .map_or(0.0, |slot| c.numbers[slot * LANES + i])
                    });
                    let y =
                        nalgebra::DMatrix::from_fn(c.rows, 1, |i, _| c.numbers[c.active.len() * LANES + i]);
                    Ok(triangle.update(&rows, &y)?)
                };
                blocks.each(batch, each).unwrap();
            }
            let factor = triangle.finish();
            let turned = factor.directions(ColumnScale::Given(&scales)).unwrap();
            // Singular values, and what the data says along the clear ones; their signs are free.
            let clear = turned.values.iter().filter(|v| **v > 1e-8 * turned.values[0]).count();
            let along: Vec<f64> = turned.projections.iter().take(clear).map(|p| p * p).collect();
            (turned.values.iter().take(clear).copied().collect::<Vec<f64>>(), along)
        };
        let levels = levels();
        let (values, along) = step(levels[0]);
        for &arch in &levels[1..] {
            let (other, others) = step(arch);
            assert_eq!(values.len(), other.len(), "{arch:?}");
            for (a, b) in values.iter().zip(&other) {
                assert!((a - b).abs() < 1e-9 * values[0], "{arch:?}: {a} {b}");
            }
            let most = along.iter().sum::<f64>();
            for (a, b) in along.iter().zip(&others) {
                assert!((a - b).abs() < 1e-9 * most, "{arch:?}: {a} {b}");
            }
        }
    }
}

/// Several rows and a shared scatter a visit, some without a component, and a visit longer than a block.
#[test]
fn numbers_by_visits_are_those_of_one_visit_after_the_other() {
    let chain = samples::ur10();
    let effects: Vec<Box<dyn truepose_errormodel::AnyEffect>> =
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())];
    let model = ErrorModel::new(chain, effects).unwrap();
    let mut data = visits(300, model.chain().movable().len());
    for row in 0..data.len() {
        data.visit[row] = row % 47;
        if row % 11 == 0 {
            data.position[row][row % 3] = f64::NAN;
        }
    }
    let zero = vec![0.0; model.columns().len()];
    let columns = [40, 3, 17, 2, model.columns().len() - 1];
    let noise = NoiseModel { visit_sd: 2e-5, ..NoiseModel::default() };
    let same = |data: &Dataset| {
        let visits = Visits::of(data);
        let ByVisits { numbers, visits: ranges } =
            by_visits(&model, data, &visits, noise, &zero, &columns).unwrap();
        let mut lineariser = Lineariser::new(&model, data, noise, &zero).unwrap().of_columns(&columns);
        assert_eq!(ranges.len(), visits.len());
        for (rows, range) in visits.rows.iter().zip(ranges) {
            let expected = nalgebra::DMatrix::from_column_slice(6, range.len(), lineariser.visit(rows).rows);
            let have = numbers.columns(range.start, range.len());
            // Within a visit their order is free.
            let (have, expected) = (have * have.transpose(), &expected * expected.transpose());
            assert!((&have - &expected).amax() < 1e-9 * expected.amax().max(1.0), "{have}{expected}");
        }
    };
    assert!(batches(&data, &Visits::of(&data), 0..47).is_some());
    same(&data);
    data.visit.iter_mut().for_each(|visit| *visit %= 2);
    assert!(batches(&data, &Visits::of(&data), 0..2).is_none());
    same(&data);
}

#[test]
fn blocks_have_every_visit_once_and_in_order() {
    for count in [1, 2, 3, 4095, 4096, 4097, 8193, 12_289] {
        let visits = Visits { rows: vec![Vec::new(); count] };
        for worth_two in [0, usize::MAX] {
            let parts = by_blocks(&visits, 1, worth_two, |range, _| Ok(range)).unwrap();
            assert!(parts.iter().flat_map(Clone::clone).eq(0..count), "{count}: {parts:?}");
        }
    }
}

/// The columns of [`every_way`]: some that the data distinguishes.
const SOME: [usize; 5] = [2, 3, 9, 17, 44];

/// Every way of forming `Z = [A | r]` as ZᵀZ, with its name and the number of rows where it counts them.
fn every_way(
    model: &ErrorModel,
    data: &Dataset,
    noise: NoiseModel,
) -> Vec<(&'static str, DMatrix<f64>, Option<usize>)> {
    let (visits, zero) = (Visits::of(data), vec![0.0; model.columns().len()]);
    let of_factor = |factor: &Factor| {
        let p = factor.columns();
        let mut whole = factor.r.clone().resize(p + 1, p + 1, 0.0);
        whole.view_mut((0, p), (p, 1)).copy_from(&factor.z);
        whole[(p, p)] = factor.rss[0].sqrt();
        (whole.tr_mul(&whole), Some(factor.rows))
    };
    let by_rows = |rows: &DMatrix<f64>| (rows.tr_mul(rows), Some(rows.nrows()));
    let collected = collect(model, data, &visits, noise, &zero).unwrap();
    let mut picked = collected.a.select_columns(&SOME).insert_column(SOME.len(), 0.0);
    picked.set_column(SOME.len(), &collected.residual);
    let lineariser = Lineariser::new(model, data, noise, &zero).unwrap().of_columns(&SOME);
    let of_visits = by_visits(model, data, &visits, noise, &zero, &SOME).unwrap().numbers.transpose();
    let mut all = vec![
        (
            "gram",
            of_factor(&gram(model, data, &visits, noise, &zero, Some(&SOME)).unwrap().finish().unwrap()),
        ),
        ("triangle", of_factor(&factorise(model, data, &visits, noise, &zero, Some(&SOME)).unwrap())),
        ("row by row", of_factor(&accumulate(lineariser, &visits, 0..visits.len()).unwrap().into_factor())),
        ("dense", by_rows(&dense(model, data, &visits, noise, &zero, Some(&SOME)).unwrap())),
        ("collected", by_rows(&picked)),
        ("by visits", by_rows(&of_visits)),
    ];
    // In blocks of about 101 rows and three folds, as rows come from a file.
    let fitted =
        FittedModel::new(model.clone(), zero.clone(), DMatrix::zeros(zero.len(), zero.len())).unwrap();
    for (name, all_digits) in [("streamed", false), ("streamed, all digits", true)] {
        let at = zero.clone();
        let pass = FitPass { fitted: fitted.clone(), at, kept: SOME.to_vec(), noise, folds: 3, all_digits };
        let (mut sums, mut first) = (pass.nothing(), 0);
        while first < data.len() {
            let end = (first + 101).min(data.len());
            // No visit is cut.
            let end =
                (end..data.len()).find(|&row| data.visit[row] != data.visit[row - 1]).unwrap_or(data.len());
            sums.merge(&pass.sums(&data.select(&Vec::from_iter(first..end))).unwrap()).unwrap();
            first = end;
        }
        assert_eq!((sums.rows, sums.visits), (data.len(), visits.len()));
        let folds: Vec<Factor> = match sums.equations {
            Equations::Gram(folds) => folds.iter().map(|fold| fold.finish().unwrap()).collect(),
            Equations::Triangle(folds) => folds.into_iter().map(Triangular::into_factor).collect(),
        };
        let sum = folds.iter().map(|fold| of_factor(fold).0).sum();
        all.push((name, (sum, Some(sums.observations))));
    }
    all.into_iter().map(|(name, (products, rows))| (name, products, rows)).collect()
}

/// `ZᵀZ = Σ_v Z_vᵀZ_v` over all visits v, the last ones of blocks among them, and what is made of it: `x = (AᵀA)⁻¹Aᵀr`, the residuals of
/// every row, and those of a visit that is left out, from the rows without it.
#[test]
fn every_way_has_every_row() {
    let effects: Vec<Box<dyn truepose_errormodel::AnyEffect>> =
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())];
    let model = ErrorModel::new(samples::ur10(), effects).unwrap();
    // Visits of one and two rows, and a last block of lanes that is not full.
    let mut data = visits(601, 6);
    for row in 0..data.len() {
        data.visit[row] = 2 * row / 3;
        if row % 11 == 0 {
            data.position[row][row % 3] = f64::NAN;
        }
    }
    let noise = NoiseModel { visit_sd: 2e-5, ..NoiseModel::default() };
    let (of, zero, p) = (Visits::of(&data), vec![0.0; model.columns().len()], SOME.len());
    let mut lineariser = Lineariser::new(&model, &data, noise, &zero).unwrap().of_columns(&SOME);
    let mut numbers = 0;
    let blocks: Vec<DMatrix<f64>> = of
        .rows
        .iter()
        .map(|rows| {
            let block = lineariser.visit(rows);
            numbers += block.source.len();
            DMatrix::from_row_slice(block.source.len(), p + 1, block.rows)
        })
        .collect();
    assert_eq!(numbers, 3 * data.len() - data.len().div_ceil(11));
    let expected: DMatrix<f64> = blocks.iter().map(|block| block.tr_mul(block)).sum();
    for (name, products, rows) in every_way(&model, &data, noise) {
        assert_eq!(rows.unwrap_or(numbers), numbers, "{name}");
        for (i, j) in (0..=p).flat_map(|i| (0..=p).map(move |j| (i, j))) {
            let size = (expected[(i, i)] * expected[(j, j)]).sqrt();
            assert!((products[(i, j)] - expected[(i, j)]).abs() < 1e-9 * size, "{name} {i} {j}");
        }
    }
    let solved = |z: &DMatrix<f64>| z.view((0, 0), (p, p)).lu().solve(&z.view((0, p), (p, 1))).unwrap();
    let found = refined(&model, &data, &of, noise, &zero, Some(&SOME), (1e6, RankRule::Relative(1e-9)));
    let (found, best) = (found.unwrap().expect("columns that are far apart"), solved(&expected));
    (0..p).for_each(|k| assert!((found.x[k] / best[k] - 1.0).abs() < 1e-6, "{k}"));
    let alone = left_out(&model, &data, &of, noise, &zero, Some(&SOME)).unwrap().one_by_one().unwrap();
    let left = left_over(&model, &data, &zero, &zero).unwrap();
    for visit in [0, 1, 200, of.len() - 2, of.len() - 1] {
        let block = &blocks[visit];
        let without = solved(&(&expected - block.tr_mul(block)));
        let held_out = (block.column(p) - block.columns(0, p) * without).norm();
        let have = alone[visit].iter().map(|v| v * v).sum::<f64>().sqrt();
        assert!((have / held_out - 1.0).abs() < 1e-6, "{visit}: {have} {held_out}");
        let raw = lineariser.unweighted(&of.rows[visit]);
        for (numbers, &(row, component)) in raw.rows.chunks_exact(p + 1).zip(raw.source) {
            assert!((left.position[row][component] - numbers[p]).abs() < 1e-12, "{visit}");
        }
    }
}
