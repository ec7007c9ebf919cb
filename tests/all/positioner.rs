//! Work on a positioner: robot and positioner are one fit, a tree, and the true simulated robot is driven to the corrected points on the true positioner.

use crate::external_axes::assert_never_worse;
use crate::leaning::share_within;
use crate::programs::{arm, plant, solved};
use crate::taught_frames::rms;
use nalgebra::{Unit, Vector3};
use truepose_compensate::installation;
use truepose_controllers::{CorrectOptions, Dialect, Outcome, Program, Value, correct};
use truepose_errormodel::effects::{Geometric, JointCompliance};
use truepose_errormodel::{AnyEffect, DatasetBuilder, ErrorModel, FittedModel, Measurement};
use truepose_identify::{FitOptions, fit};
use truepose_kinematics::{
    Chain, Conditions, Joint, JointId, JointKind, Placed, Placement, Pose, Tool, ToolId,
};
use truepose_simulate::{Campaign, Plant};
use truepose_solvers::PivotedQr;

/// In the middle of the robot's data.
const UPRIGHT: [f64; 6] = [0.5, 0.37, -0.27, 0.3, 0.9, 0.2];

/// The positioner: it stands in front of the robot, tilts and turns.
fn positioner() -> Vec<Joint> {
    let turn = |name: &str, at: Pose, axis: [f64; 3]| {
        let axis = Unit::new_normalize(Vector3::from(axis));
        Joint::new(name, JointKind::Revolute, Placement::Origin { pose: at, axis })
            .with_limits(-1.5, 1.5)
            .with_link(150.0, [0.02, 0.0, 0.05])
    };
    let stand = Placement::Origin {
        pose: Pose::from_xyz_rpy([1.5, 0.2, 0.1], [0.0; 3]),
        axis: Unit::new_normalize(Vector3::z()),
    };
    vec![
        Joint::new("stand", JointKind::Fixed, stand),
        turn("tilt", Pose::from_xyz_rpy([0.0, 0.0, 0.5], [0.0; 3]), [0.0, 1.0, 0.0]),
        turn("turn", Pose::from_xyz_rpy([0.0, 0.0, 0.2], [0.0; 3]), [0.0, 0.0, 1.0]),
    ]
}

/// A robot and a positioner, in one fit.
struct Station {
    robot: Plant,
    table: Plant,
    fitted: FittedModel,
    tool: Pose,
}

impl Station {
    fn new() -> Station {
        let arm = arm(true);
        let on_table = Placed { pose: Pose::from_xyz_rpy([0.0, 0.0, 0.1], [0.0; 3]), known: true };
        let alone = Chain::new("table", positioner()).and_then(|chain| chain.with_base(*arm.base()));
        let alone = alone.and_then(|chain| chain.with_tool(on_table)).expect("a positioner");
        let joints: Vec<Joint> = arm.joints().iter().cloned().chain(positioner()).collect();
        let parents = (0..9).map(|k| if k == 0 || k == 6 { None } else { Some(JointId(k)) });
        let tree = Chain::new("station", joints).and_then(|chain| chain.with_base(*arm.base()));
        let tree = tree.and_then(|chain| chain.with_parents(&parents.collect::<Vec<_>>()));
        let tools = vec![
            Tool::on("gun", Some(JointId(6)), *arm.tool()),
            Tool::on("table", Some(JointId(9)), on_table),
        ];
        let tree = tree.and_then(|chain| chain.with_tools(tools)).expect("a tree");
        let (robot, table) = (plant(&arm), plant(&alone));
        let mut builder = DatasetBuilder::new(&tree);
        let mut visit = 0;
        for (plant, tool, count) in [(&robot, ToolId(0), 250), (&table, ToolId(1), 80)] {
            let campaign = Campaign::random(plant.chain(), count, 11).expect("a campaign").shuffled(5);
            let data = plant.measure(&campaign, 7).expect("data");
            for row in 0..data.len() {
                let own: Vec<f64> = data.joints.iter().map(|column| column[row]).collect();
                // The other part stands somewhere.
                let joints = if tool.0 == 0 {
                    [&own[..], &[0.2, -0.3]].concat()
                } else {
                    [&UPRIGHT[..], &own].concat()
                };
                let one = Measurement::at(joints).position(data.position[row]).tool(tool).visit(visit);
                visit += 1;
                builder.push(one.orientation(data.orientation[row].expect("an orientation"))).expect("a row");
            }
        }
        let data = builder.finish();
        let effects: Vec<Box<dyn AnyEffect>> =
            vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())];
        let model = ErrorModel::new(tree, effects).expect("a model");
        let fitted = fit(&model, &data, &PivotedQr::default(), &FitOptions::default()).expect("a fit").fitted;
        let tool = installation(&fitted).expect("an installation").tool;
        Station { robot, table, fitted, tool }
    }

    fn chain(&self) -> &Chain {
        self.fitted.chain()
    }

    /// The controller's tool on its table, at these axes of the positioner.
    fn nominal(&self, joints: &[f64], axes: &[f64]) -> Pose {
        let (chain, all) = (self.chain(), [joints, axes].concat());
        let hand = chain.forward_to(ToolId(0), &all) * chain.tools()[0].placed.pose.inverse() * self.tool;
        chain.forward_to(ToolId(1), &all).inverse() * hand
    }

    fn really(&self, joints: &[f64], axes: &[f64]) -> Pose {
        let of =
            |plant: &Plant, q: &[f64]| plant.true_pose(&Conditions::at(plant.chain(), q)).expect("a pose");
        of(&self.table, axes).inverse() * of(&self.robot, joints)
    }

    fn misses(&self, program: &Program, work: &Pose, meant: &[Pose]) -> Vec<f64> {
        let one = |(point, meant): (&truepose_controllers::Point, &Pose)| {
            let Value::Pose { pose, .. } = &point.value else { return f64::NAN };
            let axes: Vec<f64> = point.external.iter().take(2).map(|(_, value)| value.to_radians()).collect();
            let joints = solved(|q| self.nominal(q, &axes), &(*work * *pose), &UPRIGHT, &[0, 1, 2, 3, 4, 5]);
            (self.really(&joints, &axes).translation - work.apply(&meant.translation)).norm()
        };
        program.points().iter().skip(1).zip(meant).map(one).collect()
    }
}

#[test]
fn points_on_a_positioner_are_right_relative_to_the_work() {
    let station = Station::new();
    let work = Pose::from_xyz_rpy([0.05, -0.1, 0.02], [0.1, 0.05, 0.4]);
    let row = |values: &[f64]| values.iter().map(|v| format!("{v:.7}")).collect::<Vec<_>>().join(",");
    let written = |pose: &Pose| {
        format!(
            "[[{}],[{}]]",
            row((1e3 * pose.translation).as_slice()),
            pose.quaternion().map(|v| format!("{v:.10}")).join(",")
        )
    };
    let degrees = |q: &[f64]| q.iter().map(|v| v.to_degrees()).collect::<Vec<f64>>();
    let external = |axes: &[f64]| format!("[{},9E9,9E9,9E9,9E9]", row(&degrees(axes)));
    let mut text = format!(
        "MODULE m\nPERS wobjdata w1:=[FALSE,FALSE,\"STN1\",{},[[0,0,0],[1,0,0,0]]];\nPERS tooldata t1:=[TRUE,{},[0,[0,0,1],[1,0,0,0],0,0,0]];\nPROC main()\n\
         ConfL\\Off;\nMoveAbsJ [[{}],{}],v100,fine,t1;\n",
        written(&work),
        written(&station.tool),
        row(&degrees(&UPRIGHT)),
        external(&[0.0, 0.0])
    );
    let mut meant = Vec::new();
    for k in 0..40 {
        let wave = |n: usize, size: f64| size * (1.3 * (k * n) as f64 + n as f64).sin();
        let joints: Vec<f64> = (0..6).map(|n| UPRIGHT[n] + wave(n + 2, 0.2)).collect();
        let axes = [wave(1, 0.8), wave(3, 1.0)];
        let pose = work.inverse() * station.nominal(&joints, &axes);
        let place = written(&pose);
        text += &format!(
            "MoveL [{},[0,0,0,0],{}],v100,fine,t1\\WObj:=w1;\n",
            &place[1..place.len() - 1],
            external(&axes)
        );
        meant.push(pose);
    }
    text += "ENDPROC\nENDMODULE\n";
    let program = Program::read(text.as_bytes(), &[], Dialect::Rapid).expect("a program");
    let external = vec![("eax_a".into(), "tilt".into()), ("eax_b".into(), "turn".into())];
    let plain = CorrectOptions { external, limit: 0.05, ..CorrectOptions::default() };
    // Without the positioner its frame is not known.
    let refused = correct(&program, &station.fitted, &plain).expect("corrections");
    assert!(refused[1].reason.contains("--work W1=TOOL"), "{}", refused[1].reason);
    let options = CorrectOptions { work: vec![("W1".into(), "table".into())], ..plain };
    let corrections = correct(&program, &station.fitted, &options).expect("corrections");
    for one in &corrections {
        assert!(one.outcome != Outcome::Refused, "{one:?}");
    }
    let new: Vec<_> = corrections.iter().map(|one| one.replacement.clone()).collect();
    let out = program.rewritten(&new).expect("a program");
    let again = Program::read(&out, &[], Dialect::Rapid).expect("a program");
    let (before, after) = (station.misses(&program, &work, &meant), station.misses(&again, &work, &meant));
    println!("positioner: {:.3e} → {:.3e} m", rms(&before), rms(&after));
    assert!(rms(&after) < 0.2 * rms(&before), "{:e} → {:e} m", rms(&before), rms(&after));
    let within: Vec<f64> = corrections.iter().skip(1).map(|one| one.within_95.expect("a bound")).collect();
    assert_never_worse("positioner", &before, &after, &within);
    let share = share_within(&program, &station.fitted, &options, ToolId(0));
    println!("positioner: {:.1} % of drawn robots are within the stated 95 %", 100.0 * share);
    assert!((0.90..0.99).contains(&share), "{share}");
    for (tool, words) in
        [("desk", "the fit has no tool `desk`"), ("gun", "carries `gun` and is no external axis")]
    {
        let options = CorrectOptions { work: vec![("W1".into(), tool.into())], ..options.clone() };
        let error = correct(&program, &station.fitted, &options).expect_err("refused").to_string();
        assert!(error.contains(words), "{error}");
    }
}
