//! W6: 100 000 commands that bring an elastic 6R arm to within 0.1 µm of desired poses.

use crate::prelude::*;
use truepose_compensate::{Command, CommandRequest, Compensator, CompensatorOptions, Status, Target};
use truepose_kinematics::rotation_log;

/// As the program takes them.
const TOGETHER: usize = 64;
/// 0.1 µm, 0.1 µrad.
const TOLERANCE: f64 = 1e-7;

/// The peers' errors behind each joint, and its compliances.
fn fitted(folder: &Path) -> Outcome<FittedModel> {
    let chain = robot(&folder.join("arm6r.json"))?;
    let (errors, yields) =
        (Table::read(&folder.join("arm6r_errors.csv"))?, Table::read(&folder.join("arm6r_compliance.csv"))?);
    let model =
        ErrorModel::new(chain, vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())])?;
    let names = ["ex", "ey", "ez", "ep", "es", "er"]; // of x, y, z, rx, ry, rz
    let mut coefficients = Vec::new();
    let mut compliances = yields.column("compliance")?.iter();
    for column in model.columns() {
        let value = match column.site.map(|site| model.chain().site_index(site)) {
            Some(at) => errors.column(names[at % 6])?.get(at / 6),
            None => compliances.next(),
        };
        coefficients.push(*value.ok_or("an error for each column")?);
    }
    let p = coefficients.len();
    Ok(FittedModel::new(model, coefficients, DMatrix::zeros(p, p))?)
}

fn prepare(folder: &Path) -> Outcome<Way> {
    let fitted: &'static FittedModel = Box::leak(Box::new(fitted(folder)?));
    let data = rows_of(folder, "w6.csv")?;
    let conditions: Vec<Conditions> = (0..data.len()).map(|row| data.conditions(row)).collect();
    let target = |row| {
        let turned = data.measured_rotation(row).unwrap_or_default();
        Target::at(data.measured_position(row)).turned(turned)
    };
    let targets: Vec<Target> = (0..data.len()).map(target).collect();
    let schema = Schema { load: true, ..Schema::default() };
    let options = CompensatorOptions {
        position_tolerance: TOLERANCE,
        orientation_tolerance: TOLERANCE,
        ..CompensatorOptions::default()
    };
    let mut compensator = Compensator::bind(fitted, &schema, options)?;
    let state = Rc::new((targets, conditions, RefCell::new(Vec::new())));
    let kept = Rc::clone(&state);
    let mut commands: Vec<Command> = Vec::with_capacity(TOGETHER);
    let run = move || {
        let (targets, conditions, joints) = &*kept;
        let mut joints = joints.borrow_mut();
        joints.clear();
        let mut list = Vec::with_capacity(TOGETHER);
        for (targets, conditions) in targets.chunks(TOGETHER).zip(conditions.chunks(TOGETHER)) {
            list.clear();
            list.extend(targets.iter().zip(conditions).map(|(target, conditions)| CommandRequest {
                target: *target,
                conditions,
                seed: Some(&conditions.joints),
            }));
            commands.clear();
            compensator.commands(&list, &mut commands);
            for command in &commands {
                let mut q = [0.0; 6];
                q.copy_from_slice(&command.joints);
                joints.push((q, command.status == Status::Ok));
            }
        }
        Ok(())
    };
    let check = move || {
        let (targets, conditions, joints) = &*state;
        let (mut predictor, mut ok) = (fitted.bind(&schema)?, 0);
        let (mut position, mut turn) = (0.0, 0.0);
        for ((target, conditions), (q, said)) in targets.iter().zip(conditions).zip(&*joints.borrow()) {
            let pose = predictor.predict(&Conditions { joints: q.to_vec(), ..conditions.clone() }, None);
            let wanted = target.orientation.unwrap_or_default();
            let (p, r) = (
                (pose.translation - target.position).norm(),
                rotation_log(&(pose.rotation * wanted.transpose())).norm(),
            );
            ok += usize::from(*said && p < 1e-6 && r < 1e-6);
            (position, turn) = (f64::max(position, p), f64::max(turn, r));
        }
        Ok(Answer::from([
            ("ok".into(), ok as f64),
            ("max_pos_um".into(), 1e6 * position),
            ("max_rot_urad".into(), 1e6 * turn),
        ]))
    };
    Ok(Way { run: Box::new(run), check: Box::new(check) })
}

/// Compensated commands.
pub const W6: Workload = Workload::of(
    "W6",
    "100 000 commands to 0.1 µm, elastic 6R",
    [660e6, 0.0],
    &[("ok", 9)],
    &[Declared::of("list", &[("numba", 0.5)], prepare)],
);
