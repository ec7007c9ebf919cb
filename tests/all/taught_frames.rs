//! A fixture whose frame, and a tool whose tip, were taught with the uncorrected robot: the true simulated robot is driven to corrected
//! points, and the error is that relative to the fixture.

use crate::programs::{arm, flange, identified, plant, solved};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use truepose_compensate::installation;
use truepose_controllers::{
    CorrectOptions, Dialect, Offset, Outcome, Program, Taught, Touched, Value, correct, correct_all,
    is_stated, offsets,
};
use truepose_errormodel::FittedModel;
use truepose_kinematics::{Conditions, Pose, rotation_log, rotation_vector};
use truepose_simulate::Plant;

const NEAR: [f64; 6] = [0.5, -1.2, 1.3, 0.3, 0.9, 0.2];

/// Joints of an arm of six for which a pose of them is the wanted one.
fn reached(pose: impl Fn(&[f64]) -> Pose, wanted: &Pose) -> Vec<f64> {
    solved(pose, wanted, &NEAR, &[0, 1, 2, 3, 4, 5])
}

fn really(plant: &Plant, joints: &[f64]) -> Pose {
    plant.true_pose(&Conditions::at(plant.chain(), joints)).expect("a pose")
}

pub fn three_points(points: &[Vector3<f64>]) -> Pose {
    let x = (points[1] - points[0]).normalize();
    let z = x.cross(&(points[2] - points[0])).normalize();
    Pose::new(Matrix3::from_columns(&[x, z.cross(&x), z]), points[0])
}

fn touched(word: &str, line: usize, joints: &[f64]) -> Touched {
    Touched { word: word.into(), line, joints: joints.to_vec(), load: None }
}

/// A fixture, and a program that goes to points of it.
pub struct Fixture {
    plant: Plant,
    pub fitted: FittedModel,
    tool: Pose,
    /// In the measurement frame.
    real: Pose,
    /// As the controller has it after touching.
    frame: Pose,
    touched: Vec<Touched>,
    points: Vec<Pose>,
}

impl Fixture {
    pub fn new() -> Fixture {
        let plant = plant(&arm(false));
        let fitted = identified(&plant);
        let tool = installation(&fitted).expect("an installation").tool;
        let chain = plant.chain();
        let start = really(&plant, &NEAR);
        let real = Pose::new(rotation_vector(&Vector3::new(0.05, -0.1, 0.6)), start.translation);
        let turned = |place: Vector3<f64>| Pose::new(start.rotation, real.apply(&place));
        let corners = [Vector3::zeros(), Vector3::new(0.4, 0.0, 0.0), Vector3::new(0.05, 0.3, 0.0)];
        // The robot is jogged until it touches.
        let joints = corners.map(|corner| reached(|q| really(&plant, q), &turned(corner)));
        let tips: Vec<Vector3<f64>> = joints.iter().map(|q| (flange(chain, q) * tool).translation).collect();
        let words = ["origin", "x", "xy"];
        let touched = (0..3).map(|k| touched(words[k], k + 2, &joints[k])).collect();
        let mut points = Vec::new();
        for k in 0..27 {
            let place =
                Vector3::new(0.2 * f64::from(k % 3), 0.15 * f64::from(k / 3 % 3), 0.1 * f64::from(k / 9));
            let turn = rotation_vector(&(0.1 * Vector3::new(f64::from(k % 4), f64::from(k % 5), 1.0)));
            points.push(Pose::new(real.rotation.transpose() * start.rotation * turn, place));
        }
        let frame = three_points(&tips);
        Fixture { plant, fitted, tool, real, frame, touched, points }
    }

    /// Points in the base of a tool that was taught: a fixed tip is touched in five postures, and the controller solves for the tool with its nominal flange.
    pub fn with_a_taught_tool() -> (Fixture, Taught) {
        let fixture = Fixture::new();
        let (plant, chain) = (&fixture.plant, fixture.plant.chain());
        let tip = really(plant, &NEAR);
        let turns = [[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [-0.4, 0.2, 0.0], [0.0, 0.4, 0.4], [0.1, -0.4, 0.5]];
        let joints = turns.map(|turn| {
            let turned = tip.rotation * rotation_vector(&Vector3::from(turn));
            reached(|q| really(plant, q), &Pose::new(turned, tip.translation))
        });
        let (mut left, mut right) = (DMatrix::zeros(15, 6), DVector::zeros(15));
        for (k, q) in joints.iter().enumerate() {
            let at = flange(chain, q);
            left.view_mut((3 * k, 0), (3, 3)).copy_from(&at.rotation);
            left.view_mut((3 * k, 3), (3, 3)).copy_from(&-Matrix3::identity());
            right.rows_mut(3 * k, 3).copy_from(&-at.translation);
        }
        let found = left.svd(true, true).solve(&right, 1e-12).expect("a tip");
        let stated = Pose::new(fixture.tool.rotation, found.fixed_rows::<3>(0).into_owned());
        let off = (stated.translation - fixture.tool.translation).norm();
        assert!(off > 2e-4, "the taught tool is wrong by {off:e} m");
        let base = installation(&fixture.fitted).expect("an installation").base;
        let fixture = Fixture { tool: stated, real: base, frame: Pose::IDENTITY, ..fixture };
        // Points in the base.
        let points = fixture
            .points
            .iter()
            .map(|point| base.inverse() * Pose::new(tip.rotation, tip.translation + 0.5 * point.translation));
        let points = points.collect();
        let fixture = Fixture { points, ..fixture };
        let touched = joints.iter().enumerate().map(|(k, q)| touched("", k + 2, q)).collect();
        let taught = Taught { name: "TOOL_DATA[1]".into(), tool: None, file: "tip.csv".into(), touched };
        (fixture, taught)
    }

    pub fn text(&self) -> String {
        let start: Vec<String> =
            NEAR.iter().enumerate().map(|(k, q)| format!("A{} {:.6}", k + 1, q.to_degrees())).collect();
        let mut text =
            format!("DEF a()\n$BASE=BASE_DATA[2]\n$TOOL=TOOL_DATA[1]\nPTP {{{}}}\n", start.join(","));
        for pose in &self.points {
            let ([x, y, z], [c, b, a]) =
                ([0, 1, 2].map(|k| 1e3 * pose.translation[k]), pose.rpy().map(f64::to_degrees));
            text += &format!("LIN {{X {x:.6},Y {y:.6},Z {z:.6},A {a:.7},B {b:.7},C {c:.7}}}\n");
        }
        text + "END\n"
    }

    pub fn options(&self) -> CorrectOptions {
        CorrectOptions {
            frames: vec![("BASE_DATA[2]".into(), self.frame)],
            tools: vec![("TOOL_DATA[1]".into(), self.tool)],
            limit: 0.02,
            ..CorrectOptions::default()
        }
    }

    pub fn taught(&self) -> Taught {
        let (name, file) = ("BASE_DATA[2]".into(), "points.csv".into());
        Taught { name, tool: None, file, touched: self.touched.clone() }
    }

    /// Errors of the points of a program relative to the fixture, m.
    fn misses(&self, program: &Program) -> Vec<f64> {
        let poses = program.points().iter().filter_map(|point| match &point.value {
            Value::Pose { pose, .. } => Some(*pose),
            Value::Joints(_) => None,
        });
        let one = |(pose, meant): (Pose, &Pose)| {
            let nominal = |q: &[f64]| flange(self.plant.chain(), q) * self.tool;
            let joints = reached(nominal, &(self.frame * pose));
            (really(&self.plant, &joints).translation - self.real.apply(&meant.translation)).norm()
        };
        poses.zip(&self.points).map(one).collect()
    }

    /// The offset of the frame, or of the tool, and in words what none improves.
    fn offset(&self, text: &str, options: &CorrectOptions) -> (Vec<Offset>, Vec<String>) {
        let program = [Program::read(text.as_bytes(), &[], Dialect::Krl).expect("a program")];
        let corrections = correct_all(&program, &self.fitted, options).expect("corrections");
        offsets(&program, &corrections, options).expect("offsets")
    }

    fn corrected(&self, options: &CorrectOptions) -> Vec<f64> {
        let program = Program::read(self.text().as_bytes(), &[], Dialect::Krl).expect("a program");
        let corrections = correct(&program, &self.fitted, options).expect("corrections");
        assert!(corrections.iter().all(|one| one.outcome != Outcome::Refused), "{corrections:?}");
        let new: Vec<_> = corrections.iter().map(|one| one.replacement.clone()).collect();
        let out = program.rewritten(&new).expect("a program");
        self.misses(&Program::read(&out, &[], Dialect::Krl).expect("a program"))
    }
}

pub fn rms(all: &[f64]) -> f64 {
    (all.iter().map(|v| v * v).sum::<f64>() / all.len() as f64).sqrt()
}

#[test]
fn points_of_a_taught_fixture_are_right_relative_to_the_fixture() {
    let fixture = Fixture::new();
    let program = Program::read(fixture.text().as_bytes(), &[], Dialect::Krl).expect("a program");
    let before = fixture.misses(&program);
    let unstated = fixture.corrected(&fixture.options());
    let options = CorrectOptions { taught: vec![fixture.taught()], ..fixture.options() };
    let taught = fixture.corrected(&options);
    assert!(
        is_stated("BASE_DATA[2]", &program, &options)
            && !is_stated("BASE_DATA[2]", &program, &fixture.options())
    );
    println!("before {:e}, as if measured {:e}, taught {:e} m", rms(&before), rms(&unstated), rms(&taught));
    // What the fit leaves: commands for poses that are known in the measurement frame.
    assert!(rms(&unstated) > 2.0 * rms(&before), "the frame's error is added");
    assert!(rms(&taught) < 0.3 * rms(&before) && rms(&taught) < 1e-4);
    for (k, (before, after)) in before.iter().zip(&taught).enumerate() {
        // A correction below its uncertainty is not made.
        assert!(*after < before.max(5e-5), "point {k}: {before:e} m before, {after:e} m after");
    }
    // ABB's three points make the same frame.
    let axes = [("x1", 0.1, 0.0), ("x2", 0.4, 0.0), ("y1", 0.0, 0.3)];
    let chain = fixture.plant.chain();
    let turned = really(&fixture.plant, &NEAR).rotation;
    let joints = axes.map(|(_, x, y)| {
        let place = fixture.real.apply(&Vector3::new(x, y, 0.0));
        reached(|q| really(&fixture.plant, q), &Pose::new(turned, place))
    });
    let tips = joints.clone().map(|q| (flange(chain, &q) * fixture.tool).translation);
    let along = (tips[1] - tips[0]).normalize();
    let origin = tips[0] + along * along.dot(&(tips[2] - tips[0]));
    let mut other = fixture.taught();
    other.touched = (0..3).map(|k| touched(axes[k].0, k + 2, &joints[k])).collect();
    let frames = vec![("BASE_DATA[2]".into(), three_points(&[origin, tips[1], tips[2]]))];
    let fixture = Fixture { frame: three_points(&[origin, tips[1], tips[2]]), ..fixture };
    let found = fixture.corrected(&CorrectOptions { frames, taught: vec![other], ..options });
    assert!(rms(&found) < 1e-4, "{:e} m", rms(&found));
}

#[test]
fn points_that_do_not_agree_with_the_frame_are_an_error_with_the_difference() {
    let fixture = Fixture::new();
    let program = Program::read(fixture.text().as_bytes(), &[], Dialect::Krl).expect("a program");
    let failed = |change: &dyn Fn(&mut Taught, &mut CorrectOptions)| {
        let (mut taught, mut options) = (fixture.taught(), fixture.options());
        change(&mut taught, &mut options);
        let options = CorrectOptions { taught: vec![taught], ..options };
        correct(&program, &fixture.fitted, &options).expect_err("no agreement").to_string()
    };
    let moved = failed(&|_, options| options.frames[0].1.translation.z += 0.004);
    assert!(moved.contains("points.csv: line 2: the controller has this point (its origin) at"), "{moved}");
    assert!(moved.contains("4.00 mm from where it has to be"), "{moved}");
    let other = failed(&|taught, _| taught.tool = Some("TOOL_DATA[7]".into()));
    assert!(other.contains("TOOL_DATA[7] has no value"), "{other}");
    let flange = failed(&|taught, _| taught.tool = Some("flange".into()));
    assert!(flange.contains("another tool (flange)"), "{flange}");
    let two = failed(&|taught, _| taught.touched.truncate(2));
    assert!(two.contains("three points make a frame (origin, x, xy), and 2 are there"), "{two}");
    let words = failed(&|taught, _| taught.touched[1].word = "z".into());
    assert!(words.contains("its points are called origin, z, xy"), "{words}");
    let line = failed(&|taught, _| taught.touched[2].joints = taught.touched[1].joints.clone());
    assert!(line.contains("mm from where") || line.contains("one line"), "{line}");
    let far = failed(&|taught, _| taught.touched[0].joints[0] = 9.0);
    assert!(far.contains("line 2: it is outside of the data of the fit"), "{far}");
}

#[test]
fn a_tool_that_was_taught_at_a_fixed_tip_is_corrected_as_well() {
    let (fixture, taught) = Fixture::with_a_taught_tool();
    let unstated = rms(&fixture.corrected(&fixture.options()));
    let options = CorrectOptions { taught: vec![taught], ..fixture.options() };
    let right = rms(&fixture.corrected(&options));
    println!("taught tool as it is {unstated:e}, taught {right:e} m");
    assert!(right < 1e-4 && right < 0.4 * unstated, "{right:e} m, without {unstated:e} m");
    let program = Program::read(fixture.text().as_bytes(), &[], Dialect::Krl).expect("a program");
    let mut options = options;
    options.tools[0].1.translation.x += 0.02;
    let error = correct(&program, &fixture.fitted, &options).expect_err("another tool").to_string();
    assert!(error.contains("tip.csv: from these joints the controller has the tip at"), "{error}");
}

#[test]
fn the_real_robot_misses_what_remains_of_an_offset() {
    let mut fixture = Fixture::new();
    let base = installation(&fixture.fitted).expect("an installation").base;
    // The frame is where it was measured.
    fixture.frame = base.inverse() * fixture.real;
    let options = fixture.options();
    let program = Program::read(fixture.text().as_bytes(), &[], Dialect::Krl).expect("a program");
    let before = fixture.misses(&program);
    let (found, refused) = fixture.offset(&fixture.text(), &options);
    assert_eq!(refused, ["points in joint values have no frame: no offset corrects them (1)"]);
    let [offset] = &found[..] else { panic!("{found:?}") };
    assert!(!offset.tool && offset.name == "BASE_DATA[2]" && offset.points.len() == 27);
    fixture.frame = offset.value;
    let after = fixture.misses(&program);
    for ((point, before), after) in offset.points.iter().zip(&before).zip(&after) {
        assert!((point.before - before).abs() < 2e-5, "{point:?} {before}");
        assert!((point.after - after).abs() < 5e-5, "{point:?} {after}");
    }
    let [rms, left] = offset.rms();
    println!("mm RMS: {:.3} before, {:.3} with the offset of the frame", 1e3 * rms, 1e3 * left);
    assert!(left < 0.5 * rms, "{rms} {left}");
}

#[test]
fn points_in_the_base_get_an_offset_of_the_tool_and_few_points_none_that_does_not_help() {
    let fixture = Fixture::new();
    let mut options = fixture.options();
    // The same poses in the base, on a place away from the fixture.
    let frame = fixture.frame;
    let mut based = fixture.text().lines().take(4).collect::<Vec<_>>().join("\n") + "\n";
    for pose in &fixture.points[..6] {
        let at = frame * *pose;
        let ([x, y, z], [c, b, a]) =
            ([0, 1, 2].map(|k| 1e3 * at.translation[k]), at.rpy().map(f64::to_degrees));
        based += &format!("LIN {{X {x:.6},Y {y:.6},Z {z:.6},A {a:.7},B {b:.7},C {c:.7}}}\n");
    }
    let based = based.replace("BASE_DATA[2]", "$NULLFRAME");
    options.frames.clear();
    let (found, refused) = fixture.offset(&based, &options);
    println!("{refused:?} {:?}", found.iter().map(Offset::rms).collect::<Vec<_>>());
    let helps =
        found.iter().all(|offset| offset.tool && offset.name == "TOOL_DATA[1]" && offset.points.len() == 6);
    let words = "TOOL_DATA[1]: no offset improves its 6 points";
    assert!(helps && found.len() + usize::from(refused.iter().any(|other| other.starts_with(words))) == 1);
    // The tool of points in a frame and in the base: its new value moves both.
    let points: String = based.lines().skip(4).map(|line| format!("{line}\n")).collect();
    let head: String = fixture.text().lines().take(4).map(|line| format!("{line}\n")).collect();
    let both = format!("{head}{points}$BASE=$NULLFRAME\n{points}");
    let frames = vec![("BASE_DATA[2]".into(), Pose::IDENTITY)];
    let (found, words) = fixture.offset(&both, &CorrectOptions { frames, ..options.clone() });
    assert!(found.len() == 2 && found.iter().any(|offset| offset.tool), "{found:?} {words:?}");
    let twice = "points in BASE_DATA[2] have this tool as well, and would be corrected twice";
    assert!(words.iter().any(|words| words.contains(twice)), "{words:?}");
    // Neither a frame nor a tool: nothing can be set.
    let (found, _) = fixture.offset(&based.replace("TOOL_DATA[1]", "$NULLFRAME"), &options);
    assert!(found.is_empty(), "{found:?}");
}
