//! The load that a program states, on the true simulated robot that carries it.

use crate::programs::{arm, flange, identified_from, plant};
use truepose_compensate::installation;
use truepose_controllers::{CorrectOptions, Dialect, Outcome, Program, Value, correct};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Conditions, Load, Payload, Pose};
use truepose_simulate::Campaign;

#[test]
fn a_load_that_the_program_states_is_in_the_correction() {
    let plant = plant(&arm(true));
    let campaign = Campaign::random(plant.chain(), 250, 11).expect("a campaign");
    let campaign = campaign.with_some_payload(&[0.0, 40.0, 80.0], [0.0, 0.0, 0.15], 0.05, 3).shuffled(5);
    let fitted = identified_from(&plant, &campaign);
    let known = fitted.domain.payload.expect("loads in the data");
    let (mass, com) = (0.8 * known.upper, Vector3::new(0.02, -0.03, 0.2));
    assert!(known.lower < 0.2 * known.upper);
    let chain = plant.chain();
    let list = [
        [0.5, 0.3, -0.3, 0.3, 0.9, 0.2],
        [-0.4, 0.5, -0.5, -0.4, -0.8, 0.9],
        [1.0, 0.1, 0.1, 0.8, 1.1, -0.5],
    ];
    let head = format!(
        "MODULE m\nPERS tooldata t1:=[TRUE,[[0,0,0],[1,0,0,0]],[{mass},[{},{},{}],[1,0,0,0],0,0,0]];\nPROC main()\n",
        1e3 * com.x,
        1e3 * com.y,
        1e3 * com.z
    );
    let lines = list.map(|q| {
        let joined: Vec<String> = q.iter().map(|v: &f64| format!("{:.7}", v.to_degrees())).collect();
        format!("MoveAbsJ [[{}],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,t1;\n", joined.join(","))
    });
    let text = format!("{head}{}ENDPROC\nENDMODULE\n", lines.concat());
    let program = Program::read(text.as_bytes(), &[], Dialect::Rapid).expect("a program");
    // The centre is stated in the flange; the plant has it in the tool.
    let tool = plant.chain().tool().pose;
    let load = Load::Payload(Payload { mass, com: tool.inverse().apply(&com) });
    let base = installation(&fitted).expect("an installation");
    let miss = |joints: &[f64], meant: &[f64]| {
        let really = plant.true_pose(&Conditions::at(chain, joints).with_load(load)).expect("a pose");
        let desired: Pose = base.base * flange(chain, meant) * base.tool;
        (really.translation - desired.translation).norm()
    };
    let worst = |program_loads: bool| {
        let options = CorrectOptions { program_loads, limit: 0.05, ..CorrectOptions::default() };
        let corrections = correct(&program, &fitted, &options).expect("corrections");
        assert!(corrections.iter().all(|one| one.outcome == Outcome::Corrected), "{corrections:?}");
        let new: Vec<_> = corrections.iter().map(|one| one.replacement.clone()).collect();
        let out = program.rewritten(&new).expect("a program");
        let again = Program::read(&out, &[], Dialect::Rapid).expect("a program");
        let one = |(point, meant): (&truepose_controllers::Point, &[f64; 6])| match &point.value {
            Value::Joints(values) => miss(&values.iter().map(|v| v.to_radians()).collect::<Vec<_>>(), meant),
            Value::Pose { .. } => f64::NAN,
        };
        again.points().iter().zip(&list).map(one).fold(0.0, f64::max)
    };
    let before = list.iter().map(|q| miss(q, q)).fold(0.0, f64::max);
    let (without, with) = (worst(false), worst(true));
    println!("{mass} kg: before {before:e}, without the load {without:e}, with it {with:e} m");
    assert!(with < 0.1 * without && with < 1e-4, "{with:e} m, without {without:e} m");
}
