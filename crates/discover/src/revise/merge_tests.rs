//! Merging on small data: two findings of one joint for one cause, and two findings for two causes.

use super::*;
use crate::hypotheses::constant::OfFrames;
use crate::hypotheses::coupling::Drag;
use crate::hypotheses::guideway::Rail;
use crate::hypotheses::place::Place;
use crate::hypotheses::variant::Variant;
use crate::problem::synthetic::{data_of, normal};
use crate::revise::synthetic::with_findings;
use std::sync::Arc;
use truepose_errormodel::effects::{Coupling, Geometric, Guideway, JointCompliance};
use truepose_errormodel::{AnyEffect, Dataset};
use truepose_identify::Fit;
use truepose_kinematics::{Chain, JointId};

#[test]
fn a_guideway_and_its_coupling_to_another_joint_have_a_common_driver() {
    let at = |joint: &str| Place { joint: Some(joint.into()), ..Place::default() };
    let rail = Candidate::new(Arc::new(Rail), Variant::new(at("d1"), Guideway::of(JointId(1))));
    let dragged = |driver: &str| {
        let place = Place { driver: Some(driver.into()), ..at("d3") };
        Candidate::new(Arc::new(Drag), Variant::new(place, Coupling::of(JointId(3), JointId(1))))
    };
    assert!(have_common_driver(&rail, &dragged("d1")));
    assert!(!have_common_driver(&rail, &dragged("d2")));
    let frame = Candidate::new(Arc::new(OfFrames), Variant::new(at("d1"), Guideway::of(JointId(1))));
    assert!(!have_common_driver(&rail, &frame));
}

/// A model whose findings are the two candidates of these words, given to `see` with what merging makes of it.
fn merging(
    (chain, rows): &(Chain, Dataset),
    pair: [&str; 2],
    see: impl FnOnce(&Context<'_>, &Model, Option<Model>),
) {
    let declared: Vec<Box<dyn AnyEffect>> =
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())];
    with_findings((chain, rows), &declared, &pair, |context, both, multiplicity| {
        assert_eq!(both.findings.len(), 2);
        let (after, changed) = merged(context, both.clone(), 0, multiplicity).unwrap();
        see(context, both, changed.then_some(after));
    });
}

/// Rows of an arm whose third joint has a transmission error of 0.4 mrad; `rise` moves what is measured along the base's z axis, m.
fn measured(rise: impl Fn(f64) -> f64) -> (Chain, Dataset) {
    let actual = |joints: &[f64]| {
        let mut actual = joints.to_vec();
        actual[2] += 4e-4 * (2.0 * joints[2]).sin();
        actual
    };
    data_of(60, 6, &actual, &|_, joints, row| {
        let mut moved = std::array::from_fn(|axis| 2e-5 * normal(3 * row + axis));
        moved[2] += rise(joints[2]);
        moved
    })
}

#[test]
fn two_curves_of_a_joint_become_the_cause_that_explains_both_and_the_model_is_fitted_again() {
    let pair = ["unmodelled j3 rz on j3", "unmodelled j2 rz on j3"];
    merging(&measured(|_| 0.0), pair, |context, both, after| {
        let after = after.expect("merged");
        let [one] = &after.findings[..] else { panic!("one finding in place of two") };
        assert_eq!(one.candidate.words(), "transmission j3");
        // Its evidence is its own: it was found by neither of the pair.
        assert!(one.evidence.gain > 0.0 && one.evidence.unknowns <= both.findings[0].evidence.unknowns);
        // The fit is that of the declared model with this finding alone, from nothing.
        let alone = context.fit_model(vec![one.candidate.clone()], &[]).unwrap();
        let unknowns = |fit: &Fit| fit.solution.x.len();
        assert_eq!(unknowns(&after.current.fit), unknowns(&alone.fit));
        assert!(unknowns(&after.current.fit) < unknowns(&both.current.fit));
        let apart = (after.current.fit.chi_square / alone.fit.chi_square - 1.0).abs();
        assert!(apart < 1e-9, "{apart}");
        assert!(after.current.fit.converged);
    });
}

#[test]
fn two_findings_of_a_joint_for_two_causes_stay() {
    let pair = ["transmission j3", "unmodelled base z on j3"];
    merging(&measured(|angle| 2e-4 * (3.0 * angle).cos()), pair, |_, _, after| {
        assert!(after.is_none());
    });
}
