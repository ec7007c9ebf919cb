use super::Lanes;
use crate::effects::{
    BaseCompliance, Basis, Expansion, Factor, Geometric, Guideway, Input, JointCompliance, LinkCompliance,
    Observed, OwnWeight, Place, Polynomial, Section, Sensor, Transmission, Unknown, WrenchComponent,
};
use crate::lanes::LANES;
use crate::{AnyEffect, Dataset, Equilibrium, ErrorJacobian, ErrorModel, Ray, RobotPoint, Schema};
use nalgebra::Vector3;
use truepose_kinematics::lanes::levels;
use truepose_kinematics::pulp::Arch;
use truepose_kinematics::{
    Axis, Chain, FrameId, JointId, JointKind, Load, Payload, TargetId, ToolId, Wrench, rotation_log, samples,
};

fn data(chain: &Chain, rows: usize) -> Dataset {
    let movable = chain.movable().len();
    let wave = |k: usize, row: usize| 0.9 * ((1 + k) as f64 * 1.3 + row as f64 * 0.37).sin();
    let mut data = Dataset {
        schema: Schema { load: true, ..Schema::default() },
        joints: (0..movable).map(|k| (0..rows).map(|row| wave(k, row)).collect()).collect(),
        approach: vec![vec![0.0; rows]; movable],
        ..Dataset::default()
    };
    for row in 0..rows {
        data.position.push([0.3, if row % 7 == 0 { f64::NAN } else { -0.2 }, 0.5]);
        let turn = 0.5 * wave(3, row);
        data.orientation.push((row % 3 > 0).then(|| [turn.cos(), turn.sin(), 0.0, 0.0]));
        data.position_sd.push([f64::NAN; 3]);
        data.orientation_sd.push([f64::NAN; 3]);
        data.target.push((row % 2 == 0 && !chain.targets().is_empty()).then_some(TargetId(0)));
        data.visit.push(row);
        let payload = Payload { mass: 5.0 + row as f64, com: Vector3::new(0.1, 0.0, 0.2) };
        let wrench = Wrench { force: Vector3::new(1.0, -40.0, 3.0), moment: Vector3::new(0.5, 0.0, 2.0) };
        data.load.push(match row % 3 {
            0 => Load::None,
            1 => Load::Payload(payload),
            _ => Load::Wrench(wrench),
        });
        data.time.push(0.0);
    }
    let tools: Vec<ToolId> = (0..rows).map(|row| ToolId(row / 3 % chain.tools().len())).collect();
    data.set_tools(chain, &tools);
    data
}

/// Every number of a block against that of one row after the other.
fn check(model: &ErrorModel, data: &Dataset, coefficients: &[f64], arch: Arch) {
    let chain = model.chain();
    let rows: Vec<usize> = (0..data.len()).collect();
    let places: Vec<Option<usize>> = (0..model.columns().len()).map(Some).collect();
    let mut lanes = Lanes::new(model.bind(&data.schema).unwrap()).on(arch);
    lanes.gather(data, &rows);
    lanes.settle(data, coefficients);
    let mut weights = vec![0.0; 6 * LANES];
    for &row in &rows {
        let seen = data.seen(row);
        for k in 0..6 {
            let seen = if k < 3 { seen.position[k] } else { seen.orientation };
            weights[k * LANES + row] = if seen { 2.0 } else { 0.0 };
        }
    }
    lanes.columns(data, &weights, &places);
    let change: Vec<f64> = model.columns().iter().map(|column| 1e-3 * column.scale).collect();
    let mut left = vec![0.0; 6 * LANES];
    lanes.left(data, &change, &mut left);
    let bound = model.bind(&data.schema).unwrap();
    let mut rest = Equilibrium::new(model);
    for row in rows {
        let conditions = data.conditions(row);
        rest.settle(&bound, &conditions, coefficients);
        let jacobian = ErrorJacobian::new(chain, rest.real(), rest.errors(), data.aim(row));
        let mut want = vec![[0.0; 6]; model.columns().len() + 1];
        for entry in rest.emission().entries() {
            let (p, r) = (jacobian.position(entry.site), jacobian.rotation(entry.site));
            let p = data.ray(row).map_or(p, |w| Vector3::new(w.dot(&p), 0.0, 0.0));
            for k in 0..3 {
                want[entry.column][k] += 2.0 * entry.value * p[k];
                want[entry.column][k + 3] += 2.0 * entry.value * r[k];
            }
        }
        let away = data.measured_position(row) - jacobian.point();
        let away = data.ray(row).map_or(away, |w| Vector3::new(w.dot(&away), 0.0, 0.0));
        let last = want.len() - 1;
        (0..3).for_each(|k| want[last][k] = 2.0 * away[k]);
        if let Some(measured) = data.measured_rotation(row) {
            let turn = rotation_log(&(measured * rest.real().tool().rotation.transpose()));
            (0..3).for_each(|k| want[last][k + 3] = 2.0 * turn[k]);
        }
        for k in 0..6 {
            let found = lanes.component(k);
            let mut have = vec![0.0; want.len()];
            for (slot, &column) in found.active.iter().chain([&last]).enumerate() {
                have[column] = found.numbers.get(slot * LANES + row).copied().unwrap_or(0.0);
            }
            if weights[k * LANES + row] != 0.0 {
                let moved: f64 = want.iter().zip(&change).map(|(a, d)| 0.5 * a[k] * d).sum();
                let (want, have) = (0.5 * want[last][k] - moved, left[k * LANES + row]);
                assert!(
                    (want - have).abs() < 1e-11,
                    "{} row {row} component {k}: {want} {have}",
                    chain.name()
                );
            }
            for (column, (want, have)) in want.iter().zip(have).enumerate() {
                let want = if weights[k * LANES + row] == 0.0 { 0.0 } else { want[k] };
                // Rows follow the levers of weights to the fourth power of an angle, blocks exactly.
                let still = coefficients.iter().all(|&c| c == 0.0);
                let close = (want - have).abs() <= if still { 1e-12 } else { 1e-10 } * (1.0 + want.abs());
                assert!(close, "{} row {row} component {k} column {column}: {want} {have}", chain.name());
            }
        }
    }
}

fn models(chain: &Chain) -> Vec<ErrorModel> {
    let spring = |frame: usize, component: usize, axis: Axis| Expansion {
        at: Place::Frame { frame: FrameId(frame), components: vec![axis] },
        factors: vec![Factor {
            of: Input::Wrench { frame: FrameId(frame), component },
            basis: Basis::Powers(vec![1]),
        }],
    };
    let mut physics: Vec<Box<dyn AnyEffect>> = vec![
        Box::new(Geometric::default()),
        Box::new(BaseCompliance::default()),
        Box::new(spring(2, 1, Axis::Ty)),
        Box::new(spring(3, 5, Axis::Rz)),
        Box::new(JointCompliance::default()),
        Box::new(LinkCompliance::default()),
    ];
    let slides = chain.movable().iter().filter(|&&j| chain.joint(j).kind == JointKind::Prismatic);
    physics.extend(slides.map(|&joint| Box::new(Guideway::of(joint)) as Box<dyn AnyEffect>));
    let beams = |section, own_weight| -> Vec<Box<dyn AnyEffect>> {
        let links = LinkCompliance { section, own_weight, ..LinkCompliance::default() };
        vec![Box::new(Geometric::default()), Box::new(links)]
    };
    let effects: [Vec<Box<dyn AnyEffect>>; 8] = [
        physics,
        vec![Box::new(Geometric::default())],
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())],
        vec![Box::new(Polynomial::of(2, vec![WrenchComponent::Fy, WrenchComponent::Mx]))],
        vec![
            Box::new(Geometric::default()),
            Box::new(LinkCompliance::default()),
            Box::new(Transmission::of(JointId(chain.movable()[0].0), 0.3)),
        ],
        beams(Section::Tube, OwnWeight::Declared),
        beams(Section::Symmetric, OwnWeight::Free),
        beams(Section::General, OwnWeight::Free),
    ];
    effects.into_iter().map(|effects| ErrorModel::new(chain.clone(), effects).unwrap()).collect()
}

/// Rows that measured one number beside rows that measured a pose.
#[test]
fn rows_along_a_direction_agree_with_single_rows() {
    for chain in [samples::ur10(), samples::heavy(), samples::pps()] {
        let mut data = data(&chain, 20);
        let ray = |row: usize| {
            let turn = row as f64;
            row.is_multiple_of(3).then(|| Ray {
                direction: Vector3::new(turn.cos(), turn.sin(), 0.3) * 0.7,
                position: Vector3::new(0.4, 0.01 * turn, 0.2),
                sensor: Some(row % 2),
                own: vec![0.3 + turn, -1.0],
            })
        };
        let rays: Vec<Option<Ray>> = (0..data.len()).map(ray).collect();
        for (row, ray) in rays.iter().enumerate() {
            if ray.is_some() {
                data.orientation[row] = None;
            }
        }
        data.set_rays(Some(&rays));
        let unknown = |name: &str| Unknown { name: name.into(), unit: "m".into(), scale: 0.01 };
        let sensor = |name: &str| Sensor {
            name: name.into(),
            unknowns: vec![unknown(name), unknown(&(name.to_owned() + "2"))],
        };
        let observed = Observed { sensors: vec![sensor("a"), sensor("b")] };
        let effects: Vec<Box<dyn AnyEffect>> =
            vec![Box::new(Geometric::default()), Box::new(JointCompliance::default()), Box::new(observed)];
        let model = ErrorModel::new(chain.clone(), effects).unwrap();
        for size in [0.0, 0.1] {
            let coefficients: Vec<f64> = model.columns().iter().map(|column| size * column.scale).collect();
            levels().into_iter().for_each(|arch| check(&model, &data, &coefficients, arch));
            // Every other effect moves nothing: it is asked where the robot has come to rest.
            let mut some = coefficients;
            (0..model.effects().len()).step_by(2).for_each(|effect| some[model.columns_of(effect)].fill(0.0));
            check(&model, &data, &some, Arch::new());
        }
    }
}

/// Rows of two points that met beside rows of one: either arm first, with and without a direction, targets and origins of tools.
#[test]
fn rows_of_two_points_agree_with_single_rows() {
    let chain = samples::dual();
    let left = |row: usize| chain.targets().iter().position(|t| t.tool == ToolId(row % 2)).map(TargetId);
    let mut data = data(&chain, 24);
    let tools: Vec<ToolId> = (0..data.len()).map(|row| ToolId((row + 1) % 2)).collect();
    let mut met = vec![None; data.len()];
    let mut rays = vec![None; data.len()];
    for row in (0..data.len()).filter(|row| row % 5 != 0) {
        data.orientation[row] = None;
        data.target[row] = left(row + 1).filter(|_| row % 2 == 0);
        met[row] = match left(row).filter(|_| row % 3 != 0) {
            Some(target) => Some(RobotPoint::Target(target)),
            None => Some(RobotPoint::Tool(ToolId(row % 2))),
        };
        rays[row] = (row % 4 == 0).then(|| Ray {
            direction: Vector3::new(0.6, -0.3, 0.2 + 0.01 * row as f64),
            position: Vector3::new(0.1, 0.2, -0.1),
            sensor: None,
            own: Vec::new(),
        });
    }
    data.set_tools(&chain, &tools);
    data.set_rays(Some(&rays));
    data.set_meets(Some(&met));
    for model in models(&chain) {
        for size in [0.0, 0.03] {
            let coefficients: Vec<f64> = model.columns().iter().map(|column| size * column.scale).collect();
            levels().into_iter().for_each(|arch| check(&model, &data, &coefficients, arch));
        }
    }
}

#[test]
fn a_block_says_what_its_rows_say_on_every_level_of_the_processor() {
    let levels = levels();
    for chain in samples::all().into_iter().chain([samples::dual()]) {
        let data = data(&chain, 21);
        for model in models(&chain) {
            let zero = vec![0.0; model.columns().len()];
            let some: Vec<f64> = model.columns().iter().map(|column| 0.03 * column.scale).collect();
            for &arch in &levels {
                check(&model, &data, &zero, arch);
                check(&model, &data, &some, arch);
            }
        }
    }
}

#[test]
fn what_is_zero_is_left_out() {
    let chain = samples::pps();
    let model = ErrorModel::new(chain.clone(), vec![Box::new(Geometric::default())]).unwrap();
    let data = data(&chain, 5);
    let mut lanes = Lanes::new(model.bind(&data.schema).unwrap());
    lanes.gather(&data, &[0, 1, 2, 3, 4]);
    let columns = model.columns().len();
    lanes.settle(&data, &vec![0.0; columns]);
    let places: Vec<Option<usize>> = (0..columns).map(Some).collect();
    lanes.columns(&data, &[1.0; 6 * LANES], &places);
    for k in 0..6 {
        let component = lanes.component(k);
        assert!(component.active.len() < columns - 6, "{k}: {}", component.active.len());
        for (slot, column) in component.active.iter().enumerate() {
            let numbers = &component.numbers[slot * LANES..][..5];
            assert!(numbers.iter().any(|v| *v != 0.0), "column {column} of {k}");
        }
    }
}

#[test]
fn rows_of_one_standstill_say_what_each_says_by_itself() {
    for chain in samples::all().into_iter().chain([samples::dual()]) {
        // Three rows a standstill, of which each is seen in its own way; one stands alone.
        let mut data = data(&chain, 22);
        let first = |row: usize| row - row % 3;
        data.joints.iter_mut().for_each(|joint| (0..21).for_each(|row| joint[row] = joint[first(row)]));
        (0..21).for_each(|row| data.load[row] = data.load[first(row)]);
        for model in models(&chain) {
            let zero = vec![0.0; model.columns().len()];
            let some: Vec<f64> = model.columns().iter().map(|column| 0.03 * column.scale).collect();
            check(&model, &data, &zero, Arch::new());
            check(&model, &data, &some, Arch::new());
            // From row to row nothing is left behind of a block that shared.
            let mut used = Lanes::new(model.bind(&data.schema).unwrap());
            let all: Vec<usize> = (0..22).collect();
            let apart: Vec<usize> = (0..22).step_by(3).collect();
            for rows in [&all, &apart, &all] {
                let have = left(&mut used, &data, rows, &some);
                let fresh = left(&mut Lanes::new(model.bind(&data.schema).unwrap()), &data, rows, &some);
                for (have, fresh) in have.chunks_exact(LANES).zip(fresh.chunks_exact(LANES)) {
                    assert_eq!(have[..rows.len()], fresh[..rows.len()], "{}", chain.name());
                }
            }
        }
    }
}

/// Residuals of a block after a change, from memory that has seen other blocks or none.
fn left(lanes: &mut Lanes<'_>, data: &Dataset, rows: &[usize], coefficients: &[f64]) -> Vec<f64> {
    let mut into = vec![0.0; 6 * LANES];
    lanes.gather(data, rows);
    lanes.settle(data, coefficients);
    lanes.left(data, &vec![0.0; coefficients.len()], &mut into);
    into
}

#[test]
fn measured_wrenches_need_no_weights_and_payloads_behind_them_do() {
    let chain = samples::pps();
    let polynomial = Polynomial::of(2, vec![WrenchComponent::Fy, WrenchComponent::Mx]);
    let model = ErrorModel::new(chain.clone(), vec![Box::new(polynomial)]).unwrap();
    let data = data(&chain, 30);
    // Rows of `data` in turn: nothing, a payload, a measured wrench.
    let of = |kind: usize| (0..30).filter(|row| row % 3 == kind).collect::<Vec<_>>();
    let some: Vec<f64> = model.columns().iter().map(|column| 0.1 * column.scale).collect();
    let bound = model.bind(&data.schema).unwrap();
    let mut used = Lanes::new(bound.clone());
    for kind in [2, 1, 2, 0, 1, 1, 2] {
        let rows = of(kind);
        let have = left(&mut used, &data, &rows, &some);
        assert_eq!(have, left(&mut Lanes::new(bound.clone()), &data, &rows, &some), "{kind}");
        let mut rest = Equilibrium::new(&model);
        for (lane, &row) in rows.iter().enumerate() {
            rest.settle(&bound, &data.conditions(row), &some);
            let jacobian = ErrorJacobian::new(&chain, rest.real(), rest.errors(), data.target[row]);
            let want = data.measured_position(row) - jacobian.point();
            for k in (0..3).filter(|&k| !want[k].is_nan()) {
                // Levers to the fourth power of an angle, as above; m.
                assert!((have[k * LANES + lane] - want[k]).abs() < 1e-11, "{kind} {row} {k}");
            }
        }
    }
}
