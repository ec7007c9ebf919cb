//! Spoiled files of every kind are refused or read, and never make a reader panic.

use proptest::prelude::*;
use proptest::sample::Index;
use std::path::Path;
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{Dataset, EffectRegistry, ErrorModel, FittedModel};
use truepose_io::{
    ColumnMap, IoError, MeasurementsOptions, MeasurementsReader, RobotOptions, read_fit, read_measurements,
    read_model, read_poses, read_robot, robot_toml, write_fit,
};
use truepose_kinematics::nalgebra::DMatrix;
use truepose_kinematics::samples;

/// One thing that happens to a file.
#[derive(Debug, Clone)]
enum Spoil {
    Replace(Index, u8),
    Remove(Index, usize),
    Repeat(Index, usize),
    Insert(Index, &'static str),
    Cut(Index),
}

const PIECES: [&str; 24] = [
    "nan",
    "1e999",
    "-inf",
    "\"",
    ",",
    "\n",
    "\r",
    "[",
    "]",
    "{",
    "}",
    "=",
    "<",
    ">",
    "/>",
    "é",
    "\u{0}",
    "-0",
    "1e-320",
    "99999999999999999999",
    "[[joints]]\n",
    "<joint name='a'>",
    "known = false\n",
    ";",
];

fn spoils() -> impl Strategy<Value = Vec<Spoil>> {
    let one = prop_oneof![
        (any::<Index>(), any::<u8>()).prop_map(|(at, byte)| Spoil::Replace(at, byte)),
        (any::<Index>(), 1usize..40).prop_map(|(at, n)| Spoil::Remove(at, n)),
        (any::<Index>(), 1usize..80).prop_map(|(at, n)| Spoil::Repeat(at, n)),
        (any::<Index>(), prop::sample::select(&PIECES[..])).prop_map(|(at, text)| Spoil::Insert(at, text)),
        any::<Index>().prop_map(Spoil::Cut),
    ];
    prop::collection::vec(one, 1..5)
}

fn spoiled(text: &str, spoils: &[Spoil]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for spoil in spoils {
        if bytes.is_empty() {
            break;
        }
        let length = bytes.len();
        match spoil {
            Spoil::Replace(at, byte) => bytes[at.index(length)] = *byte,
            Spoil::Remove(at, n) => {
                let at = at.index(length);
                bytes.drain(at..(at + n).min(length));
            }
            Spoil::Repeat(at, n) => {
                let at = at.index(length);
                let part = bytes[at..(at + n).min(length)].to_vec();
                bytes.splice(at..at, part);
            }
            Spoil::Insert(at, text) => {
                let at = at.index(length);
                bytes.splice(at..at, text.bytes());
            }
            Spoil::Cut(at) => bytes.truncate(at.index(length)),
        }
    }
    bytes
}

/// A refusal names the file and has something to say.
fn check<T>(path: &Path, result: Result<T, IoError>) {
    if let Err(error) = result {
        assert_eq!(error.path(), path);
        let message = error.to_string();
        assert!(message.len() > path.display().to_string().len() + 8, "{message}");
    }
}

fn written(name: &str, text: &str, spoils: &[Spoil]) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, spoiled(text, spoils)).unwrap();
    (folder, path)
}

const URDF: &str = r#"<?xml version="1.0"?><robot name="a"><link name="b"/><link name="c"><inertial><origin xyz="1 2 3"/>
<mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link><link name="d"/>
<joint name="j1" type="revolute"><origin xyz="0 0 1" rpy="0 1 0"/><parent link="b"/><child link="c"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="j2" type="fixed"><parent link="c"/><child link="d"/></joint></robot>"#;

const CSV: &str = "# c\nr1[rad],r2[deg],slide[mm],r4[rad],x[mm],y[mm],z[mm],qw,qx,qy,qz,visit,payload[kg],cx[m],cy[m],cz[m],time[s],\
approach_r1,sx[mm],sy[mm],sz[mm],oil[K]\n0.1,20,30,0.4,1,2,3,1,0,0,0,0,5,0,0,0.1,0,1,0.1,0.1,0.1,300\n\
0.1,20,30,0.4,1,2,3,,,,,0,5,0,0,0.1,1,-1,,,,301\n-0.1,25,35,-0.4,,,,0,1,0,0,1,0,,,,2,0,0.1,0.1,0.1,302\n";

const MODEL: &str = "[[effects]]\nfamily = \"geometric\"\nframes = [\"base\", \"d1\", \"targets\"]\ncomponents = [\"x\"]\n\n[[effects]]\n\
family = \"expansion\"\nat = { motion = { joint = \"theta\" } }\nfactors = [{ of = { joint = \"d1\" }, basis = { powers = [1, 2] } }]\n";

proptest! {
    #[test]
    fn robots(spoils in spoils(), which in 0usize..6) {
        let text = robot_toml(&samples::all()[which]);
        let (_folder, path) = written("r.toml", &text, &spoils);
        check(&path, read_robot(&path, &RobotOptions::default()));
    }

    #[test]
    fn urdfs(spoils in spoils()) {
        let (_folder, path) = written("r.urdf", URDF, &spoils);
        check(&path, read_robot(&path, &RobotOptions::default()));
    }

    #[test]
    fn measurements(spoils in spoils()) {
        let (_folder, path) = written("d.csv", CSV, &spoils);
        let chain = samples::scara();
        let options = MeasurementsOptions::default();
        let whole = read_measurements(&path, &chain, &options);
        if let Ok((data, info, _)) = &whole {
            prop_assert!(data.validate(&chain).is_ok());
            prop_assert_eq!(info.rows, data.len());
        }
        check(&path, whole);
        check(&path, MeasurementsReader::open(&path, &chain, &options).and_then(|mut reader| {
            let mut block = Dataset::default();
            while reader.read_block(1, &mut block)? > 0 {}
            Ok(())
        }));
        check(&path, read_poses(&path, &chain, &ColumnMap::default()));
    }

    #[test]
    fn models(spoils in spoils()) {
        let (_folder, path) = written("m.toml", MODEL, &spoils);
        check(&path, read_model(&path, &samples::pps(), &EffectRegistry::builtin()));
    }

    #[test]
    fn fits(spoils in spoils()) {
        let model = ErrorModel::new(samples::scara(), vec![Box::new(Geometric::default())]).unwrap();
        let n = model.columns().len();
        let fit = FittedModel::new(model, vec![1e-4; n], DMatrix::identity(n, n)).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fit.json");
        write_fit(&path, &fit).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, spoiled(&text, &spoils)).unwrap();
        check(&path, read_fit(&path, &EffectRegistry::builtin()));
    }

    #[test]
    fn any_bytes_at_all(bytes in prop::collection::vec(any::<u8>(), 0..200), ending in 0usize..4) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(["a.toml", "a.urdf", "a.csv", "a.json"][ending]);
        std::fs::write(&path, &bytes).unwrap();
        check(&path, read_robot(&path, &RobotOptions::default()));
        check(&path, read_measurements(&path, &samples::ur10(), &MeasurementsOptions::default()));
        check(&path, read_model(&path, &samples::ur10(), &EffectRegistry::builtin()));
        check(&path, read_fit(&path, &EffectRegistry::builtin()));
    }
}
