//! What a discovery finds in a set of files, and whether it is the same in another one.

use super::case::Case;
use super::relations::Relation;
use std::path::{Path, PathBuf};
use truepose_discover::{DiscoverOptions, Family, Finding, Verdict, diagnose};
use truepose_errormodel::{Dataset, EffectRegistry};
use truepose_io::{MeasurementsOptions, RobotOptions, read_measurements, read_model, read_robot};
use truepose_solvers::PivotedQr;

/// A finding: what it is and where, and its coefficients with the half widths of their intervals.
#[derive(Debug, Clone)]
pub struct Effect {
    pub words: String,
    pub coefficients: Vec<(f64, f64)>,
}

/// What a discovery found.
#[derive(Debug, Clone)]
pub struct Found {
    /// In the order of their words.
    pub effects: Vec<Effect>,
    pub verdict: Verdict,
    /// Held-out RMS of the position error without rows that are outliers, mm: of the declared and of the enlarged model.
    pub rms: [f64; 2],
}

/// Whether two sets of files are read as the same robot, model and measurements, to the bit: a discovery cannot tell them apart.
pub fn same_inputs(a: &Case, b: &Case) -> bool {
    // Of numbers as they are printed NaN is equal to NaN; lines are for messages.
    let inputs = |case: &Case| -> Option<String> {
        let folder = tempfile::tempdir().ok()?;
        let files = Files::of(case, folder.path());
        let (chain, _) = read_robot(files.robot, &RobotOptions::default()).ok()?;
        let (data, ..) = read_measurements(files.table, &chain, &MeasurementsOptions::default()).ok()?;
        let data = Dataset { line: Vec::new(), record: None, ..data };
        Some(format!("{data:?}"))
    };
    a.threads == b.threads
        && toml::to_string(&a.robot).ok() == toml::to_string(&b.robot).ok()
        && toml::to_string(&a.model).ok() == toml::to_string(&b.model).ok()
        && inputs(a).is_some_and(|ours| Some(ours) == inputs(b))
}

/// The files of a case.
struct Files {
    robot: PathBuf,
    model: PathBuf,
    table: PathBuf,
}

impl Files {
    fn of(case: &Case, folder: &Path) -> Self {
        let write = |name: &str, text: String| {
            std::fs::write(folder.join(name), text).unwrap();
            folder.join(name)
        };
        Files {
            robot: write("robot.toml", toml::to_string(&case.robot).unwrap()),
            model: write("model.toml", toml::to_string(&case.model).unwrap()),
            table: write("data.csv", case.table()),
        }
    }
}

impl Found {
    /// By a discovery; what is wrong with the files, as a text.
    pub fn of(case: &Case, options: &DiscoverOptions) -> Result<Self, String> {
        let folder = tempfile::tempdir().unwrap();
        let files = Files::of(case, folder.path());
        let (chain, _) = read_robot(files.robot, &RobotOptions::default()).map_err(|e| e.to_string())?;
        let declared =
            read_model(files.model, &chain, &EffectRegistry::builtin()).map_err(|e| e.to_string())?;
        let (data, ..) = read_measurements(files.table, &chain, &MeasurementsOptions::default())
            .map_err(|e| e.to_string())?;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(case.threads).build().unwrap();
        let found = pool
            .install(|| diagnose(&chain, &declared, &data, &PivotedQr::default(), options, &|_| ()))
            .map_err(|e| e.to_string())?;
        let effect = |finding: &Finding| {
            let coefficient = |p: &truepose_discover::Parameter| (p.value, 0.5 * (p.ci95[1] - p.ci95[0]));
            Effect {
                words: words(finding, case),
                coefficients: finding.parameters.iter().chain(&finding.shape).map(coefficient).collect(),
            }
        };
        let mut effects: Vec<Effect> = found.findings.iter().map(effect).collect();
        effects.sort_by(|a, b| a.words.cmp(&b.words));
        let rms = |errors: &truepose_discover::Errors| 1e3 * errors.spreads_without_outliers().1.rms;
        Ok(Found { effects, verdict: found.verdict, rms: [rms(&found.before), rms(&found.after)] })
    }

    /// What is not as `other` has it, by this relation.
    pub fn differs(&self, other: &Found, relation: &Relation) -> Option<String> {
        let kept = |found: &Found| -> Vec<Effect> {
            let outlier = |effect: &&Effect| effect.words == Family::Outlier.word();
            found.effects.iter().filter(|effect| !(relation.spoils && outlier(effect))).cloned().collect()
        };
        let (ours, theirs) = (kept(self), kept(other));
        let words =
            |effects: &[Effect]| effects.iter().map(|effect| effect.words.clone()).collect::<Vec<_>>();
        if words(&ours) != words(&theirs) {
            return Some(format!("{:?} became {:?}", words(&ours), words(&theirs)));
        }
        if self.verdict != other.verdict {
            return Some(format!("{:?} became {:?}", self.verdict, other.verdict));
        }
        let numbers = ours.iter().zip(&theirs).filter(|_| relation.same_coefficients);
        for (ours, theirs) in numbers {
            // Without a pose, a curve may need one piece more or less: its coefficients are others then, and the errors tell whether it is the same.
            if relation.spoils && ours.coefficients.len() != theirs.coefficients.len() {
                continue;
            }
            let apart = |((a, half), (b, _)): &(&(f64, f64), &(f64, f64))| (a - b).abs() > *half;
            if let Some((a, b)) = ours.coefficients.iter().zip(&theirs.coefficients).find(apart) {
                return Some(format!("{}: {:.3e} ± {:.1e} became {:.3e}", ours.words, a.0, a.1, b.0));
            }
        }
        for (ours, theirs) in self.rms.iter().zip(&other.rms) {
            let theirs = theirs / relation.lengths;
            if (theirs / ours - 1.0).abs() > relation.tolerance {
                return Some(format!("{ours:.4} mm became {theirs:.4} mm"));
            }
        }
        None
    }
}

/// Family and place, with the names that the joints and targets had.
fn words(finding: &Finding, case: &Case) -> String {
    let place = serde_json::to_value(&finding.candidate.place).unwrap();
    let mut words = finding.candidate.family.word().to_owned();
    for (key, value) in place.as_object().unwrap() {
        let Some(name) = value.as_str() else {
            continue; // A mass has another last digit in pounds.
        };
        let (head, tail) = match name.split_once('_') {
            Some((head @ ("load" | "approach"), tail)) => (format!("{head}_"), tail),
            _ => (String::new(), name),
        };
        let old = case.names.get(tail).map_or(tail, String::as_str);
        words += &format!(" {key}={head}{old}");
    }
    words
}
