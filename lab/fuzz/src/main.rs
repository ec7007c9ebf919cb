#![doc = include_str!("../README.md")]
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a program for developers")]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use truepose_errormodel::EffectRegistry;
use truepose_io::{
    ColumnMap, MeasurementsOptions, RobotOptions, Warning, read_fit, read_measurements, read_model,
    read_poses, read_robot, robot_toml, robot_urdf,
};
use truepose_kinematics::{Chain, samples};
use truepose_micro::clock::{memory_mb, timed_on_thread};
use truepose_solvers::SolverSpec;

const SLOW: Duration = Duration::from_secs(1);
/// MB.
const LARGEST: f64 = 1024.0;
/// Kept inputs of a target, at most.
const MOST: usize = 4000;
const TARGETS: &[&str] = &["robot", "urdf", "measurements", "model", "fit", "poses", "solver", "parquet"];

/// Texts to insert, separated by bars.
const PIECES: &str = "nan|1e999|-inf|\"|'|,|\n|\r|[|]|{|}|=|<|>|/>|é|\u{0}|-0|1e-320|1e300|99999999999999999999|[[joints]]\n|\
    <joint name='a'>|known = false\n|;|\t|#|:|(|)|[deg]|[mm]|null|true|<!--|-->|<![CDATA[|&lt;|\u{feff}";

/// One of them.
fn piece(rng: &mut ChaCha8Rng) -> &'static str {
    let pieces: Vec<&str> = PIECES.split('|').collect();
    pieces[rng.random_range(0..pieces.len())]
}

const SOLVERS: [&str; 7] = [
    "qr",
    "svd(rcond=1e-10)",
    "ridge(gcv)",
    "huber(qr, k=1.345)",
    "tukey(lasso(cv))",
    "group_lasso(refit)",
    "bounded(qr)",
];

fn good(texts: &[&str]) -> Vec<Vec<u8>> {
    texts.iter().map(|text| text.as_bytes().to_vec()).collect()
}

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
    let time = value("--for").map(|text| time(text).expect("a time, as in 90s, 10min or 1h"));
    let inputs = number("--inputs", if time.is_some() { u64::MAX } else { 100_000 });
    let seed = number("--seed", 0);
    let wanted = arguments.first().filter(|a| !a.starts_with("--")).cloned().unwrap_or_else(|| "all".into());
    let names: Vec<&str> =
        TARGETS.iter().copied().filter(|name| wanted == "all" || *name == wanted).collect();
    assert!(!names.is_empty(), "no target `{wanted}` (known: {}, all)", TARGETS.join(", "));
    std::panic::set_hook(Box::new(|_| ()));
    let mut findings = 0;
    for name in names {
        findings += run(&target(name), inputs, time, seed);
    }
    if findings > 0 {
        std::process::exit(1);
    }
}

fn time(text: &str) -> Option<Duration> {
    let (number, unit) = text.split_at(text.find(|c: char| c.is_ascii_alphabetic())?);
    let seconds = match unit {
        "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        _ => return None,
    };
    Duration::try_from_secs_f64(number.parse::<f64>().ok()? * seconds).ok()
}

/// Findings and the corpus.
fn kept() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/fuzz")
}

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/spoiled")
}

fn target(name: &'static str) -> Target {
    let (chain, _) = read_robot(corpus().join("robot.toml"), &RobotOptions::default()).unwrap();
    let (ending, mut good): (&str, Vec<Vec<u8>>) = match name {
        "robot" => ("toml", samples::all().iter().map(|c| robot_toml(c).into_bytes()).collect()),
        "urdf" => ("urdf", samples::all().iter().map(|c| robot_urdf(c, &[]).into_bytes()).collect()),
        "model" => {
            ("toml", good(&[include_str!("../good/model_1.toml"), include_str!("../good/model_2.toml")]))
        }
        "fit" => ("json", vec![fit(&chain)]),
        "solver" => ("txt", good(&SOLVERS)),
        "poses" => ("csv", good(&[include_str!("../good/poses_1.csv"), include_str!("../good/poses_2.csv")])),
        "parquet" => ("parquet", Vec::new()),
        _ => ("csv", good(&[include_str!("../good/measurements.csv")])),
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
    let model = ErrorModel::new(
        chain.clone(),
        vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())],
    );
    let n = model.as_ref().unwrap().columns().len();
    let fitted =
        FittedModel::new(model.unwrap(), vec![1e-4; n], nalgebra::DMatrix::identity(n, n) * 1e-8).unwrap();
    let folder = tempfile::tempdir().unwrap();
    truepose_io::write_fit(folder.path().join("fit.json"), &fitted).unwrap();
    std::fs::read(folder.path().join("fit.json")).unwrap()
}

/// Reads an input; what was said of it, warnings or an error.
fn read(target: &Target, path: &Path, bytes: &[u8]) -> Result<String, String> {
    let registry = EffectRegistry::builtin();
    let words = |all: &[Warning]| all.iter().map(ToString::to_string).collect::<String>();
    let read = match target.name {
        "robot" | "urdf" => read_robot(path, &RobotOptions::default()).map(|(_, warnings)| words(&warnings)),
        "measurements" | "parquet" => read_measurements(path, &target.chain, &MeasurementsOptions::default())
            .map(|(data, _, warnings)| {
                let _ = truepose_identify::suspicion(&target.chain, &data);
                words(&warnings)
            }),
        "model" => read_model(path, &target.chain, &registry).map(|effects| {
            // What is accepted has a size.
            let made = truepose_errormodel::ErrorModel::new(target.chain.clone(), effects);
            made.map_or_else(|error| error.to_string(), |_| String::new())
        }),
        "fit" => read_fit(path, &registry).map(|_| String::new()),
        "poses" => {
            read_poses(path, &target.chain, &ColumnMap::default()).map(|(_, _, warnings)| words(&warnings))
        }
        _ => {
            let text = std::str::from_utf8(bytes).map_err(|error| error.to_string())?;
            return text.parse::<SolverSpec>().map(|_| String::new()).map_err(|error| error.to_string());
        }
    };
    read.map_err(|error| error.to_string())
}

/// An answer without names and numbers.
fn kind(answer: &Result<String, String>) -> String {
    let text = answer.as_ref().unwrap_or_else(|words| words);
    let text: String = text.split('`').step_by(2).collect();
    let plain = text.chars().filter(|c| c.is_ascii_alphabetic() || *c == ' ').take(160);
    plain.chain([if answer.is_ok() { '+' } else { '-' }]).collect()
}

/// Inputs of other runs, and of this one.
fn seeds_of(target: &Target) -> Vec<Vec<u8>> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(kept().join("corpus").join(target.name))
        .map(|entries| entries.filter_map(|entry| Some(entry.ok()?.path())).collect())
        .unwrap_or_default();
    files.sort();
    files.iter().filter_map(|file| std::fs::read(file).ok()).take(MOST).collect()
}

fn run(target: &Target, inputs: u64, time: Option<Duration>, seed: u64) -> usize {
    let (mut own, mut answers) = (seeds_of(target), HashSet::new());
    let corpus = kept().join("corpus").join(target.name);
    std::fs::create_dir_all(&corpus).unwrap();
    let mut done = 0;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() }.unwrap();
    let path = folder.path().join(format!("input.{}", target.ending));
    let began = Instant::now();
    let (mut accepted, mut findings, mut slowest) = (0u64, 0usize, Duration::ZERO);
    for k in (0..inputs).take_while(|_| time.is_none_or(|time| began.elapsed() < time)) {
        done += 1;
        let again = !own.is_empty() && rng.random_range(0..3) == 0;
        let input = spoiled(if again { &own } else { &target.good }, &target.seeds, &mut rng);
        if target.name != "solver" {
            std::fs::write(&path, &input).unwrap();
        }
        let start = Instant::now();
        let result = catch_unwind(AssertUnwindSafe(|| read(target, &path, &input)));
        let mut took = start.elapsed();
        if result.is_ok() && took > SLOW {
            // Another program may have had the machine: once more, by the time of the processor where it is known.
            let (again, _) = timed_on_thread(|| read(target, &path, &input));
            took = took.min(Duration::from_secs_f64(again));
        }
        slowest = slowest.max(took);
        accepted += u64::from(matches!(result, Ok(Ok(_))));
        if let Ok(answer) = &result
            && answers.insert(kind(answer))
            && own.len() < MOST
        {
            std::fs::write(corpus.join(format!("{seed}-{k}.{}", target.ending)), &input).unwrap();
            own.push(input.clone());
        }
        let large = k % 1000 == 0 && memory_mb("VmRSS:") > LARGEST;
        if result.is_err() || took > SLOW || large {
            findings += 1;
            let name = format!("{}-{seed}-{k}.{}", target.name, target.ending);
            std::fs::write(kept().join(&name), &input).unwrap();
            println!("FINDING {name}: panic {}, {took:?}, large {large}", result.is_err());
        }
    }
    println!(
        "{}: {done} inputs from seed {seed}, {:.0} a second, {accepted} read, {} refused, {} kinds of answers, {findings} findings, \
         slowest {:.1} ms, {:.0} MB, {:.0} s",
        target.name,
        done as f64 / began.elapsed().as_secs_f64(),
        done - accepted,
        answers.len(),
        slowest.as_secs_f64() * 1e3,
        memory_mb("VmRSS:"),
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
            bytes = piece(rng).into();
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
            4 => drop(bytes.splice(at..at, piece(rng).bytes())),
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
