//! The truth shares no code with the model: this crate reads a robot's description and nothing else of it.

use std::path::{Path, PathBuf};

/// What the model computes, by name: transforms, frames, statics, Jacobians, its own rotation formulas, evaluation; what a sensor reads, and its
/// start.
const THE_MODELS: [&str; 19] = [
    ".transform(",
    ".forward(",
    "PostureBuffer",
    "joint_jacobian",
    "joint_motion",
    "Pose::rot",
    "Pose::trans",
    "from_xyz_rpy",
    "rotation_vector(",
    "rotation_log",
    ".carried_to(",
    "predict(",
    "gravity_in_measurement_frame",
    ".read(",
    "Reading::",
    ".started(",
    ".moved(",
    ".freed(",
    ".unknowns(",
];

fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            into.push(path);
        }
    }
}

#[test]
fn no_source_calls_the_model() {
    let mut files = Vec::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    assert!(files.len() > 30, "only {} files were found", files.len());
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a source file");
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        for line in code {
            if let Some(call) = THE_MODELS.iter().find(|call| line.contains(**call)) {
                panic!("{}: `{call}` is the model's: {line}", file.display());
            }
        }
    }
}
