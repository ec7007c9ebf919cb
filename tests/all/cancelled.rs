//! An observer that breaks ends a run before its next step, with an error that says so; one that returns nothing only listens.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use truepose_discover::{DiscoverError, DiscoverOptions, Progress, diagnose, nested};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{AnyEffect, Dataset};
use truepose_identify::{IdentificationOptions, IdentifyError, Split, Step, identify};
use truepose_kinematics::{Chain, samples};
use truepose_simulate::{Campaign, Plant, PlantOptions};
use truepose_solvers::PivotedQr;

fn measured() -> (Chain, Dataset) {
    let chain = samples::ur10();
    let plant = Plant::random(&chain, &PlantOptions::default(), 1).unwrap();
    let data = plant.measure(&Campaign::random(&chain, 40, 1).unwrap(), 1).unwrap();
    (chain, data)
}

fn declared() -> [Box<dyn AnyEffect>; 1] {
    [Box::new(Geometric::default())]
}

#[test]
fn identify_ends_at_the_step_at_which_its_observer_breaks() {
    let (chain, data) = measured();
    let (solver, options) = (PivotedQr::default(), IdentificationOptions::default());
    for (last, count) in [(Step::Placing, 1), (Step::Fitting, 3), (Step::Judging, 5)] {
        let seen = RefCell::new(Vec::new());
        let observer = |step| {
            seen.borrow_mut().push(step);
            if step == last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let ended = identify(&chain, &declared(), &data, &solver, &options, &observer);
        assert!(matches!(ended, Err(IdentifyError::Cancelled)));
        assert_eq!((seen.borrow().len(), seen.borrow().last()), (count, Some(&last)));
    }
}

#[test]
fn discover_ends_where_its_observer_breaks_and_nested_in_every_fold() {
    let (chain, data) = measured();
    let (solver, options) = (PivotedQr::default(), DiscoverOptions::default());
    let at_the_screen = |step: Progress| match step {
        Progress::Screening(_) => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let ended = diagnose(&chain, &declared(), &data, &solver, &options, &at_the_screen);
    assert!(matches!(ended, Err(DiscoverError::Identify(IdentifyError::Cancelled))));

    let steps = AtomicUsize::new(0);
    let at_once = |_, _| {
        steps.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Break(())
    };
    let split = Split::Random { folds: 3, seed: 0 };
    let ended = nested(&chain, &declared(), &data, &split, &solver, &options, &at_once);
    assert!(matches!(ended, Err(DiscoverError::Identify(IdentifyError::Cancelled))));
    assert!(steps.into_inner() <= 3);
}
