//! Reads every robot, data set, pose file and model of a folder of published files, where there is one: the folder
//! that `TRUEPOSE_SHARED` names, or `shared` beside the workspace.

use std::path::{Path, PathBuf};
use truepose_errormodel::EffectRegistry;
use truepose_io::{
    ColumnMap, IoError, MeasurementsOptions, RobotOptions, read_measurements, read_model, read_poses,
    read_robot,
};

fn shared() -> Option<PathBuf> {
    let named = std::env::var_os("TRUEPOSE_SHARED").map(PathBuf::from);
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    named.or(Some(beside)).filter(|folder| folder.is_dir())
}

fn folders(of: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(of) else { return Vec::new() };
    let mut folders: Vec<PathBuf> =
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| path.is_dir()).collect();
    folders.sort();
    folders
}

fn told<T>(result: Result<T, IoError>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn published_files_are_read() {
    let Some(shared) = shared() else {
        println!("no folder of published files: set TRUEPOSE_SHARED to read them, too");
        return;
    };
    let registry = EffectRegistry::builtin();
    let options = MeasurementsOptions::default();
    let mut tables = 0;
    for folder in [folders(&shared.join("data")), folders(&shared.join("cases"))].concat() {
        let (chain, warnings) = told(read_robot(folder.join("robot.toml"), &RobotOptions::default()));
        assert_eq!(warnings, []);
        for name in ["measurements.csv", "train.csv", "heldout.csv"] {
            let path = folder.join(name);
            if !path.exists() {
                continue;
            }
            let (data, info, warnings) = told(read_measurements(&path, &chain, &options));
            assert!(data.validate(&chain).is_ok() && info.rows == data.len() && info.visits > 0);
            for warning in &warnings {
                println!("{warning}");
            }
            tables += 1;
        }
        if folder.join("poses.csv").exists() {
            let (poses, ..) = told(read_poses(folder.join("poses.csv"), &chain, &ColumnMap::default()));
            assert_eq!(poses.rows.len(), 30);
        }
        if folder.join("declared.toml").exists() {
            assert!(!told(read_model(folder.join("declared.toml"), &chain, &registry)).is_empty());
        }
    }
    println!("{tables} tables read");
}
