//! Which of the configurations that reach a pose a controller takes.

use std::f64::consts::FRAC_PI_2;
use truepose_controllers::{CorrectOptions, Correction, Dialect, Outcome, Program, correct_all};
use truepose_errormodel::{ErrorModel, FittedModel};
use truepose_kinematics::nalgebra::{DMatrix, Vector3};
use truepose_kinematics::{Chain, Joint, JointKind, Placement, Pose, samples};

/// An arm whose last three axes meet; all joints at zero: upper arm up, forearm in front.
pub fn arm() -> Chain {
    let turn = |name: &str, xyz: [f64; 3], rpy: [f64; 3], axis: Vector3<f64>, limit: f64| {
        let axis = truepose_kinematics::nalgebra::Unit::new_normalize(axis);
        let pose = Pose::from_xyz_rpy(xyz, rpy);
        Joint::new(name, JointKind::Revolute, Placement::Origin { pose, axis })
            .with_limits(-limit.to_radians(), limit.to_radians())
    };
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let joints = vec![
        turn("A1", [0.0, 0.0, 0.43], [0.0; 3], z, 175.0),
        turn("A2", [0.11, 0.0, 0.0], [0.0; 3], y, 115.0),
        turn("A3", [0.0, 0.0, 0.58], [0.0; 3], y, 160.0),
        turn("A4", [0.0, 0.0, 0.12], [0.0; 3], x, 190.0),
        turn("A5", [0.63, 0.0, 0.0], [0.0; 3], y, 125.0),
        turn("A6", [0.09, 0.0, 0.0], [0.0, FRAC_PI_2, 0.0], z, 355.0),
    ];
    Chain::new("arm", joints).expect("an arm")
}

fn corrections(
    chain: &Chain,
    dialect: Dialect,
    texts: &[&str],
    options: &CorrectOptions,
) -> Vec<Vec<Correction>> {
    let model = ErrorModel::new(chain.clone(), Vec::new()).expect("a model");
    let fitted = FittedModel::new(model, Vec::new(), DMatrix::zeros(0, 0)).expect("a fit");
    let texts: Vec<&[u8]> = texts.iter().map(|text| text.as_bytes()).collect();
    let programs = Program::read_all(&texts, dialect).expect("programs");
    correct_all(&programs, &fitted, options).expect("corrections")
}

/// Joints of each point of the first text, degrees; none with the reason.
fn joints(chain: &Chain, dialect: Dialect, texts: &[&str]) -> Vec<Result<Vec<f64>, String>> {
    let options = CorrectOptions { tool: Some(Pose::IDENTITY), ..CorrectOptions::default() };
    let one = |correction: &Correction| match &correction.nominal {
        Some(joints) => Ok(joints.iter().map(|joint| joint.to_degrees()).collect()),
        None => Err(correction.reason.clone()),
    };
    corrections(chain, dialect, texts, &options)[0].iter().map(one).collect()
}

#[track_caller]
fn near(found: &Result<Vec<f64>, String>, wanted: [f64; 6]) {
    let found = found.as_ref().expect("joints");
    assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 0.01), "{found:?} {wanted:?}");
}

fn pose(chain: &Chain, degrees: [f64; 6]) -> Pose {
    chain.forward(&degrees.map(f64::to_radians))
}

/// A robtarget with this confdata.
fn target(chain: &Chain, degrees: [f64; 6], config: &str) -> String {
    let pose = pose(chain, degrees);
    let [x, y, z] = [0, 1, 2].map(|k| 1e3 * pose.translation[k]);
    let [a, b, c, d] = pose.quaternion();
    format!("[[{x:.6},{y:.6},{z:.6}],[{a:.9},{b:.9},{c:.9},{d:.9}],[{config}],[9E9,9E9,9E9,9E9,9E9,9E9]]")
}

fn frame(chain: &Chain, degrees: [f64; 6], more: &str) -> String {
    let pose = pose(chain, degrees);
    let [x, y, z] = [0, 1, 2].map(|k| 1e3 * pose.translation[k]);
    let [c, b, a] = pose.rpy().map(f64::to_degrees);
    format!("{{X {x:.6},Y {y:.6},Z {z:.6},A {a:.7},B {b:.7},C {c:.7}{more}}}")
}

fn script(pose: &Pose) -> String {
    let turn = truepose_kinematics::rotation_log(&pose.rotation);
    let [x, y, z] = [0, 1, 2].map(|k| pose.translation[k]);
    format!("p[{x:.9},{y:.9},{z:.9},{:.9},{:.9},{:.9}]", turn.x, turn.y, turn.z)
}

const START: &str = "MoveAbsJ [[5,10,5,0,40,10],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n";
const FLIPPED: [f64; 6] = [20.0, 15.0, 10.0, -150.0, -40.0, 160.0];
const DIRECT: [f64; 6] = [20.0, 15.0, 10.0, 30.0, 40.0, -20.0];

#[test]
fn confdata_counts_where_its_control_is_on() {
    let chain = arm();
    let job = |control: &str, verb: &str, config: &str| {
        let point = target(&chain, FLIPPED, config);
        format!(
            "MODULE M\nPROC main()\n{control}{START}{verb} {point},v100,fine,tool0;\nENDPROC\nENDMODULE\n"
        )
    };
    let run = |text: &str| joints(&chain, Dialect::Rapid, &[text])[1].clone();
    near(&run(&job("", "MoveJ", "0,-2,1,1")), FLIPPED);
    near(&run(&job("", "MoveL", "0,-2,1,1")), FLIPPED);
    for (control, verb) in
        [("ConfJ\\Off;\n", "MoveJ"), ("ConfL \\Off;\n", "MoveL"), ("ConfL\\Off;\n", "ArcL")]
    {
        let job = job(control, verb, "7,-2,1,1").replace(
            "v100,fine,tool0;\nENDPROC",
            if verb == "ArcL" {
                "v100,seam1,weld1,fine,tool0;\nENDPROC"
            } else {
                "v100,fine,tool0;\nENDPROC"
            },
        );
        near(&run(&job), DIRECT);
    }
    // The control of the other motion is still on.
    let reason = run(&job("ConfJ\\Off;\n", "MoveL", "3,3,3,6")).unwrap_err();
    assert!(reason.contains("in the configuration that it states"), "{reason}");
    assert!(run(&job("ConfJ\\Off;\nConfJ\\On;\n", "MoveJ", "3,3,3,6")).is_err());
}

#[test]
fn control_that_is_off_is_off_in_routines_that_are_called() {
    let chain = arm();
    let point = target(&chain, FLIPPED, "0,0,0,0");
    let (first, last) = (format!("PROC path()\nMoveL {point},v100,fine,tool0;\nENDPROC\n"), START);
    for text in [
        format!("MODULE M\n{first}PROC main()\nConfL\\Off;\n{START}path;\n{last}ENDPROC\nENDMODULE\n"),
        format!("MODULE M\nPROC main()\nConfL\\Off;\n{START}path;\n{last}ENDPROC\n{first}ENDMODULE\n"),
    ] {
        let all = joints(&chain, Dialect::Rapid, &[&text]);
        near(
            all.iter().find(|one| one.as_ref().is_ok_and(|j| (j[0] - 20.0).abs() < 0.1)).expect("the path"),
            DIRECT,
        );
    }
}

#[test]
fn the_point_before_may_be_in_another_file() {
    let chain = arm();
    let src = format!(
        "DEF job()\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nPTP {{A1 5,A2 10,A3 5,A4 0,A5 40,A6 10}}\nLIN P2\nLIN {}\nEND\n",
        frame(&chain, [22.0, 15.0, 10.0, 30.0, 40.0, -20.0], "")
    );
    let dat = format!(
        "DEFDAT job\nDECL FRAME P9={{X 1,Y 2,Z 3,A 0,B 0,C 0}}\nDECL FRAME P2={}\nENDDAT\n",
        frame(&chain, DIRECT, "")
    );
    let found = joints(&chain, Dialect::Krl, &[&src, &dat]);
    near(&found[1], [22.0, 15.0, 10.0, 30.0, 40.0, -20.0]);
    let found = joints(&chain, Dialect::Krl, &[&dat, &src]);
    near(&found[0], DIRECT);
}

#[test]
fn a_line_keeps_shoulder_elbow_and_wrist() {
    // The tool turns by 170° about its own axis and goes to the other side of the base.
    let chain = samples::ur10();
    let (from, to) = ([5.0, -80.0, 95.0, -110.0, -85.0, 0.0], [-150.0, -80.0, 95.0, -105.0, -85.0, 170.0]);
    let values = from.map(|value: f64| value.to_radians()).map(|value| format!("{value:.9}")).join(",");
    let place = script(&pose(&chain, to));
    let text =
        |verb: &str| format!("def job():\n  movej([{values}])\n  {verb}({place})\n  {verb}({place})\nend\n");
    let found = joints(&chain, Dialect::UrScript, &[&text("movel")]);
    near(&found[1], to);
    near(&found[2], to);
    // An arm of KUKA's kind: without S, a line keeps what a joint motion leaves open.
    let chain = arm();
    let far = [170.0, 20.0, 5.0, 10.0, 30.0, -160.0];
    let line = |verb: &str| {
        let place = frame(&chain, far, "");
        format!(
            "DEF a()\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nPTP {{A1 5,A2 10,A3 5,A4 0,A5 40,A6 10}}\n{verb} {place}\nEND\n"
        )
    };
    near(&joints(&chain, Dialect::Krl, &[&line("LIN")])[1], far);
}

#[test]
fn a_point_of_which_several_are_possible_does_not_refuse_those_behind_it() {
    let chain = arm();
    // From the middle between a wrist and its other side.
    let middle = "PTP {A1 20,A2 15,A3 10,A4 -60,A5 0,A6 70}\n";
    let place = frame(&chain, DIRECT, "");
    let sure = "PTP {A1 5,A2 10,A3 5,A4 0,A5 40,A6 10}\n";
    let text = format!(
        "DEF a()\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\n{middle}PTP {place}\nPTP {place}\n{sure}LIN {place}\nEND\n"
    );
    let found = joints(&chain, Dialect::Krl, &[&text]);
    let reason = found[1].clone().unwrap_err();
    assert!(reason.contains("about equally far"), "{reason}");
    let reason = found[2].clone().unwrap_err();
    assert!(reason.contains("not known since PTP in line 5"), "{reason}");
    near(&found[4], DIRECT);
}

#[test]
fn the_start_is_named_where_it_is_not_given() {
    let chain = arm();
    let text = format!(
        "DEF a()\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nPTP $POS_ACT\nPTP {}\nEND\n",
        frame(&chain, DIRECT, "")
    );
    let given = |start: Option<Vec<f64>>| {
        let options = CorrectOptions { start, ..CorrectOptions::default() };
        corrections(&chain, Dialect::Krl, &[&text], &options)[0][0].clone()
    };
    let open = given(None);
    assert!(open.nominal.is_none() && open.reason.contains("(--start)"), "{}", open.reason);
    // The motion before goes to a place that is not known.
    let open = given(Some(DIRECT.map(f64::to_radians).to_vec()));
    assert!(open.nominal.is_none() && !open.reason.contains("--start"), "{}", open.reason);
}

#[test]
fn a_limit_that_is_the_reason_is_named() {
    let chain = arm();
    let far = [10.0, 118.5, -60.0, 0.0, 50.0, 0.0];
    let text = format!(
        "MODULE M\nPROC main()\nMoveJ {},v1,fine,tool0;\nENDPROC\nENDMODULE\n",
        target(&chain, far, "0,0,0,0")
    );
    let reason = joints(&chain, Dialect::Rapid, &[&text])[0].clone().unwrap_err();
    assert!(reason.contains("A2 would be 118.5° (limits: -115.0° to 115.0°)"), "{reason}");
}

#[test]
fn val3_states_shoulder_elbow_and_wrist() {
    let chain = arm();
    for (degrees, words) in [
        (DIRECT, "shoulder=\"lefty\" elbow=\"epositive\" wrist=\"wpositive\""),
        (FLIPPED, "shoulder=\"lefty\" elbow=\"epositive\" wrist=\"wnegative\""),
        (
            [20.0, 60.0, -120.0, 30.0, 40.0, -20.0],
            "shoulder=\"lefty\" elbow=\"enegative\" wrist=\"wpositive\"",
        ),
        (
            [20.0, -60.0, -50.0, 30.0, 40.0, -20.0],
            "shoulder=\"righty\" elbow=\"epositive\" wrist=\"wpositive\"",
        ),
    ] {
        let pose = pose(&chain, degrees);
        let [x, y, z] = [0, 1, 2].map(|k| 1e3 * pose.translation[k]);
        let [rx, ry, rz] =
            Pose::new(pose.rotation.transpose(), Vector3::zeros()).rpy().map(|v| -v.to_degrees());
        let text = format!(
            "<Data name=\"p\" type=\"pointRx\"><Value key=\"0\" x=\"{x:.6}\" y=\"{y:.6}\" z=\"{z:.6}\" rx=\"{rx:.7}\" ry=\"{ry:.7}\" \
             rz=\"{rz:.7}\" {words} fatherId=\"world[0]\"/></Data>"
        );
        near(&joints(&chain, Dialect::Val3, &[&text])[0], degrees);
    }
}

#[test]
fn a_stretched_wrist_is_no_refusal_and_a_tool_that_stands_still_is() {
    let chain = arm();
    let text = "DEF a()\n$TOOL=$NULLFRAME\n$BASE=$NULLFRAME\n$IPO_MODE=#TCP\nPTP {A1 5,A2 10,A3 5,A4 0,A5 40,A6 10}\nIF x THEN\nLIN {X 1,Y 2,Z 3,A 0,B 0,C 0}\n\
                ENDIF\n$IPO_MODE=#BASE\nLIN {X 1,Y 2,Z 3,A 0,B 0,C 0}\nEND\n";
    let options = CorrectOptions {
        tool: Some(Pose::IDENTITY),
        frame: Some(Pose::IDENTITY),
        ..CorrectOptions::default()
    };
    let all = &corrections(&chain, Dialect::Krl, &[text], &options)[0];
    assert!(all[1].reason.contains("$IPO_MODE = #TCP"), "{}", all[1].reason);
    assert!(!all[2].reason.contains("IPO_MODE"), "{}", all[2].reason);
    assert_eq!(all[1].outcome, Outcome::Refused);
    // A tool and a work object of ABB, named in the options as well.
    let text = "MODULE M\nPERS tooldata fix:=[FALSE,[[0,0,0],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n\
                PERS wobjdata held:=[TRUE,TRUE,\"\",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\nPROC main()\n\
                MoveL [[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v1,fine,fix\\WObj:=held;\nENDPROC\nENDMODULE\n";
    let named = |name: &str| vec![(name.to_owned(), Pose::IDENTITY)];
    let options = CorrectOptions { tools: named("fix"), frames: named("held"), ..CorrectOptions::default() };
    let all = &corrections(&chain, Dialect::Rapid, &[text], &options)[0];
    assert!(all[0].reason.contains("robhold"), "{}", all[0].reason);
}

#[test]
fn a_place_on_the_way_of_a_circle_has_the_orientation_of_its_destination() {
    let chain = arm();
    let at = |degrees: [f64; 6]| {
        let pose = pose(&chain, degrees);
        let angles = Dialect::Krl.orientation().write(&pose.rotation, &[0.0; 3]);
        let [x, y, z] = [pose.translation.x, pose.translation.y, pose.translation.z].map(|v| 1e3 * v);
        (format!("X {x},Y {y},Z {z}"), format!("A {},B {},C {}", angles[0], angles[1], angles[2]))
    };
    let (start, way, end) = (
        [0.0, 10.0, 20.0, 0.0, 40.0, 0.0],
        [5.0, 12.0, 18.0, 3.0, 42.0, 4.0],
        [10.0, 14.0, 16.0, 6.0, 44.0, 8.0],
    );
    let ((way, _), (place, angles)) = (at(way), at(end));
    let joints =
        start.iter().enumerate().map(|(k, v)| format!("A{} {v}", k + 1)).collect::<Vec<_>>().join(",");
    let inline = format!(
        "DEF a()\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nPTP {{{joints}}}\nCIRC {{{way}}},{{{place},{angles}}}\n"
    );
    let named = inline.replace(&format!("{{{place},{angles}}}"), "XEND");
    let data = format!("DEFDAT a\nE6POS XEND={{{place},{angles}}}\nENDDAT\n");
    let options = CorrectOptions::default();
    let one = corrections(&chain, Dialect::Krl, &[&inline], &options);
    let two = corrections(&chain, Dialect::Krl, &[&named, &data], &options);
    assert!(one[0][1].nominal.is_some(), "{}", one[0][1].reason);
    assert_eq!(one[0][1].nominal, two[0][1].nominal);
    let lost = corrections(&chain, Dialect::Krl, &[&named], &options);
    assert!(lost[0][1].reason.contains("its destination has none"), "{}", lost[0][1].reason);
    // Three numbers are written, and no angles.
    let program = Program::read(inline.as_bytes(), &[], Dialect::Krl).expect("a program");
    assert_eq!(program.points()[1].ranges().count(), 3);
}
