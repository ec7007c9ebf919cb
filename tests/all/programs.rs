//! Robot programs with compensated points, executed by the true simulated robot: it ends where the commands of a table bring it.
//!
//! The controller is plain code here: it reads the point again, and turns a pose into joints by Newton's method on its nominal robot, from
//! the joints that the correction states.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;
use truepose_compensate::{Compensator, CompensatorOptions, Status, Target, installation};
use truepose_controllers::{CorrectOptions, Dialect, Outcome, Program, Value, correct};
use truepose_errormodel::effects::{Geometric, JointCompliance};
use truepose_errormodel::{AnyEffect, ErrorModel, FittedModel, Schema};
use truepose_identify::{FitOptions, fit};
use truepose_kinematics::{Chain, Conditions, Placement, Pose, rotation_log, samples};
use truepose_simulate::{Campaign, Plant, PlantDescription, PlantOptions};
use truepose_solvers::PivotedQr;

/// A heavy arm; with ABB's and FANUC's zero (upper arm upright) or with KUKA's (stretched out).
pub fn arm(upright: bool) -> Chain {
    let heavy = samples::heavy();
    if !upright {
        return heavy;
    }
    let shift = [0.0, -FRAC_PI_2, FRAC_PI_2, 0.0, 0.0, 0.0];
    let joints = heavy.joints().iter().zip(shift).map(|(joint, shift)| {
        let mut joint = joint.clone();
        if let Placement::Mdh { theta, .. } = &mut joint.placement {
            *theta += shift;
        }
        joint.limits = joint.limits.map(|(lower, upper)| (lower - shift, upper - shift));
        joint
    });
    let chain = Chain::new("upright", joints.collect()).and_then(|chain| chain.with_base(*heavy.base()));
    chain.and_then(|chain| chain.with_tool(*heavy.tool())).expect("an arm")
}

pub fn plant(chain: &Chain) -> Plant {
    let mut text = String::from(
        "[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.3\n[instrument]\nsd_um = 10\norientation_urad = 20\n\
         [repeatability]\nsd_um = 20\n",
    );
    for &joint in chain.movable() {
        let _ = writeln!(
            text,
            "[[errors.joint_compliance]]\njoint = \"{}\"\nstiffness = 3e6",
            chain.joint(joint).name
        );
    }
    let PlantDescription { errors, shop, instrument, repeatability, .. } =
        PlantDescription::from_toml(&text).expect("a description");
    Plant::random(chain, &PlantOptions { errors, shop, instrument, repeatability }, 3).expect("a plant")
}

pub fn identified(plant: &Plant) -> FittedModel {
    let campaign = Campaign::random(plant.chain(), 250, 11).expect("a campaign").shuffled(5);
    identified_from(plant, &campaign)
}

pub fn identified_from(plant: &Plant, campaign: &Campaign) -> FittedModel {
    let chain = plant.chain();
    let data = plant.measure(campaign, 7).expect("data");
    let effects: Vec<Box<dyn AnyEffect>> =
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())];
    let model = ErrorModel::new(chain.clone(), effects).expect("a model");
    fit(&model, &data, &PivotedQr::default(), &FitOptions::default()).expect("a fit").fitted
}

fn frame() -> Pose {
    Pose::from_xyz_rpy([1.2, -0.3, 0.4], [0.1, -0.2, 0.7])
}

fn tool() -> Pose {
    Pose::from_xyz_rpy([0.02, -0.05, 0.18], [0.3, 0.4, -0.2])
}

/// The controller's nominal flange in its base.
pub fn flange(chain: &Chain, joints: &[f64]) -> Pose {
    chain.base().pose.inverse() * chain.forward(joints) * chain.tool().pose.inverse()
}

/// Joints for which a pose of them is the wanted one, by Newton's method from `start`; those that are not `free` keep their values.
pub fn solved(pose: impl Fn(&[f64]) -> Pose, wanted: &Pose, start: &[f64], free: &[usize]) -> Vec<f64> {
    let mut joints = start.to_vec();
    let gap = |joints: &[f64]| {
        let at = pose(joints);
        let turn = rotation_log(&(wanted.rotation * at.rotation.transpose()));
        let shift = wanted.translation - at.translation;
        DVector::from_iterator(6, shift.iter().chain(turn.iter()).copied())
    };
    for _ in 0..15 {
        let mut jacobian = DMatrix::zeros(6, 6);
        for (column, &k) in free.iter().enumerate() {
            let (mut plus, mut minus) = (joints.clone(), joints.clone());
            plus[k] += 1e-5;
            minus[k] -= 1e-5;
            jacobian.set_column(column, &((gap(&minus) - gap(&plus)) / 2e-5));
        }
        let step = jacobian.lu().solve(&gap(&joints)).expect("a regular posture");
        free.iter().zip(step.iter()).for_each(|(&k, step)| joints[k] += step);
    }
    assert!(gap(&joints).norm() < 1e-8, "the pose is reached");
    joints
}

/// Postures well inside of the range of the data, with the elbow and the wrist on either side of their singularities.
fn postures(upright: bool) -> Vec<Vec<f64>> {
    let mut list = Vec::new();
    for k in 0..60 {
        let part = |n: usize| ((k * n) % 60) as f64 / 60.0 - 0.5;
        let side = if k % 2 == 0 { 1.0 } else { -1.0 };
        let mut joints = vec![
            2.6 * part(7),
            -1.1 + 1.0 * part(11),
            1.2 + 0.7 * part(13),
            2.4 * part(17) + 0.3,
            side * (0.9 + 0.8 * part(19)),
            2.8 * part(23) + 0.2,
        ];
        if upright {
            joints[1] += FRAC_PI_2;
            joints[2] -= FRAC_PI_2;
        }
        list.push(joints);
    }
    list
}

fn degrees(joints: &[f64]) -> Vec<f64> {
    joints.iter().map(|joint| joint.to_degrees()).collect()
}

/// Millimetres and degrees about fixed axes x, y, z.
fn numbers(pose: &Pose) -> ([f64; 3], [f64; 3]) {
    ((pose.translation * 1e3).into(), pose.rpy().map(f64::to_degrees))
}

/// A program that goes to these postures: odd ones as poses of `tool` in `frame`, even ones as joints.
fn written(dialect: Dialect, chain: &Chain, list: &[Vec<f64>]) -> String {
    let mut text = String::new();
    let mut head = String::new();
    let mut moves = String::new();
    let quadrant = |angle: f64| (angle / 90.0).floor() as i64;
    let (f, t) = (frame(), tool());
    let ((fx, fr), (tx, tr)) = (numbers(&f), numbers(&t));
    for (k, joints) in list.iter().enumerate() {
        let pose = f.inverse() * flange(chain, joints) * t;
        let ([x, y, z], [roll, pitch, yaw]) = numbers(&pose);
        let q = degrees(joints);
        let joined = |values: &[f64]| values.iter().map(|v| format!("{v:.6}")).collect::<Vec<_>>().join(",");
        let as_pose = k % 2 == 1;
        match dialect {
            Dialect::Krl if as_pose => {
                let turn: i64 = q.iter().enumerate().map(|(k, v)| i64::from(*v < 0.0) << k).sum();
                let status = 2 + 4 * i64::from(q[4] < 0.0);
                let _ = writeln!(
                    text,
                    "LIN {{X {x:.5},Y {y:.5},Z {z:.5},A {yaw:.6},B {pitch:.6},C {roll:.6},S {status},T {turn}}}"
                );
            }
            Dialect::Krl => {
                let list: Vec<String> =
                    q.iter().enumerate().map(|(k, v)| format!("A{} {v:.6}", k + 1)).collect();
                let _ = writeln!(text, "PTP {{{}}}", list.join(","));
            }
            Dialect::Rapid if as_pose => {
                let [w, i, j, l] = pose.quaternion();
                let cf = [0, 3, 5].map(|k| quadrant(q[k]).to_string()).join(",");
                let _ = writeln!(
                    text,
                    "MoveL [[{x:.5},{y:.5},{z:.5}],[{w:.9},{i:.9},{j:.9},{l:.9}],[{cf},{}],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,t1\\WObj:=w1;",
                    i64::from(q[4] < 0.0)
                );
            }
            Dialect::Rapid => {
                let _ = writeln!(text, "MoveAbsJ [[{}],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,t1;", joined(&q));
            }
            Dialect::Fanuc => {
                let _ = writeln!(moves, "{:4}:L P[{}] 100mm/sec FINE    ;", k + 1, k + 1);
                if as_pose {
                    let letter = if q[4] < 0.0 { 'N' } else { 'F' };
                    let _ = writeln!(
                        text,
                        "P[{}]{{\n   GP1:\n\tUF : 1, UT : 2,\t\tCONFIG : '{letter} U T, 0, 0, 0',\n\tX = {x:9.3}  mm,\tY = {y:9.3}  mm,\tZ = {z:9.3}  mm,\n\
                         \tW = {roll:9.3} deg,\tP = {pitch:9.3} deg,\tR = {yaw:9.3} deg\n}};",
                        k + 1
                    );
                } else {
                    let list: Vec<String> =
                        q.iter().enumerate().map(|(k, v)| format!("\tJ{}= {v:9.3} deg", k + 1)).collect();
                    let _ = writeln!(
                        text,
                        "P[{}]{{\n   GP1:\n\tUF : 0, UT : 2,\t\n{}\n}};",
                        k + 1,
                        list.join(",")
                    );
                }
            }
            Dialect::UrScript if as_pose => {
                let v = rotation_log(&pose.rotation);
                let p = pose.translation;
                let near = joined(joints);
                let _ = writeln!(
                    text,
                    "movej(get_inverse_kin(pose_trans(part, p[{:.7},{:.7},{:.7},{:.7},{:.7},{:.7}]), qnear=[{near}]))",
                    p.x, p.y, p.z, v.x, v.y, v.z
                );
            }
            Dialect::UrScript => {
                let _ = writeln!(text, "movej([{}])", joined(joints));
            }
            Dialect::Inform => {
                let _ = writeln!(moves, "MOVL C{k:05} V=93.0");
                if as_pose {
                    let _ = writeln!(
                        text,
                        "///POSTYPE USER\n///RECTAN\n///RCONF 0,0,0\nC{k:05}={x:.3},{y:.3},{z:.3},{roll:.4},{pitch:.4},{yaw:.4}"
                    );
                } else {
                    let pulses: Vec<String> = q.iter().map(|v| format!("{:.0}", 10_000.0 * v)).collect();
                    let _ = writeln!(text, "///POSTYPE PULSE\n///PULSE\nC{k:05}={}", pulses.join(","));
                }
            }
            Dialect::Val3 => {
                let list: Vec<String> =
                    q.iter().enumerate().map(|(k, v)| format!("j{}=\"{v:.6}\"", k + 1)).collect();
                if as_pose {
                    let [a, b, c] =
                        Pose::new(pose.rotation.transpose(), Vector3::zeros()).rpy().map(|v| -v.to_degrees());
                    let _ = writeln!(
                        text,
                        "<Data name=\"p{k}\" type=\"pointRx\"><Value key=\"0\" x=\"{x:.4}\" y=\"{y:.4}\" z=\"{z:.4}\" rx=\"{a:.5}\" ry=\"{b:.5}\" rz=\"{c:.5}\" fatherId=\"part[0]\"/></Data>"
                    );
                } else {
                    let _ = writeln!(
                        text,
                        "<Data name=\"j{k}\" type=\"jointRx\"><Value key=\"0\" {}/></Data>",
                        list.join(" ")
                    );
                }
            }
        }
    }
    let krl = |at: [f64; 3], turn: [f64; 3]| {
        format!("{{X {},Y {},Z {},A {},B {},C {}}}", at[0], at[1], at[2], turn[2], turn[1], turn[0])
    };
    let rapid = |pose: &Pose| {
        let ([x, y, z], q) = (numbers(pose).0, pose.quaternion());
        format!("[[{x},{y},{z}],[{},{},{},{}]]", q[0], q[1], q[2], q[3])
    };
    let script = |pose: &Pose| {
        let (p, v) = (pose.translation, rotation_log(&pose.rotation));
        format!("p[{},{},{},{},{},{}]", p.x, p.y, p.z, v.x, v.y, v.z)
    };
    match dialect {
        Dialect::Krl => head = format!("DEF a()\n$BASE={}\n$TOOL={}\n{text}END\n", krl(fx, fr), krl(tx, tr)),
        Dialect::Rapid => {
            head = format!(
                "MODULE m\nPERS wobjdata w1:=[FALSE,TRUE,\"\",{},[[0,0,0],[1,0,0,0]]];\nPERS tooldata t1:=[TRUE,{},[1,[0,0,1],[1,0,0,0],0,0,0]];\nPROC main()\n{text}ENDPROC\nENDMODULE\n",
                rapid(&f),
                rapid(&t)
            );
        }
        Dialect::Fanuc => head = format!("/PROG A\n/MN\n{moves}/POS\n{text}/END\n"),
        Dialect::UrScript => {
            head = format!("def a():\nset_tcp({})\npart={}\n{text}end\n", script(&t), script(&f));
        }
        Dialect::Inform => {
            head = format!("/JOB\n//NAME A\n//POS\n///USER 1\n///TOOL 2\n{text}//INST\nNOP\n{moves}END\n");
        }
        Dialect::Val3 => {
            let [a, b, c] =
                Pose::new(f.rotation.transpose(), Vector3::zeros()).rpy().map(|v| -v.to_degrees());
            let _ = writeln!(
                head,
                "<Database><Datas>\n<Data name=\"part\" type=\"frame\"><Value key=\"0\" x=\"{}\" y=\"{}\" z=\"{}\" rx=\"{a}\" ry=\"{b}\" rz=\"{c}\" fatherId=\"world[0]\"/></Data>\n{text}</Datas></Database>",
                fx[0], fx[1], fx[2]
            );
        }
    }
    head
}

/// Root mean square of the miss: of the program's points, of commands without a program, and without compensation, m.
fn misses(dialect: Dialect, plant: &Plant, fitted: &FittedModel) -> (f64, f64, f64) {
    let chain = plant.chain();
    let upright = chain.name() == "upright";
    let list = postures(upright);
    // Without configuration data a pose follows its neighbour: pairs of postures that are near each other.
    let list: Vec<Vec<f64>> = if matches!(dialect, Dialect::Inform | Dialect::Val3) {
        list.iter()
            .step_by(2)
            .flat_map(|joints| [joints.clone(), joints.iter().map(|joint| joint + 0.08).collect()])
            .collect()
    } else {
        list
    };
    let text = written(dialect, chain, &list);
    let mut options = CorrectOptions { limit: 0.02, ..CorrectOptions::default() };
    match dialect {
        Dialect::Fanuc => {
            options.frames = vec![("UF1".into(), frame())];
            options.tools = vec![("UT2".into(), tool())];
        }
        Dialect::Inform => {
            (options.frame, options.tool) = (Some(frame()), Some(tool()));
            options.pulses = Some(vec![10_000f64.to_degrees(); 6]);
        }
        Dialect::Val3 => options.tool = Some(tool()),
        _ => {}
    }
    let program = Program::read(text.as_bytes(), &[], dialect).expect("a program");
    let corrections = correct(&program, fitted, &options).expect("corrections");
    let new: Vec<_> = corrections.iter().map(|correction| correction.replacement.clone()).collect();
    let out = program.rewritten(&new).expect("a program");
    let again = Program::read(&out, &[], dialect).expect("a program");
    let found = installation(fitted).expect("an installation");
    let schema = Schema { load: true, ..Schema::default() };
    let mut table = Compensator::bind(fitted, &schema, CompensatorOptions::default()).expect("a compensator");
    let (mut of_program, mut of_table, mut before, mut count) = (0.0, 0.0, 0.0, 0.0);
    for (k, (correction, point)) in corrections.iter().zip(again.points()).enumerate() {
        if correction.outcome != Outcome::Corrected {
            let reason = &correction.reason;
            assert!(
                reason.contains("singularity") || reason.contains("data of the fit"),
                "{dialect:?} {k}: {reason}"
            );
            continue;
        }
        let nominal = correction.nominal.as_deref().expect("joints");
        let off = nominal.iter().zip(&list[k]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-3, "{dialect:?} {k}: {nominal:?} instead of {:?}", list[k]);
        let corrected = correction.corrected.as_deref().expect("joints");
        let joints = match &point.value {
            Value::Joints(values) if dialect == Dialect::Inform => {
                values.iter().map(|v| (v / 10_000.0).to_radians()).collect()
            }
            Value::Joints(values) => values.iter().map(|v| v * dialect.angle()).collect(),
            Value::Pose { pose, .. } => solved(
                |q| flange(chain, q),
                &(frame() * *pose * tool().inverse()),
                corrected,
                &[0, 1, 2, 3, 4, 5],
            ),
        };
        let desired = found.base * flange(chain, nominal) * found.tool;
        let target = Target::at(desired.translation).turned(desired.rotation);
        let command = table.command(&target, &Conditions::at(chain, nominal), Some(nominal));
        assert_eq!(command.status, Status::Ok);
        let miss = |joints: &[f64]| {
            let there = plant.true_position(&Conditions::at(chain, joints), None).expect("a position");
            (there - desired.translation).norm_squared()
        };
        of_program += miss(&joints);
        of_table += miss(&command.joints);
        before += miss(nominal);
        count += 1.0;
    }
    assert!(count > 0.7 * list.len() as f64, "{dialect:?}: {count} of {}", list.len());
    let rms = |sum: f64| f64::sqrt(sum / count);
    (rms(of_program), rms(of_table), rms(before))
}

#[track_caller]
fn check(upright: bool, dialects: &[Dialect]) {
    let plant = plant(&arm(upright));
    let fitted = identified(&plant);
    for &dialect in dialects {
        let (program, table, before) = misses(dialect, &plant, &fitted);
        println!("{dialect:?}: before {before:e}, table {table:e}, program {program:e} m");
        assert!(before > 5.0 * table, "{dialect:?}: {before:e} m before, {table:e} m after");
        // Three decimals of a degree (5 µrad, standard deviation), and whole pulses, are coarser than the model: six joints of which each
        // moves the arm's end by its 1.6 m at most.
        let digits = match dialect {
            Dialect::Fanuc | Dialect::Inform => 6f64.sqrt() * 1.6 * 1e-3f64.to_radians() / 12f64.sqrt(),
            _ => 0.0,
        };
        assert!(
            program <= (1.05 * table).hypot(digits),
            "{dialect:?}: {program:e} m, the table's commands {table:e} m, digits {digits:e} m"
        );
    }
}

#[test]
fn programs_of_a_controller_with_the_arm_stretched_at_zero_end_where_commands_do() {
    check(false, &[Dialect::Krl, Dialect::UrScript, Dialect::Inform, Dialect::Val3]);
}

#[test]
fn programs_of_a_controller_with_the_arm_upright_at_zero_end_where_commands_do() {
    check(true, &[Dialect::Rapid, Dialect::Fanuc]);
}

/// Unused rotations do not hide behind the identity.
#[test]
fn frame_and_tool_of_the_test_are_turned() {
    for pose in [frame(), tool()] {
        assert!((pose.rotation - Matrix3::identity()).norm() > 0.3);
    }
}
