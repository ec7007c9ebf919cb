//! A program in Rust alone: from files to a fit with held-out landmarks, a search, and commands.

#![allow(clippy::unwrap_used)]

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Mutex;
use truepose_errormodel::EffectRegistry;
use truepose_io::Poses;
use truepose_solvers::PivotedQr;
use truepose_workflow::command::{CommandOptions, command};
use truepose_workflow::{
    DiscoverRequest, IdentifyRequest, InputFiles, Inputs, NamedSolver, Observer, Search, Unobserved,
    WorkflowError, identify,
};

fn example(name: &str) -> Inputs {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name);
    let model = Some(folder.join("model.toml")).filter(|file| file.exists());
    let (robot, data) = (folder.join("robot.toml"), folder.join("measurements.csv"));
    let files = InputFiles { robot, data, model, ..InputFiles::default() };
    files.read(&EffectRegistry::builtin()).unwrap().0
}

fn qr() -> NamedSolver {
    NamedSolver { name: "qr".into(), solver: Box::new(PivotedQr::default()) }
}

/// Keeps steps and remarks; ends the run at a step of this name.
#[derive(Default)]
struct Kept {
    said: Mutex<Vec<String>>,
    until: Option<&'static str>,
}

impl Observer for Kept {
    fn step(&self, words: &str) -> ControlFlow<()> {
        self.said.lock().unwrap().push(words.into());
        if self.until == Some(words) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn remark(&self, words: &str) {
        let _ = self.step(words);
    }
}

#[test]
fn landmarks_are_left_out_and_the_fit_is_of_the_robot_alone() {
    let inputs = example("09_sockets");
    let made = identify(inputs, &IdentifyRequest::default(), &qr(), &Unobserved).unwrap();
    let landmarks = made.summary.landmarks.as_ref().unwrap();
    assert!(landmarks.points.len() >= 12);
    // Errors of 0.5 mm and 1.5 mrad in each joint leave more than a millimetre; a gear error of 0.4 mrad is not declared.
    let [.., alone, declared] = &made.summary.stages[..] else { panic!("two stages") };
    let held_out = declared.held_out.unwrap().rms_mm;
    assert!(held_out < 0.25 && alone.train.rms_mm > 1.0, "{held_out} {}", alone.train.rms_mm);
    assert!(made.fitted.provenance.contains_key("landmarks_m"));
    assert_eq!(made.fitted.provenance["verb"], "identify");
}

#[test]
fn commands_bring_the_arm_to_poses_that_it_was_measured_at() {
    let inputs = example("01_identify");
    let (chain, data) = (inputs.chain.clone(), inputs.data.clone());
    let made = identify(inputs, &IdentifyRequest::default(), &qr(), &Unobserved).unwrap();
    let robot = made.fitted.of_robot();
    let mut rows = data.select(&[0, 40, 80]);
    rows.orientation.fill(None);
    let units = chain.movable().iter().map(|_| *truepose_io::Quantity::Angle.si()).collect();
    let mut poses = Poses { rows, seeded: true, joint_units: units, ids: Vec::new(), convention: None };
    let (commands, expected) = command(&robot, &mut poses, &CommandOptions::default(), &|| ()).unwrap();
    for (k, (command, expected)) in commands.iter().zip(&expected).enumerate() {
        // A degree is 40 mm at 2.3 m: the joints are those of the measurement, up to the fit's error.
        for (joint, column) in poses.rows.joints.iter().enumerate() {
            assert!((command.joints[joint] - column[k]).abs() < 2e-3, "row {k}, joint {joint}");
        }
        assert!(expected.within_95 < 1e-3 && expected.corrected, "{}", expected.within_95);
    }
}

#[test]
fn an_observer_sees_remarks_and_ends_a_run() {
    let kept = Kept { until: Some("screening all candidates"), ..Kept::default() };
    let search = Search::new(example("01_identify"), DiscoverRequest::default(), qr(), &kept).unwrap();
    let error = search.run(&kept).unwrap_err();
    assert!(error.is_cancelled(), "{error}");
    assert_eq!(kept.said.lock().unwrap().last().unwrap(), "screening all candidates");
}

#[test]
fn options_out_of_range_are_refused() {
    let request = IdentifyRequest { holdout: Some(1.5), ..IdentifyRequest::default() };
    let error = identify(example("01_identify"), &request, &qr(), &Unobserved).unwrap_err();
    assert!(error.to_string().contains("holdout"), "{error}");
    let request = IdentifyRequest { repeats: 0, ..IdentifyRequest::default() };
    let error = request.validate().unwrap_err();
    assert!(matches!(error, WorkflowError::InvalidOption { option: "repeat", .. }), "{error}");
}
