//! Growth with a temperature, a gradient, or what heats itself.

use super::*;
use crate::testkit::{check_effect, emitted};
use truepose_kinematics::Site;
use truepose_kinematics::{Conditions, samples};

#[test]
fn conforms() {
    for chain in samples::all() {
        for spot in [Spot::Frame(FrameId::BASE), Spot::Frame(chain.tool_frame())] {
            check_effect(&Thermal::of(spot, "t"), &chain);
        }
        for &joint in chain.movable().iter().filter(|&&j| chain.link_length(j) > 0.01) {
            check_effect(&Thermal::of(Spot::Joint(joint), "t"), &chain);
            let (lag, lag_range) = (Some(600.0), Some([60.0, 7200.0]));
            let grows = Some(Grows::Motion);
            let late = Thermal { lag, lag_range, grows, ..Thermal::of(Spot::Joint(joint), "t") };
            check_effect(&late, &chain);
        }
        check_effect(&Thermal::arm("t"), &chain);
        check_effect(&Thermal::gradient(Spot::Frame(FrameId::BASE), "t", "u"), &chain);
        let (second_lag, second_lag_range) = (Some(6000.0), Some([600.0, 72000.0]));
        let (lag, lag_range) = (Some(600.0), Some([60.0, 7200.0]));
        let two = Thermal { lag, lag_range, second_lag, second_lag_range, ..Thermal::arm("t") };
        check_effect(&two, &chain);
        let two = Thermal { spot: Spot::Frame(chain.tool_frame()), grows: None, lag_range: None, ..two };
        check_effect(&two, &chain);
        check_effect(&Thermal::by(Spot::Frame(FrameId::BASE), History::Travel(JointId(1)), 300.0), &chain);
        let slides = |joint: &&JointId| chain.joint(**joint).kind == JointKind::Prismatic;
        for &joint in chain.movable().iter().filter(slides) {
            check_effect(&Thermal { offset: true, ..Thermal::of(Spot::Joint(joint), "t") }, &chain);
        }
    }
}

#[test]
fn an_upper_arm_grows_along_itself_in_every_convention() {
    for (chain, along) in [(samples::ur10(), -0.612), (samples::heavy(), 1.1)] {
        let effect = Thermal::of(Spot::Joint(JointId(2)), "t");
        let mut conditions = Conditions::at(&chain, &[0.2; 6]);
        conditions.channels = vec![23.0];
        let entries = emitted(&effect, &chain, &conditions);
        assert_eq!(entries[0].site, Site::Frame(FrameId(2), Axis::Tx));
        assert!((entries[0].value - 3.0 * along).abs() < 1e-12, "{}", entries[0].value);
        assert!(entries[1].value.abs() < 1e-12 && entries[2].value.abs() < 1e-12);
    }
}

#[test]
fn a_late_body_asks_for_a_derived_column() {
    let late = Thermal { lag: Some(600.0), ..Thermal::of(Spot::Frame(FrameId::BASE), "temperature") };
    assert_eq!(Effect::needs(&late), [Signal::Channel("temperature~lag=600".into())]);
}

#[test]
fn a_gradient_is_a_difference_and_an_arm_grows_in_all_its_lengths() {
    let chain = samples::pps();
    let mut conditions = Conditions::at(&chain, &[0.4, 0.3, 0.2, 0.1, 0.0, 0.0]);
    conditions.channels = vec![23.0, 21.5];
    let tilt = Thermal::gradient(Spot::Frame(FrameId::BASE), "warm", "cool");
    assert_eq!(Effect::needs(&tilt), [Signal::Channel("warm".into()), Signal::Channel("cool".into())]);
    assert!(emitted(&tilt, &chain, &conditions).iter().all(|e| (e.value - 1.5).abs() < 1e-15));
    // Each part of the arm as it would grow alone.
    let mut alone = Vec::new();
    for &joint in chain.movable() {
        for grows in [Grows::Scale, Grows::Length] {
            let one = Thermal { grows: Some(grows), ..Thermal::of(Spot::Joint(joint), "warm") };
            if Effect::validate(&one, &chain).is_ok() {
                alone.extend(emitted(&one, &chain, &conditions));
            }
        }
    }
    let whole = emitted(&Thermal::arm("warm"), &chain, &conditions);
    let sum = |list: &[crate::Entry], k: usize| -> f64 {
        list.iter().filter(|e| chain.site_index(e.site) == k).map(|e| e.value).sum()
    };
    for k in 0..chain.site_count() {
        assert!((sum(&whole, k) - sum(&alone, k)).abs() < 1e-12, "{k}");
    }
    assert!(whole.iter().any(|e| e.value.abs() > 0.1));
}

#[test]
fn what_heats_itself_reads_a_history_from_zero_on() {
    let chain = samples::ur10();
    let heats = Thermal::by(Spot::Joint(JointId(2)), History::Travel(JointId(2)), 300.0);
    let heats = Thermal { grows: Some(Grows::Motion), reference: 20.0, ..heats };
    assert_eq!(Effect::needs(&heats), [Signal::Channel("travel_2~lag=300".into())]);
    assert_eq!(Effect::columns(&heats, &chain)[0].unit, "rad/(1/s)");
    let mut conditions = Conditions::at(&chain, &[0.1; 6]);
    conditions.channels = vec![0.04];
    let sum: f64 = emitted(&heats, &chain, &conditions).iter().map(|e| e.value).sum();
    assert!((sum - 0.04).abs() < 1e-15, "{sum}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let error = |effect: Thermal| Effect::validate(&effect, &samples::pps()).unwrap_err().to_string();
    let scale = Thermal { grows: Some(Grows::Scale), ..Thermal::of(Spot::Joint(JointId(4)), "t") };
    assert_eq!(error(scale), "effect `thermal`: joint `theta` turns; the scale that grows is a slide's");
    let frame = Thermal { grows: Some(Grows::Length), ..Thermal::of(Spot::Frame(FrameId(0)), "t") };
    assert!(error(frame).contains("`components`"));
    let base = Thermal { offset: true, ..Thermal::of(Spot::Frame(FrameId(0)), "t") };
    assert_eq!(
        error(base),
        "effect `thermal`: `offset` belongs to a slide's scale; elsewhere the constants have it"
    );
}

#[test]
fn a_slide_may_be_wrong_before_it_grows() {
    let chain = samples::pps();
    let joint = JointId(1);
    let effect = Thermal { offset: true, ..Thermal::of(Spot::Joint(joint), "t") };
    let mut conditions = Conditions::at(&chain, &[0.4, 0.4, 0.4, 0.0, 0.0, 0.0]);
    conditions.channels = vec![25.0];
    let size = |column: usize| -> f64 {
        let entries = emitted(&effect, &chain, &conditions);
        entries.iter().filter(|e| e.column == column).map(|e| e.value.powi(2)).sum::<f64>().sqrt()
    };
    // Five kelvin above the room, 0.4 m from zero.
    assert!((size(0) - 5.0 * 0.4).abs() < 1e-12 && (size(1) - 0.4).abs() < 1e-12);
}
