//! Arms on a track and below a gantry: the true simulated robot is driven to the corrected points of a program whose external axes
//! are joints of the fit. The controller is plain code here: Newton's method on its nominal robot, with the external axes where the program has them.

use crate::programs::{arm, identified_from, plant, solved};
use crate::taught_frames::{rms, three_points};
use nalgebra::{DMatrix, DVector, Unit, Vector3};
use truepose_compensate::installation;
use truepose_controllers::{CorrectOptions, Dialect, Outcome, Program, Taught, Touched, Value, correct};
use truepose_errormodel::FittedModel;
use truepose_kinematics::{
    Chain, Conditions, Joint, JointKind, Load, Payload, Placement, Pose, rotation_log, rotation_vector,
};
use truepose_simulate::{Campaign, Plant};

/// External axes of a point.
type External = Vec<(String, f64)>;

const NEAR: [f64; 6] = [0.5, -1.2, 1.3, 0.3, 0.9, 0.2];

fn slide(name: &str, at: Pose, axis: [f64; 3], limit: f64) -> Joint {
    let axis = Unit::new_normalize(Vector3::from(axis));
    Joint::new(name, JointKind::Prismatic, Placement::Origin { pose: at, axis })
        .with_limits(-limit, limit)
        .with_link(400.0, [0.0, 0.0, 0.1])
}

/// The heavy arm on these axes.
fn on(slides: Vec<Joint>) -> Chain {
    let heavy = arm(false);
    let joints = slides.into_iter().chain(heavy.joints().iter().cloned()).collect();
    let chain = Chain::new("rider", joints).and_then(|chain| chain.with_base(*heavy.base()));
    chain.and_then(|chain| chain.with_tool(*heavy.tool())).expect("an arm")
}

/// A robot whose first joints are external axes of the program, E1 and so on.
struct Rider {
    plant: Plant,
    fitted: FittedModel,
    /// Base and tool that the fit has found, and the controller's tool.
    base: Pose,
    tool: Pose,
    load: Load,
    mass: f64,
    com: Vector3<f64>,
}

impl Rider {
    fn new(chain: &Chain) -> Rider {
        let plant = plant(chain);
        let campaign = Campaign::random(chain, 300, 11).expect("a campaign");
        let campaign = campaign.with_some_payload(&[0.0, 40.0, 80.0], [0.0, 0.0, 0.15], 0.05, 3).shuffled(5);
        let fitted = identified_from(&plant, &campaign);
        let found = installation(&fitted).expect("an installation");
        let (mass, com) = (60.0, Vector3::new(0.02, -0.03, 0.2));
        // The centre is stated in the flange; the plant has it in the tool.
        let com_in_tool = chain.tool().pose.inverse().apply(&com);
        let load = Load::Payload(Payload { mass, com: com_in_tool });
        Rider { plant, fitted, base: found.base, tool: found.tool, load, mass, com }
    }

    fn chain(&self) -> &Chain {
        self.plant.chain()
    }

    fn externals(&self) -> usize {
        self.chain().movable().len() - 6
    }

    /// The controller's tool in its base.
    fn nominal(&self, joints: &[f64]) -> Pose {
        let chain = self.chain();
        chain.base().pose.inverse() * chain.forward(joints) * chain.tool().pose.inverse() * self.tool
    }

    fn really(&self, joints: &[f64]) -> Pose {
        let conditions = Conditions::at(self.chain(), joints).with_load(self.load);
        self.plant.true_pose(&conditions).expect("a pose")
    }

    fn free(&self) -> Vec<usize> {
        (self.externals()..self.chain().movable().len()).collect()
    }

    /// Joints of 36 points, with the external axes at several places.
    fn list(&self) -> Vec<Vec<f64>> {
        let one = |k: usize| {
            let wave = |n: usize, size: f64| size * (1.7 * (k * n) as f64 + n as f64).sin();
            let mut joints: Vec<f64> = (0..self.externals())
                .map(|n| wave(n + 1, 0.35) + if k.is_multiple_of(3) { 0.2 } else { 0.0 })
                .collect();
            joints.extend(NEAR.iter().enumerate().map(|(n, q)| q + wave(n + 3, 0.25)));
            joints
        };
        (0..36).map(one).collect()
    }

    fn text(&self, frame: &Pose, list: &[Vec<f64>]) -> String {
        let axes = |joints: &[f64]| {
            (0..self.externals()).map(|n| format!(",E{} {:.6}", n + 1, 1e3 * joints[n])).collect::<String>()
        };
        let first: Vec<String> = (0..6).map(|k| format!("A{} {:.6}", k + 1, NEAR[k].to_degrees())).collect();
        let com = 1e3 * self.com;
        let mut text = format!(
            "DEF a()\n$BASE=BASE_DATA[2]\n$TOOL=TOOL_DATA[1]\n$LOAD={{M {},CM {{X {},Y {},Z {},A 0,B 0,C 0}},J {{X 0,Y 0,Z 0}}}}\n",
            self.mass, com.x, com.y, com.z
        );
        text += &format!("PTP {{{}{}}}\n", first.join(","), axes(&list[0]));
        for joints in list {
            let pose = frame.inverse() * self.nominal(joints);
            let ([x, y, z], [c, b, a]) =
                ([0, 1, 2].map(|k| 1e3 * pose.translation[k]), pose.rpy().map(f64::to_degrees));
            text +=
                &format!("LIN {{X {x:.6},Y {y:.6},Z {z:.6},A {a:.7},B {b:.7},C {c:.7}{}}}\n", axes(joints));
        }
        text + "END\n"
    }

    fn options(&self, frame: Pose, joints: &[&str]) -> CorrectOptions {
        let external = joints.iter().enumerate().map(|(k, name)| (format!("E{}", k + 1), (*name).into()));
        CorrectOptions {
            frames: vec![("BASE_DATA[2]".into(), frame)],
            tools: vec![("TOOL_DATA[1]".into(), self.tool)],
            external: external.collect(),
            program_loads: true,
            limit: 0.05,
            ..CorrectOptions::default()
        }
    }

    /// Errors of the points of a program in a frame of the controller, against the same points in the real frame (measurement frame).
    fn misses(&self, text: &[u8], frame: &Pose, real: &Pose, meant: &[Pose]) -> Vec<f64> {
        let program = Program::read(text, &[], Dialect::Krl).expect("a program");
        let poses = program.points().iter().filter_map(|point| match &point.value {
            Value::Pose { pose, .. } => Some((*pose, point.external.clone())),
            Value::Joints(_) => None,
        });
        let one = |((pose, external), meant): ((Pose, External), &Pose)| {
            let mut start: Vec<f64> =
                external.iter().take(self.externals()).map(|(_, value)| 1e-3 * value).collect();
            start.extend(NEAR);
            let joints = solved(|q| self.nominal(q), &(*frame * pose), &start, &self.free());
            (self.really(&joints).translation - real.apply(&meant.translation)).norm()
        };
        poses.zip(meant).map(one).collect()
    }

    /// Misses before and after, and the largest of the expected ones.
    fn driven(&self, options: &CorrectOptions, frame: &Pose, real: &Pose) -> [Vec<f64>; 3] {
        let list = self.list();
        let text = self.text(frame, &list);
        let meant: Vec<Pose> = list.iter().map(|q| frame.inverse() * self.nominal(q)).collect();
        let program = Program::read(text.as_bytes(), &[], Dialect::Krl).expect("a program");
        let corrections = correct(&program, &self.fitted, options).expect("corrections");
        for one in &corrections {
            assert!(one.outcome != Outcome::Refused, "{one:?}");
            let (Some(nominal), Some(corrected)) = (&one.nominal, &one.corrected) else { continue };
            for k in 0..self.externals() {
                assert!((nominal[k] - corrected[k]).abs() < 1e-12, "an external axis moves: {one:?}");
            }
        }
        let new: Vec<_> = corrections.iter().map(|one| one.replacement.clone()).collect();
        let out = program.rewritten(&new).expect("a program");
        let external = |text: &[u8]| {
            let program = Program::read(text, &[], Dialect::Krl).expect("a program");
            program.points().iter().map(|point| point.external.clone()).collect::<Vec<_>>()
        };
        assert_eq!(external(text.as_bytes()), external(&out));
        let within = corrections.iter().skip(1).map(|one| one.within_95.expect("a bound")).collect();
        [self.misses(text.as_bytes(), frame, real, &meant), self.misses(&out, frame, real, &meant), within]
    }

    /// A frame that was measured, and one that was taught at one place of the external axes.
    fn check(&self, name: &str, joints: &[&str]) {
        let at = self.nominal(&[&vec![0.1; self.externals()][..], &NEAR].concat());
        let frame = Pose::new(rotation_vector(&Vector3::new(0.05, -0.1, 0.6)), at.translation);
        let options = self.options(frame, joints);
        let [before, after, within] = self.driven(&options, &frame, &(self.base * frame));
        println!("{name}, measured frame: {:.3e} → {:.3e} m", rms(&before), rms(&after));
        assert!(rms(&after) < 0.1 * rms(&before), "{name}: {:e} → {:e} m", rms(&before), rms(&after));
        assert_never_worse(name, &before, &after, &within);

        // The robot is jogged until it touches, with its load.
        let real = self.base * Pose::new(frame.rotation, at.translation);
        let start = [&vec![0.1; self.externals()][..], &NEAR].concat();
        let turned = self.really(&start).rotation;
        let corners = [Vector3::zeros(), Vector3::new(0.4, 0.0, 0.0), Vector3::new(0.05, 0.3, 0.0)];
        let touches = corners.map(|corner| {
            let wanted = Pose::new(turned, real.apply(&corner));
            solved(|q| self.really(q), &wanted, &start, &self.free())
        });
        let tips: Vec<Vector3<f64>> = touches.iter().map(|q| self.nominal(q).translation).collect();
        let frame = three_points(&tips);
        let touched = |(k, q): (usize, &Vec<f64>)| Touched {
            word: ["origin", "x", "xy"][k].into(),
            line: k + 2,
            joints: q.clone(),
            load: Some(self.load),
        };
        let touched = touches.iter().enumerate().map(touched).collect();
        let taught = Taught { name: "BASE_DATA[2]".into(), tool: None, file: "points.csv".into(), touched };
        let plain = self.options(frame, joints);
        let [before, unstated, _] = self.driven(&plain, &frame, &real);
        let options = CorrectOptions { taught: vec![taught], ..plain };
        let [_, after, within] = self.driven(&options, &frame, &real);
        println!(
            "{name}, taught frame: {:.3e} → {:.3e} m, as if measured {:.3e} m",
            rms(&before),
            rms(&after),
            rms(&unstated)
        );
        assert!(rms(&after) < 0.2 * rms(&before), "{name}: {:e} → {:e} m", rms(&before), rms(&after));
        assert_never_worse(name, &before, &after, &within);
    }
}

/// Relative to the fixture no point is worse than it was, within what the program states that it may miss.
pub fn assert_never_worse(name: &str, before: &[f64], after: &[f64], within: &[f64]) {
    let mut outside = 0;
    for (k, ((before, after), within)) in before.iter().zip(after).zip(within).enumerate() {
        assert!(
            *after < before.max(*within),
            "{name}, point {k}: {before:e} → {after:e} m, within {within:e}"
        );
        outside += usize::from(after > within);
    }
    // 95 % without the noise of a measurement, which the bound includes.
    assert!(outside * 20 <= after.len(), "{name}: {outside} of {} beyond their bound", after.len());
}

#[test]
fn an_arm_on_a_track_carries_its_load_to_the_corrected_points() {
    let chain = on(vec![slide("track", Pose::IDENTITY, [0.0, 1.0, 0.0], 1.5)]);
    Rider::new(&chain).check("track", &["track"]);
}

#[test]
fn an_arm_below_a_gantry_comes_to_the_corrected_points() {
    let hung = Pose::from_xyz_rpy([0.0, 0.1, -0.3], [std::f64::consts::PI, 0.0, 0.0]);
    let chain = on(vec![
        slide("gx", Pose::from_xyz_rpy([0.0, 0.0, 3.0], [0.0; 3]), [1.0, 0.0, 0.0], 1.5),
        slide("gy", Pose::from_xyz_rpy([0.1, 0.0, 0.2], [0.0; 3]), [0.0, 1.0, 0.0], 1.0),
        slide("gz", hung, [0.0, 0.0, 1.0], 0.6),
    ]);
    Rider::new(&chain).check("gantry", &["gx", "gy", "gz"]);
}
