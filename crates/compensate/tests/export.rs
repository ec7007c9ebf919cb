//! Every export is read back and predicted with.

mod fits;

use fits::{Draw, elastic, fitted, of};
use truepose_compensate::{
    AxisLink, AxisTableOptions, CompensateError, ExportOptions, axis_table, corrected_chain, error_tables,
};
use truepose_errormodel::Schema;
use truepose_errormodel::effects::Geometric;
use truepose_kinematics::{Chain, Conditions, TargetId, samples};

fn options(chain: &Chain) -> ExportOptions {
    let target = (!chain.targets().is_empty()).then_some(TargetId(1));
    ExportOptions { target, ..ExportOptions::default() }
}

#[test]
fn corrected_origins_predict_as_the_model_does() {
    for chain in samples::all() {
        let fit = of(&chain, vec![Box::new(Geometric::default())], 3);
        let exported = corrected_chain(&fit, &options(&chain)).expect("an export");
        assert!(exported.left_out.is_empty());
        assert!(exported.error_left.max < 1e-13, "{}: {:e}", chain.name(), exported.error_left.max);
        let mut predictor = fit.bind(&Schema::default()).expect("bound");
        let mut draw = Draw(6);
        for _ in 0..50 {
            let q = draw.joints(&chain, 1.0);
            let real = predictor.predict(&Conditions::at(&chain, &q), None);
            let ours = exported.value.forward(&q);
            assert!((real.rotation - ours.rotation).amax() < 1e-13, "{}", chain.name());
        }
        assert_eq!(exported.value.joints().len(), chain.joints().len());
    }
}

#[test]
fn what_is_left_out_is_named_and_measured() {
    let chain = samples::heavy();
    let fit = elastic(&chain, 3);
    let exported = corrected_chain(&fit, &options(&chain)).expect("an export");
    assert_eq!(exported.left_out, ["joint_compliance"]);
    assert!((1e-4..2e-2).contains(&exported.error_left.rms), "{:?}", exported.error_left);
    assert!(exported.error_left.max >= exported.error_left.rms);
}

#[test]
fn tables_of_axes_predict_as_the_model_does() {
    for chain in samples::all() {
        let fit = of(&chain, vec![Box::new(Geometric::default())], 3);
        let table = axis_table(&fit, &options(&chain), &AxisTableOptions::default()).expect("a table");
        assert!(table.error_left.max < 1e-12, "{}: {:e}", chain.name(), table.error_left.max);
        let size = chain.characteristic_length();
        let hayati =
            table.value.rows.iter().filter(|r| matches!(r.link, Some(AxisLink::Hayati { .. }))).count();
        for row in &table.value.rows {
            if let Some(AxisLink::Common { d, a, .. }) = row.link {
                assert!(d.abs() < 3.0 * size && a.abs() < 3.0 * size);
            }
        }
        match chain.name() {
            // Shoulder, elbow and first wrist joint are parallel.
            "ur10" => assert_eq!(hayati, 2),
            "heavy" => assert_eq!(hayati, 1),
            _ => {}
        }
    }
}

#[test]
fn absurd_tables_are_refused_with_the_reason() {
    let chain = samples::ur10();
    let fit = of(&chain, vec![Box::new(Geometric::default())], 3);
    let plain = AxisTableOptions { hayati: false, ..AxisTableOptions::default() };
    let error = axis_table(&fit, &options(&chain), &plain).expect_err("parallel axes");
    assert!(matches!(error, CompensateError::ParallelAxes { .. }), "{error}");
    assert!(error.to_string().contains("`j2`") || error.to_string().contains("`j3`"), "{error}");
}

#[test]
fn joint_dependent_errors_come_back_from_their_tables() {
    // A gear's error in every joint that turns: a sum over the joints, which tables carry whole.
    for chain in [samples::ur10(), samples::scara()] {
        let fit = fitted(&chain, 3);
        let exported = error_tables(&fit, &options(&chain), 721).expect("tables");
        assert_eq!(
            exported.value.tables.len(),
            chain.movable().iter().filter(|&&j| chain.joint(j).unit() == "rad").count()
        );
        // Linear pieces of half a degree leave 1e-5 of half a milliradian.
        assert!(exported.error_left.max < 1e-7, "{}: {:?}", chain.name(), exported.error_left);
    }
    let heavy = samples::heavy();
    let exported = error_tables(&elastic(&heavy, 3), &options(&heavy), 41).expect("tables");
    let plain = corrected_chain(&elastic(&heavy, 3), &options(&heavy)).expect("an export");
    // Gravity turns with several joints at once: the tables carry most of it, not all.
    assert!(exported.error_left.rms < plain.error_left.rms && exported.error_left.rms > 1e-6);
    assert!(error_tables(&elastic(&heavy, 3), &options(&heavy), 1).is_err());
}
