//! What the README says of the library is what the library does.

use std::path::Path;
use truepose_errormodel::EffectRegistry;
use truepose_identify::{IdentificationOptions, identify};
use truepose_io::{MeasurementsOptions, RobotOptions, read_measurements, read_model, read_robot, write_fit};
use truepose_solvers::PivotedQr;

#[test]
fn the_librarys_example_says_what_the_readme_has() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    let (_, after) = readme.split_once("held_out.rms), \"").unwrap();
    let (stated, _) = after.split_once('"').unwrap();

    let folder = root.join("examples/01_identify");
    let (arm, _) = read_robot(folder.join("robot.toml"), &RobotOptions::default()).unwrap();
    let measured = folder.join("measurements.csv");
    let (rows, _, _) = read_measurements(measured, &arm, &MeasurementsOptions::default()).unwrap();
    let effects = read_model(folder.join("model.toml"), &arm, &EffectRegistry::builtin()).unwrap();
    let options = IdentificationOptions::default();
    let found = identify(&arm, &effects, &rows, &PivotedQr::default(), &options, &|_| ()).unwrap();
    let held_out = found.declared.held_out.unwrap().residuals.positions();
    assert_eq!(format!("{:.3} mm", 1e3 * held_out.rms), stated);
    let kept = tempfile::tempdir().unwrap();
    write_fit(kept.path().join("fit.json"), &found.fit.fitted).unwrap();
}
