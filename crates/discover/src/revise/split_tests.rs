//! Splitting on small data of an arm whose weights nobody declared: drives that yield, and a link that bends.

use crate::problem::synthetic::{data_of, normal};
use crate::revise::reconsider::reconsidered;
use crate::revise::synthetic::with_findings;
use nalgebra::Vector3;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::Geometric;
use truepose_kinematics::{Chain, Conditions, Joint, PostureBuffer};

/// Upper arm and forearm of a pose: (root, tip) of both, and the tool, m.
struct Arm {
    upper: [Vector3<f64>; 2],
    fore: [Vector3<f64>; 2],
    tool: Vector3<f64>,
}

impl Arm {
    /// How far the tool moves, m, where what lies beyond a point turns under a weight along each part, rad.
    fn turned(&self, about: Vector3<f64>, [by_upper, by_fore]: [f64; 2]) -> Vector3<f64> {
        let falls = |[root, tip]: [Vector3<f64>; 2]| (tip - root).normalize().cross(&-Vector3::z());
        let turn = by_upper * falls(self.upper) + by_fore * falls(self.fore);
        turn.cross(&(self.tool - about))
    }
}

/// What reconsideration makes of a link that bends: the words of its findings, and of what would explain two of them as one.
fn reconsidering(moved: impl Fn(&Arm) -> Vector3<f64>) -> [Vec<String>; 2] {
    let (chain, mut rows) = data_of(60, 9, &<[f64]>::to_vec, &|_, joints, row| {
        let chain = truepose_kinematics::samples::ur10();
        let (mut buffer, conditions) = (PostureBuffer::new(&chain), Conditions::at(&chain, joints));
        let posture = buffer.update(&chain, &conditions);
        let ends = |k: usize| {
            let span = posture.span(chain.movable()[k]);
            [span.root, span.tip]
        };
        let arm = Arm { upper: ends(1), fore: ends(2), tool: posture.tool().translation };
        let moved = moved(&arm);
        std::array::from_fn(|axis| moved[axis] + 2e-5 * normal(3 * row + axis))
    });
    rows.orientation.fill(None);
    rows.load.fill(truepose_kinematics::Load::None);
    let joints: Vec<Joint> =
        chain.joints().iter().map(|joint| Joint { link: None, ..joint.clone() }).collect();
    let chain = Chain::new("arm", joints).unwrap();
    let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
    let mut seen = [Vec::new(), Vec::new()];
    with_findings((&chain, &rows), &declared, &["link_compliance j2"], |context, model, multiplicity| {
        let (model, _) = reconsidered(context, model.clone(), 1, multiplicity).unwrap();
        let instead = model.findings.iter().flat_map(|finding| &finding.instead);
        seen = [
            model.findings.iter().map(|finding| finding.candidate.words()).collect(),
            instead.map(|(candidate, _)| candidate.words()).collect(),
        ];
    });
    seen
}

#[test]
fn two_drives_take_the_place_of_the_link_that_imitates_them() {
    let drives = |arm: &Arm| arm.turned(arm.upper[0], [3e-4, 2e-4]) + arm.turned(arm.fore[0], [0.0, 3e-4]);
    let [found, instead] = reconsidering(drives);
    assert_eq!(found, ["joint_compliance j2", "joint_compliance j3"]);
    assert_eq!(instead, ["link_compliance j2", "link_compliance j2"]);
}

#[test]
fn a_link_that_bends_stays() {
    // A weight at the tip of a beam turns it about a third of its length, the moment of the forearm about its middle.
    let bends = |arm: &Arm| {
        let at = |share: f64| arm.upper[0] + share * (arm.upper[1] - arm.upper[0]);
        arm.turned(at(1.0 / 3.0), [4e-4, 0.0]) + arm.turned(at(0.5), [0.0, 4e-4])
    };
    let [found, instead] = reconsidering(bends);
    assert_eq!(found, ["link_compliance j2"]);
    assert!(instead.is_empty());
}

#[test]
fn one_drive_takes_the_place_of_the_link_alone() {
    let [found, instead] = reconsidering(|arm| arm.turned(arm.upper[0], [4e-4, 3e-4]));
    assert_eq!(found, ["joint_compliance j2"]);
    assert!(instead.is_empty());
}
