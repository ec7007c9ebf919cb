//! Readers of files under a fuzzer that is guided by coverage (libFuzzer); `TRUEPOSE_FUZZ` names the reader. See README.md.
//!
//! A finding is a panic, an arithmetic overflow, an input that takes longer than `-timeout`, or more memory than `-rss_limit_mb`. What is
//! read is used as a program would: a robot is written and read again, a fit predicts.

#![no_main]

use libfuzzer_sys::{Corpus, fuzz_target};
use std::cell::OnceCell;
use std::path::{Path, PathBuf};
use truepose_controllers::{Dialect, Program};
use truepose_errormodel::{EffectRegistry, ErrorModel};
use truepose_io::{
    ColumnMap, MeasurementsOptions, MonitorHistory, RobotOptions, read_details, read_fit, read_measurements,
    read_model, read_poses, read_robot, robot_sessions, robot_surroundings, robot_toml,
};
use truepose_kinematics::Chain;

struct Reader {
    name: String,
    /// In memory where the system has such a folder.
    file: PathBuf,
    chain: Chain,
    effects: EffectRegistry,
}

impl Reader {
    fn new() -> Self {
        let name = std::env::var("TRUEPOSE_FUZZ").expect("TRUEPOSE_FUZZ names a reader");
        let ending = match name.as_str() {
            "robot" | "model" | "details" => "toml",
            "urdf" => "urdf",
            "fit" | "history" => "json",
            "measurements" | "poses" => "csv",
            "program" => "txt",
            _ => panic!("readers: robot, urdf, model, details, fit, history, measurements, poses, program"),
        };
        let folder = if Path::new("/dev/shm").is_dir() { "/dev/shm".into() } else { std::env::temp_dir() };
        let file = folder.join(format!("truepose-fuzz-{}.{ending}", std::process::id()));
        let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/spoiled/robot.toml");
        let (chain, _) = read_robot(robot, &RobotOptions::default()).expect("the robot of the corpus");
        Reader { name, file, chain, effects: EffectRegistry::builtin() }
    }

    /// Reads an input; whether it was accepted.
    fn read(&self, bytes: &[u8]) -> bool {
        if self.name == "program" {
            let Some((&first, text)) = bytes.split_first() else { return false };
            let dialect = Dialect::ALL[usize::from(first) % Dialect::ALL.len()];
            let Ok(program) = Program::read(text, &[], dialect) else { return false };
            let kept: Vec<_> = program.points().iter().map(|_| None).collect();
            let same = program.rewritten(&kept).expect("a program that is read is written");
            assert!(same == text, "a program whose points are kept is the same");
            return true;
        }
        std::fs::write(&self.file, bytes).expect("a file in memory");
        let file = &self.file;
        match self.name.as_str() {
            "robot" => {
                let _ = (robot_sessions(file), robot_surroundings(file));
                let Ok((chain, _)) = read_robot(file, &RobotOptions::default()) else { return false };
                std::fs::write(file, robot_toml(&chain)).expect("a file in memory");
                read_robot(file, &RobotOptions::default()).expect("what is written is read");
                true
            }
            "urdf" => read_robot(file, &RobotOptions::default()).is_ok(),
            "details" => read_details(file).is_ok(),
            "model" => match read_model(file, &self.chain, &self.effects) {
                Ok(effects) => ErrorModel::new(self.chain.clone(), effects).is_ok(),
                Err(_) => false,
            },
            "fit" => match read_fit(file, &self.effects) {
                Ok(fitted) => {
                    let data = truepose_errormodel::Dataset::default();
                    let _ = data.derived_for(fitted.model());
                    true
                }
                Err(_) => false,
            },
            "history" => MonitorHistory::read(file, "0").is_ok(),
            "poses" => read_poses(file, &self.chain, &ColumnMap::default()).is_ok(),
            _ => read_measurements(file, &self.chain, &MeasurementsOptions::default()).is_ok(),
        }
    }
}

thread_local! {
    static READER: OnceCell<Reader> = const { OnceCell::new() };
}

fuzz_target!(|bytes: &[u8]| -> Corpus {
    READER.with(|reader| {
        reader.get_or_init(Reader::new).read(bytes);
    });
    Corpus::Keep
});
