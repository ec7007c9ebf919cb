//! The figures against plain formulas over columns of numbers, as a spreadsheet has them: no vectors, no shared code.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use truepose_acceptance::{Alignment, AssessmentOptions, Remark, assess};
use truepose_errormodel::{Channel, Dataset, DatasetBuilder, Measurement};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Load, Payload, Placed, Pose, rotation_vector, samples};

/// Numbers from −1 to 1.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

const POSES: [[f64; 6]; 5] = [
    [0.1, -1.2, 1.5, 0.2, 0.8, 0.0],
    [0.4, -1.0, 1.2, 0.1, 0.7, 0.2],
    [-0.3, -1.4, 1.7, 0.3, 0.9, -0.2],
    [0.6, -1.3, 1.4, -0.2, 0.6, 0.4],
    [-0.5, -0.9, 1.1, 0.4, 1.0, 0.1],
];

/// Five poses in 30 cycles, in the order 5 … 1; a base that stands elsewhere, with time and a load.
fn campaign() -> (Chain, Dataset) {
    let base = Pose::from_xyz_rpy([0.3, -0.2, 0.1], [0.2, -0.1, 0.7]);
    let chain = samples::ur10().with_base(Placed { pose: base, known: true }).unwrap();
    let mut builder = DatasetBuilder::new(&chain);
    let mut draw = Draw(7);
    for cycle in 0..30 {
        for pose in (0..5).rev() {
            let tool = chain.forward(&POSES[pose]);
            let mut noise = |size: f64| Vector3::new(draw.next(), draw.next(), draw.next()) * size;
            let offset = Vector3::new(3e-4, -2e-4, 1e-4) * (1.0 + pose as f64);
            let drift = Vector3::new(0.0, 0.0, 1e-6 * f64::from(cycle));
            let position = tool.translation + offset + drift + noise(4e-5);
            let rotation = rotation_vector(&(Vector3::new(2e-4, 1e-4, -3e-4) + noise(5e-5))) * tool.rotation;
            let quaternion = Pose::new(rotation, position).quaternion();
            let load = Load::Payload(Payload { mass: 10.0, com: Vector3::zeros() });
            let at = Measurement::at(POSES[pose]).position(position).orientation(quaternion);
            builder.push(at.load(load).time(f64::from(cycle) * 60.0 + 5.0 * (5 - pose) as f64)).unwrap();
        }
    }
    let data = builder.finish();
    (chain, data)
}

fn mean(column: &[f64]) -> f64 {
    column.iter().sum::<f64>() / column.len() as f64
}

fn stdev(column: &[f64]) -> f64 {
    let m = mean(column);
    let mut sum = 0.0;
    for value in column {
        sum += (value - m) * (value - m);
    }
    (sum / (column.len() as f64 - 1.0)).sqrt()
}

/// Columns x, y, z of one pose in the base frame: attained minus commanded, mm.
fn columns(chain: &Chain, data: &Dataset, pose: usize) -> [Vec<f64>; 3] {
    let base = chain.base().pose;
    let command = chain.forward(&POSES[pose]).translation;
    let mut columns = [Vec::new(), Vec::new(), Vec::new()];
    for row in (0..data.len()).filter(|row| 4 - row % 5 == pose) {
        let d: Vec<f64> = (0..3).map(|k| 1e3 * (data.position[row][k] - command[k])).collect();
        for (axis, column) in columns.iter_mut().enumerate() {
            let r = |k: usize| base.rotation[(k, axis)];
            column.push(r(0) * d[0] + r(1) * d[1] + r(2) * d[2]);
        }
    }
    columns
}

#[track_caller]
fn same(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{found} {expected}");
}

#[test]
fn pose_accuracy_and_repeatability_are_those_of_a_spreadsheet() {
    let (chain, data) = campaign();
    let found = assess(&chain, None, &data, &AssessmentOptions::default()).unwrap();
    assert_eq!(found.alignment, Alignment::Described);
    assert_eq!(found.before.poses.len(), 5);
    for row in &found.before.poses {
        // Rows come in the order 5 … 1; numbers follow the order of measurement.
        let pose = 5 - row.name[1..].parse::<usize>().unwrap();
        let [x, y, z] = columns(&chain, &data, pose);
        let figures = &row.pose;
        assert_eq!(figures.cycles, 30);
        let ap = (mean(&x).powi(2) + mean(&y).powi(2) + mean(&z).powi(2)).sqrt();
        same(1e3 * figures.ap.value, ap);
        for (figure, column) in figures.ap_axes.iter().zip([&x, &y, &z]) {
            same(1e3 * figure.value, mean(column));
            same(1e3 * figure.u, stdev(column) / 30f64.sqrt());
            // t_{0.975, 29}
            let half = 2.045229642132703 * stdev(column) / 30f64.sqrt();
            assert!((1e3 * figure.ci95[1] - mean(column) - half).abs() < 1e-9 * half);
        }
        let mut l = Vec::new();
        for j in 0..30 {
            let (a, b, c) = (x[j] - mean(&x), y[j] - mean(&y), z[j] - mean(&z));
            l.push((a * a + b * b + c * c).sqrt());
        }
        same(1e3 * figures.rp.value, mean(&l) + 3.0 * stdev(&l));
        assert!(figures.rp.ci95[0] < figures.rp.value && figures.rp.value < figures.rp.ci95[1]);
        let (angles, repeats) = (figures.ap_angles.unwrap(), figures.rp_angles.unwrap());
        // The base turns the axes; the size of the mean rotation stays.
        let size = angles.iter().map(|f| f.value.powi(2)).sum::<f64>().sqrt();
        assert!((size - 3.7417e-4).abs() < 2e-5, "{size}");
        assert!(repeats.iter().all(|f| (4e-5..1.4e-4).contains(&f.value)));
        // 3 S within √(29/χ²_{0.975}) = 0.7964 and √(29/χ²_{0.025}) = 1.3443.
        same(1e3 * repeats[0].ci95[0] / (1e3 * repeats[0].value), (29f64 / 45.722_285_804_174_53).sqrt());
    }
}

#[test]
fn distance_and_drift_are_those_of_a_spreadsheet() {
    let (chain, data) = campaign();
    let found =
        assess(&chain, None, &data, &AssessmentOptions { common: 1e-5, ..Default::default() }).unwrap();
    let [(a, b, distance)] = &found.before.distances[..] else { panic!("one pair") };
    assert_eq!((*a, *b), (1, 3));
    // P2 is the second that was measured: row 1 of each five, pose 3; P4 is pose 1.
    let command = |pose: usize| chain.forward(&POSES[pose]).translation;
    let commanded = (command(3) - command(1)).norm();
    let d: Vec<f64> = (0..30)
        .map(|cycle| {
            let (p, q) = (data.position[5 * cycle + 1], data.position[5 * cycle + 3]);
            ((p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2) + (p[2] - q[2]).powi(2)).sqrt()
        })
        .collect();
    same(1e3 * distance.ad.value, 1e3 * (mean(&d) - commanded));
    same(1e3 * distance.rd.value, 3e3 * stdev(&d));
    same(1e3 * distance.ad.u, 1e3 * (stdev(&d).powi(2) / 30.0 + 2e-10).sqrt());
    for row in &found.before.poses {
        let pose = 5 - row.name[1..].parse::<usize>().unwrap();
        let columns = columns(&chain, &data, pose);
        let block = |k: usize| {
            let part = |column: &Vec<f64>| mean(&column[10 * k..10 * k + 10]).powi(2);
            columns.iter().map(part).sum::<f64>().sqrt()
        };
        let drift = row.drift.as_ref().unwrap();
        assert_eq!((drift.blocks, drift.duration), (3, Some(29.0 * 60.0)));
        same(1e3 * drift.dap.value, (block(1) - block(0)).abs().max((block(2) - block(0)).abs()));
    }
}

#[test]
fn what_the_standard_asks_for_and_the_data_lacks_is_remarked() {
    let (chain, data) = campaign();
    let found = assess(&chain, None, &data, &AssessmentOptions::default()).unwrap();
    let has = |remark: &Remark| found.remarks.contains(remark);
    assert!(
        has(&Remark::SpeedNotStated)
            && has(&Remark::FewPlaces { poses: 5 })
            && has(&Remark::NoCommonUncertainty)
    );
    assert!(
        !has(&Remark::LoadNotStated) && !found.remarks.iter().any(|r| matches!(r, Remark::FewCycles { .. }))
    );
    let mut fewer = data.clone();
    fewer.schema.load = false;
    fewer.load.fill(Load::None);
    // The last cycle of the first pose is not measured whole.
    *fewer.position.last_mut().unwrap() = [f64::NAN, 0.0, 0.0];
    let found = assess(&chain, None, &fewer, &AssessmentOptions::default()).unwrap();
    assert!(found.remarks.contains(&Remark::FewCycles { fewest: 29 }));
    assert!(found.remarks.contains(&Remark::LoadNotStated));
    assert!(found.remarks.contains(&Remark::PartlyMeasured { rows: 1 }));
}

#[test]
fn a_best_fit_takes_a_wrong_base_away_and_distances_do_not_change() {
    let (chain, data) = campaign();
    let exact = assess(&chain, None, &data, &AssessmentOptions::default()).unwrap();
    let moved = Placed { pose: Pose::from_xyz_rpy([5.0, 4.0, 3.0], [1.0, 0.5, -2.0]), known: false };
    let elsewhere = chain.clone().with_base(moved).unwrap();
    let found = assess(&elsewhere, None, &data, &AssessmentOptions::default()).unwrap();
    assert_eq!(found.alignment, Alignment::BestFit);
    assert!(found.remarks.contains(&Remark::BestFit { poses: 5 }));
    for (a, b) in exact.before.poses.iter().zip(&found.before.poses) {
        assert!((a.pose.rp.value - b.pose.rp.value).abs() < 1e-12);
        // Orientations follow the positions: within what the residuals of the best fit leave.
        assert!(b.pose.ap_angles.unwrap().iter().all(|f| f.value.abs() < 5e-3));
    }
    let sum = |found: &truepose_acceptance::Assessment| {
        found.before.poses.iter().map(|pose| pose.pose.ap.value.powi(2)).sum::<f64>()
    };
    assert!(sum(&found) < sum(&exact));
    let ad = |found: &truepose_acceptance::Assessment| found.before.distances[0].2.ad.value;
    assert!((ad(&exact) - ad(&found)).abs() < 1e-12);
}

#[test]
fn directions_of_approach_are_told_apart() {
    let chain = samples::ur10();
    let channel = Channel { name: "direction".into(), unit: "1".into(), temperature: false };
    let mut builder = DatasetBuilder::new(&chain).channels(vec![channel]);
    let mut draw = Draw(3);
    let mut by_direction = vec![vec![]; 3];
    for n in 0..90 {
        let direction = n % 3;
        let tool = chain.forward(&POSES[0]).translation;
        let offset = [[1e-4, 0.0, 0.0], [0.0, 2e-4, 0.0], [0.0, 0.0, -1e-4]][direction];
        let noise = Vector3::new(draw.next(), draw.next(), draw.next()) * 1e-5;
        let deviation = Vector3::from(offset) + noise;
        by_direction[direction].push(deviation);
        let row = Measurement::at(POSES[0]).position(tool + deviation).channels([direction as f64 + 1.0]);
        builder.push(row.visit(n as u64)).unwrap();
    }
    let found = assess(&chain, None, &builder.finish(), &AssessmentOptions::default()).unwrap();
    let pose = &found.before.poses[0];
    let multi = pose.directions.as_ref().unwrap();
    assert_eq!((multi.directions, multi.cycles, pose.pose.cycles), (3, 30, 30));
    let means: Vec<Vec<f64>> = by_direction
        .iter()
        .map(|all| (0..3).map(|k| mean(&all.iter().map(|v| 1e3 * v[k]).collect::<Vec<_>>())).collect())
        .collect();
    let mut most: f64 = 0.0;
    for h in 0..3 {
        for k in 0..3 {
            let square: f64 = (0..3).map(|axis| (means[h][axis] - means[k][axis]).powi(2)).sum();
            most = most.max(square.sqrt());
        }
    }
    same(1e3 * multi.vap.value, most);
    assert!(found.remarks.contains(&Remark::Directions { pose: "P1".into(), directions: 3 }));
}

#[test]
fn static_compliance_is_the_slope_over_the_force() {
    let chain = samples::ur10();
    let mut builder = DatasetBuilder::new(&chain);
    let mut draw = Draw(5);
    let (mut f, mut z, mut y) = (Vec::new(), Vec::new(), Vec::new());
    for n in 0..33 {
        let mass = f64::from(n % 11);
        let load = Load::Payload(Payload { mass, com: Vector3::zeros() });
        // 20 µm a kilogram downwards, 5 µm sideways.
        let moved = Vector3::new(1e-6 * draw.next(), 5e-6 * mass, -2e-5 * mass + 1e-6 * draw.next());
        f.push(9.81 * mass);
        z.push(moved.z);
        y.push(moved.y);
        let row = Measurement::at(POSES[1]).position(chain.forward(&POSES[1]).translation + moved);
        builder.push(row.load(load).visit(n as u64)).unwrap();
    }
    let found = assess(&chain, None, &builder.finish(), &AssessmentOptions::default()).unwrap();
    let [one] = &found.before.compliance[..] else { panic!("{:?}", found.before.compliance) };
    assert_eq!((one.levels, one.cycles, one.poses.len()), (11, 33, 11));
    assert!((one.direction - Vector3::new(0.0, 0.0, -1.0)).norm() < 1e-12);
    let slope = |column: &[f64]| {
        let (mut above, mut below) = (0.0, 0.0);
        for (f_j, value) in f.iter().zip(column) {
            above += (f_j - mean(&f)) * (value - mean(column));
            below += (f_j - mean(&f)).powi(2);
        }
        above / below
    };
    assert!((one.displacement.z - slope(&z)).abs() < 1e-15 && (one.displacement.y - slope(&y)).abs() < 1e-15);
    assert!((one.compliance.value - 2.0616e-5 / 9.81).abs() < 3.0 * one.compliance.u);
}
