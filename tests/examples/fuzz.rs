//! Throws spoiled input at everything that reads: `cargo xtask fuzz TARGET --inputs 1000000`.
//!
//! Inputs are good files and the corpus of `tests/spoiled`, of which bytes, pieces and lines are changed, moved, repeated and
//! crossed. A finding is a panic, an input that takes longer than a second, or more than a gigabyte in use; it is written to
//! `target/fuzz/` and ends the run with exit code 1. The same seed gives the same inputs.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a program for developers")]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use truepose_errormodel::EffectRegistry;
use truepose_io::{
    MeasurementsOptions, RobotOptions, read_fit, read_measurements, read_model, read_poses, read_robot,
    robot_toml, robot_urdf,
};
use truepose_kinematics::{Chain, samples};
use truepose_solvers::SolverSpec;

const SLOW: Duration = Duration::from_secs(1);
const LARGEST: u64 = 1 << 30;
const TARGETS: &[&str] = &[
    "robot",
    "urdf",
    "measurements",
    "model",
    "fit",
    "poses",
    "solver",
    #[cfg(feature = "parquet")]
    "parquet",
];

const PIECES: [&str; 40] = [
    "nan",
    "1e999",
    "-inf",
    "\"",
    "'",
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
    "1e300",
    "99999999999999999999",
    "[[joints]]\n",
    "<joint name='a'>",
    "known = false\n",
    ";",
    "\t",
    "#",
    ":",
    "(",
    ")",
    "[deg]",
    "[mm]",
    "null",
    "true",
    "<!--",
    "-->",
    "<![CDATA[",
    "&lt;",
    "\u{feff}",
];

/// What reads, and good texts to spoil.
struct Target {
    name: &'static str,
    ending: &'static str,
    /// What is read as it is, and the corpus of what is not.
    good: Vec<Vec<u8>>,
    seeds: Vec<Vec<u8>>,
    chain: Chain,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |key: &str| arguments.iter().position(|a| a == key).and_then(|k| arguments.get(k + 1));
    let number = |key: &str, or: u64| value(key).map_or(or, |text| text.parse().expect("a number"));
    let (inputs, seed) = (number("--inputs", 100_000), number("--seed", 0));
    let wanted = arguments.first().filter(|a| !a.starts_with("--")).cloned().unwrap_or_else(|| "all".into());
    let names: Vec<&str> =
        TARGETS.iter().copied().filter(|name| wanted == "all" || *name == wanted).collect();
    assert!(!names.is_empty(), "no target `{wanted}` (known: {}, all)", TARGETS.join(", "));
    std::panic::set_hook(Box::new(|_| ()));
    let mut findings = 0;
    for name in names {
        findings += run(&target(name), inputs, seed);
    }
    if findings > 0 {
        std::process::exit(1);
    }
}

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("spoiled")
}

fn target(name: &'static str) -> Target {
    let (chain, _) = read_robot(corpus().join("robot.toml"), &RobotOptions::default()).unwrap();
    let (ending, mut good): (&str, Vec<Vec<u8>>) = match name {
        "robot" => ("toml", samples::all().iter().map(|c| robot_toml(c).into_bytes()).collect()),
        "urdf" => ("urdf", samples::all().iter().map(|c| robot_urdf(c, &[]).into_bytes()).collect()),
        "model" => (
            "toml",
            vec![
                b"[[effects]]\nfamily = \"geometric\"\nframes = [\"base\", \"j1\"]\ncomponents = [\"x\", \"rz\"]\n\n[[effects]]\nfamily = \
                  \"joint_compliance\"\njoints = [\"j2\"]\n"
                    .to_vec(),
                b"[[effects]]\nfamily = \"transmission\"\njoint = \"j1\"\nperiod = 3.14\nharmonics = [1, 2]\n\n[[effects]]\nfamily = \
                  \"expansion\"\nat = { motion = { joint = \"j1\" } }\nfactors = [{ of = { joint = \"j2\" }, basis = { powers = [1, 2] } }]\n"
                    .to_vec(),
            ],
        ),
        "fit" => ("json", vec![fit(&chain)]),
        "solver" => (
            "txt",
            ["qr", "svd(rcond=1e-10)", "ridge(gcv)", "huber(qr, k=1.345)", "tukey(lasso(cv))", "group_lasso(refit)", "bounded(qr)"]
                .map(|s| s.as_bytes().to_vec())
                .to_vec(),
        ),
        "poses" => (
            "csv",
            vec![
                b"x[mm],y[mm],z[mm],target\n500,100,300,T1\n400,-200,350,\n".to_vec(),
                b"j1[deg],j2[deg],d3[mm],x[m],y[m],z[m],qw,qx,qy,qz,payload[kg],time[s]\n10,20,30,0.4,0.1,0.3,1,0,0,0,5,1\n".to_vec(),
            ],
        ),
        "parquet" => ("parquet", Vec::new()),
        _ => (
            "csv",
            vec![
                b"j1[deg],j2[deg],d3[mm],x[mm],y[mm],z[mm],qw,qx,qy,qz,sx[um],sy[um],sz[um],visit,payload[kg],cx[mm],cy[mm],cz[mm],\
                  time[s],approach_j1,approach_j2,approach_d3,oil[degC]\n10,20,30,400,100,300,1,0,0,0,10,10,20,1,5,0,0,90,1,1,-1,0,21.5\n\
                  11,-20,90,420,120,310,,,,,10,10,20,2,0,0,0,0,9,0,1,1,21.75\n"
                    .to_vec(),
            ],
        ),
    };
    let mut seeds = Vec::new();
    let folder = if name == "parquet" { corpus().join("../parquet") } else { corpus() };
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    for file in files {
        let stem = file.file_stem().unwrap().to_string_lossy().into_owned();
        let kind = stem.split('_').next().unwrap_or_default();
        let own = ["robot", "model", "fit", "poses"].contains(&kind);
        let ours = file.extension().is_some_and(|e| e == ending)
            && match name {
                "measurements" => !own,
                "urdf" | "parquet" => true,
                _ => kind == name,
            };
        if ours && (kind == "good" || kind == "fine") {
            good.push(std::fs::read(file).unwrap());
        } else if ours {
            seeds.push(std::fs::read(file).unwrap());
        }
    }
    Target { name, ending, good, seeds, chain }
}

/// A fit of the corpus' robot, as text.
fn fit(chain: &Chain) -> Vec<u8> {
    use truepose_errormodel::effects::{Geometric, JointCompliance};
    use truepose_errormodel::{ErrorModel, FittedModel};
    let effects: Vec<Box<dyn truepose_errormodel::AnyEffect>> =
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())];
    let model = ErrorModel::new(chain.clone(), effects).unwrap();
    let n = model.columns().len();
    let covariance = nalgebra::DMatrix::identity(n, n) * 1e-8;
    let fitted = FittedModel::new(model, vec![1e-4; n], covariance).unwrap();
    let folder = tempfile::tempdir().unwrap();
    truepose_io::write_fit(folder.path().join("fit.json"), &fitted).unwrap();
    std::fs::read(folder.path().join("fit.json")).unwrap()
}

/// Reads an input; true when it was accepted.
fn read(target: &Target, path: &Path, bytes: &[u8]) -> bool {
    let registry = EffectRegistry::builtin();
    match target.name {
        "robot" | "urdf" => read_robot(path, &RobotOptions::default()).is_ok(),
        "measurements" | "parquet" => {
            match read_measurements(path, &target.chain, &MeasurementsOptions::default()) {
                Ok((data, _, _)) => {
                    let _ = truepose_identify::suspicion(&target.chain, &data);
                    true
                }
                Err(_) => false,
            }
        }
        "model" => read_model(path, &target.chain, &registry).is_ok(),
        "fit" => read_fit(path, &registry).is_ok(),
        "poses" => read_poses(path, &target.chain).is_ok(),
        _ => std::str::from_utf8(bytes).is_ok_and(|text| text.parse::<SolverSpec>().is_ok()),
    }
}

fn run(target: &Target, inputs: u64, seed: u64) -> usize {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() }.unwrap();
    let path = folder.path().join(format!("input.{}", target.ending));
    let began = Instant::now();
    let (mut accepted, mut findings, mut slowest) = (0u64, 0usize, Duration::ZERO);
    for k in 0..inputs {
        let input = spoiled(&target.good, &target.seeds, &mut rng);
        if target.name != "solver" {
            std::fs::write(&path, &input).unwrap();
        }
        let start = Instant::now();
        let result = catch_unwind(AssertUnwindSafe(|| read(target, &path, &input)));
        let mut took = start.elapsed();
        if result.is_ok() && took > SLOW {
            // Another program may have had the machine: once more.
            let start = Instant::now();
            read(target, &path, &input);
            took = took.min(start.elapsed());
        }
        slowest = slowest.max(took);
        accepted += u64::from(matches!(result, Ok(true)));
        let large = k % 1000 == 0 && resident().is_some_and(|used| used > LARGEST);
        if result.is_err() || took > SLOW || large {
            findings += 1;
            let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/fuzz");
            std::fs::create_dir_all(&kept).unwrap();
            let name = format!("{}-{seed}-{k}.{}", target.name, target.ending);
            std::fs::write(kept.join(&name), &input).unwrap();
            println!("FINDING {name}: panic {}, {took:?}, large {large}", result.is_err());
        }
    }
    println!(
        "{}: {inputs} inputs from seed {seed}, {accepted} read, {} refused, {findings} findings, slowest {:.1} ms, {} MB, {:.0} s",
        target.name,
        inputs - accepted,
        slowest.as_secs_f64() * 1e3,
        resident().unwrap_or(0) / 1_000_000,
        began.elapsed().as_secs_f64()
    );
    findings
}

/// A good input, or one time in four a known bad one, with one to six changes; few are commoner.
fn spoiled(good: &[Vec<u8>], bad: &[Vec<u8>], rng: &mut ChaCha8Rng) -> Vec<u8> {
    let seeds = if bad.is_empty() || rng.random_range(0..4) > 0 { good } else { bad };
    let mut bytes = seeds[rng.random_range(0..seeds.len())].clone();
    let most = [1, 1, 2, 6][rng.random_range(0..4)];
    for _ in 0..rng.random_range(1..=most) {
        if bytes.is_empty() {
            bytes = PIECES[rng.random_range(0..PIECES.len())].as_bytes().to_vec();
        }
        let length = bytes.len();
        let at = rng.random_range(0..length);
        let end = (at + rng.random_range(1..60)).min(length);
        match rng.random_range(0..9) {
            0 => bytes[at] = rng.random(),
            1 => bytes[at] ^= 1 << rng.random_range(0..8),
            2 => drop(bytes.drain(at..end)),
            3 => {
                let part = bytes[at..end].to_vec();
                let times = if rng.random_range(0..50) == 0 { 2000 } else { rng.random_range(1..4) };
                bytes.splice(at..at, part.repeat(times));
            }
            4 => drop(bytes.splice(at..at, PIECES[rng.random_range(0..PIECES.len())].bytes())),
            5 => bytes.truncate(at),
            6 => {
                // A piece of another input.
                let other = &seeds[rng.random_range(0..seeds.len())];
                let from = rng.random_range(0..=other.len());
                let to = (from + rng.random_range(1..200)).min(other.len());
                bytes.splice(at..at, other[from..to].iter().copied());
            }
            7 => {
                // Another number where one stands.
                if let Some(digit) = (at..length).find(|&k| bytes[k].is_ascii_digit()) {
                    let stop = (digit..length)
                        .find(|&k| !bytes[k].is_ascii_digit() && bytes[k] != b'.')
                        .unwrap_or(length);
                    let exponent: i32 = rng.random_range(-330..330);
                    let number = [
                        format!("{}e{exponent}", rng.random_range(-9..9)),
                        rng.random::<i64>().to_string(),
                        "0".into(),
                    ];
                    bytes.splice(digit..stop, number[rng.random_range(0..3)].bytes());
                }
            }
            _ => {
                // Two lines exchanged.
                let mut lines: Vec<Vec<u8>> = bytes.split(|b| *b == b'\n').map(<[u8]>::to_vec).collect();
                let (a, b) = (rng.random_range(0..lines.len()), rng.random_range(0..lines.len()));
                lines.swap(a, b);
                bytes = lines.join(&b'\n');
            }
        }
    }
    bytes
}

fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|k| 1024 * k)
}
