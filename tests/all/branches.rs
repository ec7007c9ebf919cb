//! Two arms on a torso: identified together, a gear hidden in the torso found from either hand, and each hand brought where it should be
//! while the other arm stays. The truth has transforms of its own.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_compensate::{Compensator, CompensatorOptions, Status, Target};
use truepose_discover::{DiscoverOptions, diagnose};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{AnyEffect, Dataset, DatasetBuilder, Measurement};
use truepose_kinematics::nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use truepose_kinematics::{Chain, Conditions, JointId, Placement, Pose, TargetId, ToolId, samples};
use truepose_solvers::PivotedQr;

/// Noise, m.
const NOISE: f64 = 2e-5;
/// The gear of the torso: rad, and turns of its error a turn of the joint.
const GEAR: (f64, f64) = (4e-4, 90.0);

/// The real robot: a small displacement behind every joint, and an eccentric gear in the second one.
struct Real<'a> {
    chain: &'a Chain,
    displaced: Vec<Isometry3<f64>>,
}

fn isometry(pose: &Pose) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(pose.rotation));
    Isometry3::from_parts(Translation3::from(pose.translation), rotation)
}

impl<'a> Real<'a> {
    fn new(chain: &'a Chain, rng: &mut ChaCha8Rng) -> Self {
        let mut three = |size: f64| Vector3::from_fn(|_, _| size * rng.random_range(-1.0..1.0));
        let displaced = chain.joints().iter().map(|_| Isometry3::new(three(5e-4), three(8e-4))).collect();
        Real { chain, displaced }
    }

    /// A target in the base frame, m.
    fn point(&self, q: &[f64], target: TargetId) -> Vector3<f64> {
        let mut behind = vec![Isometry3::identity()];
        for (k, joint) in self.chain.joints().iter().enumerate() {
            let Placement::Origin { pose, axis } = joint.placement else { panic!("another robot") };
            let value = self.chain.coordinate(JointId(k + 1)).map_or(0.0, |c| q[c]);
            let slip = if k == 1 { GEAR.0 * (GEAR.1 * value + 0.4).sin() } else { 0.0 };
            let turn = UnitQuaternion::from_axis_angle(&axis, value + slip);
            let on = behind[self.chain.before(JointId(k + 1)).0];
            behind.push(on * isometry(&pose) * turn * self.displaced[k]);
        }
        let seen = &self.chain.targets()[target.0];
        let tool = &self.chain.tools()[seen.tool.0];
        (behind[tool.frame.0] * isometry(&tool.placed.pose) * Point3::from(seen.position)).coords
    }
}

fn joints(rng: &mut ChaCha8Rng, chain: &Chain) -> Vec<f64> {
    (0..chain.movable().len()).map(|k| rng.random_range(-1.0..1.0) * if k == 1 { 0.5 } else { 1.2 }).collect()
}

fn measured(real: &Real<'_>, poses: usize, rng: &mut ChaCha8Rng) -> Dataset {
    let mut builder = DatasetBuilder::new(real.chain);
    for pose in 0..poses {
        let q = joints(rng, real.chain);
        for target in [TargetId(0), TargetId(1)] {
            let noise = Vector3::from_fn(|_, _| NOISE * 1.73 * rng.random_range(-1.0..1.0));
            let at = real.point(&q, target) + noise;
            builder.push(Measurement::at(q.clone()).position(at).target(target).visit(pose as u64)).unwrap();
        }
    }
    builder.finish()
}

#[test]
fn a_gear_in_the_torso_of_two_arms_is_found_and_both_hands_are_corrected() {
    let chain = samples::dual();
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let real = Real::new(&chain, &mut rng);
    let data = measured(&real, 130, &mut rng);
    data.validate(&chain).unwrap();
    assert_eq!((data.tool(0), data.tool(1)), (ToolId(0), ToolId(1)));
    let declared: [Box<dyn AnyEffect>; 1] = [Box::new(Geometric::default())];
    let options = DiscoverOptions { seed: 1, rotations: 199, ..DiscoverOptions::default() };
    let found = diagnose(&chain, &declared, &data, &PivotedQr::default(), &options, &|_| ()).unwrap();
    let words: Vec<String> = found.findings.iter().map(|f| f.candidate.words()).collect();
    assert_eq!(words, ["transmission torso_pitch"]);

    let fitted = &found.fit.fitted;
    for (tool, target) in [(ToolId(0), TargetId(0)), (ToolId(1), TargetId(1))] {
        let options = CompensatorOptions { tool, ..CompensatorOptions::default() };
        let mut compensator = Compensator::bind(fitted, &data.schema, options).unwrap();
        let (mut before, mut after) = (0.0, 0.0);
        for _ in 0..40 {
            let q = joints(&mut rng, &chain).iter().map(|v| 0.8 * v).collect::<Vec<f64>>();
            let wanted = chain.forward_to(tool, &q).apply(&chain.targets()[target.0].position);
            let conditions = Conditions {
                tool,
                channels: vec![0.0; data.schema.channels.len()],
                ..Conditions::at(&chain, &q)
            };
            let command = compensator.command(&Target::at(wanted).of(Some(target)), &conditions, Some(&q));
            assert_eq!(command.status, Status::Ok);
            for (k, &joint) in chain.movable().iter().enumerate() {
                let carries = chain.carries(chain.frame_after(joint), tool);
                assert!(carries || (command.joints[k] - q[k]).abs() < 1e-8, "the other arm moves");
            }
            before += (real.point(&q, target) - wanted).norm_squared();
            after += (real.point(&command.joints, target) - wanted).norm_squared();
        }
        let rms = |sum: f64| 1e3 * (sum / 40.0_f64).sqrt();
        println!("tool {}: {:.3} mm before, {:.4} mm after", tool.0, rms(before), rms(after));
        assert!(rms(before) > 0.5 && rms(after) < 0.03, "{} {}", rms(before), rms(after));
    }
}
