use super::{Blocks, ByVisits, Lineariser, batches, by_visits};
use crate::NoiseModel;
use nalgebra::Vector3;
use truepose_errormodel::batch::Component;
use truepose_errormodel::effects::{Geometric, JointCompliance};
use truepose_errormodel::lanes::LANES;
use truepose_errormodel::{Dataset, ErrorModel, Visits};
use truepose_kinematics::Load;
use truepose_kinematics::lanes::levels;
use truepose_kinematics::{Payload, samples};
use truepose_solvers::accumulator::{ColumnScale, Triangular};

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
