//! The whole elastic robot against a law that none of its parts knows: Maxwell and Betti.
//!
//! The work of a load A on the displacement that a load B causes is the work of B on that of A. So the compliance
//! matrix of the tool, assembled from beams, drives, bearings and floor, is symmetric; and a robot that stands is
//! positive definite. A wrench or an arm taken about the wrong point, or in the wrong axes, breaks the symmetry.

use truepose_kinematics::nalgebra::{Matrix3, Matrix6, Vector3};
use truepose_kinematics::{Conditions, Load, Wrench};
use truepose_simulate::physics::joint_stiffness::JointStiffness;
use truepose_simulate::{Plant, robots};

/// Small displacement of the tool in its own axes, per newton and newton metre, by central differences.
fn compliance(plant: &Plant, joints: &[f64]) -> Matrix6<f64> {
    let pose = |k: usize, size: f64| {
        let mut six = [0.0; 6];
        six[k] = size;
        let wrench = Wrench {
            force: Vector3::new(six[0], six[1], six[2]),
            moment: Vector3::new(six[3], six[4], six[5]),
        };
        let at = Conditions::at(plant.chain(), joints).with_load(Load::Wrench(wrench));
        plant.true_pose(&at).expect("a pose")
    };
    let mut matrix = Matrix6::zeros();
    for k in 0..6 {
        let (plus, minus) = (pose(k, 1.0), pose(k, -1.0));
        let rotation = (plus.rotation + minus.rotation) / 2.0;
        let moved = rotation.transpose() * (plus.translation - minus.translation) / 2.0;
        let turned: Matrix3<f64> = rotation.transpose() * (plus.rotation - minus.rotation) / 2.0;
        let turned = Vector3::new(turned[(2, 1)], turned[(0, 2)], turned[(1, 0)]);
        matrix.fixed_view_mut::<3, 1>(0, k).copy_from(&moved);
        matrix.fixed_view_mut::<3, 1>(3, k).copy_from(&turned);
    }
    matrix
}

#[track_caller]
fn check(plant: &Plant, joints: &[f64]) {
    // Weightless and linear: the law is one of small displacements about an unloaded robot.
    let mut truth = plant.truth().clone();
    for joint in &mut truth.joints {
        joint.link = None;
        joint.stiffness = JointStiffness { hardens_at: f64::INFINITY, ..joint.stiffness };
    }
    let plant = plant.clone().with_truth(truth).expect("a plant");
    let c = compliance(&plant, joints);
    let name = plant.chain().name();
    // Central differences leave the third order: (1 N · 1.2 m / 1e4 N·m/rad)² = 1e-8 on the softest arm.
    let asymmetry = (c - c.transpose()).amax() / c.amax();
    assert!(asymmetry < 1e-7, "{name}: {asymmetry:e}");
    let least = ((c + c.transpose()) / 2.0).symmetric_eigenvalues().min();
    assert!(least > -1e-9 * c.amax() && c.trace() > 0.0, "{name}: {least:e}");
}

#[test]
fn the_robots_compliance_is_symmetric() {
    check(&robots::heavy_plant(3).expect("a plant"), &[0.4, -0.7, 0.5, 1.1, -0.6, 0.3]);
    check(&robots::pps_plant(3).expect("a plant"), &[0.3, -0.1, -0.6, 0.9, 0.02, -0.03]);
    check(&robots::ur10_plant(3).expect("a plant"), &[0.3, -1.2, 0.9, -0.4, 1.3, 0.2]);
    check(&robots::gantry_plant(3).expect("a plant"), &[1.3, 0.4, 0.7, 1.0]);
    check(&robots::seven_plant(3).expect("a plant"), &[0.3, 0.6, -0.2, 1.1, 0.4, -0.8, 0.1]);
}
