//! A recorded run with its outputs elsewhere: whatever its arguments say, nothing is written outside of one folder.

use crate::args::{Args, Files, Verb};
use std::path::{Path, PathBuf};

/// A verb to repeat.
#[derive(Debug)]
pub struct Repeated {
    /// With every output in the folder.
    pub verb: Verb,
    /// Its files.
    pub files: Files,
    /// Name of the result.
    pub result: &'static str,
    /// The folder of its report.
    pub report: PathBuf,
}

impl Repeated {
    /// Of recorded arguments, which are parsed as any others are: each output is one by its type, and is redirected.
    ///
    /// # Errors
    /// What is wrong with the arguments.
    pub fn of(arguments: &[String], own: &Path) -> Result<Self, String> {
        let of = |arguments: &[String]| {
            Args::recorded(arguments, Some(own))
                .map_err(|words| format!("its arguments are not valid: {words}"))
        };
        let Args { verb, files, .. } = of(arguments)?;
        let result = match &verb {
            Verb::Identify(_) => "identification.json",
            Verb::Discover(_) => "discovery.json",
            Verb::Compare(_) => "comparison.json",
            Verb::Compensate(_) => "compensation.json",
            Verb::Map(_) => "map.json",
            Verb::Plan(_) => "plan.json",
            Verb::Predict(_) => "prediction.json",
            Verb::Iso9283(_) => "acceptance.json",
            _ => return Err(NOT_REPEATED.into()),
        };
        match files.folders.iter().find(|folder| folder.option == "--report") {
            Some(folder) => Ok(Repeated { report: folder.path.clone(), verb, files, result }),
            None => Err("its arguments have no --report".into()),
        }
    }
}

/// What is said of other verbs.
const NOT_REPEATED: &str =
    "only discover, identify, compare, compensate, iso9283, map, plan and predict can be repeated";

#[cfg(test)]
mod tests {
    use super::*;

    fn of(words: &[&str]) -> Result<Repeated, String> {
        let words: Vec<String> = words.iter().map(ToString::to_string).collect();
        Repeated::of(&words, Path::new("own"))
    }

    #[test]
    fn outputs_are_redirected() {
        let read = ["discover", "--robot", "r.toml", "--data=d.csv", "--report", "r"];
        for outputs in [&["--out", "fit.json", "--rivals", "mine"][..], &["--rivals=mine"]] {
            let repeated = of(&[&read[..], outputs].concat()).unwrap();
            let Verb::Discover(verb) = repeated.verb else { panic!("discover") };
            assert_eq!(&*verb.measured.data, Path::new("d.csv"));
            assert_eq!(repeated.report, Path::new("own/report"));
            assert_eq!(verb.report.as_deref(), Some(Path::new("own/report")));
            assert_eq!(verb.rivals.as_deref(), Some(Path::new("own/rivals")));
            assert!(verb.out.iter().all(|out| **out == *Path::new("own/out-fit.json")));
        }
        let words = ["compensate", "--fit", "f", "--poses", "p", "--out", "q", "--report=r"];
        let Verb::Compensate(verb) = of(&words).unwrap().verb else { panic!("compensate") };
        assert_eq!(&*verb.out, Path::new("own/out-q"));
    }

    #[test]
    fn what_is_no_such_run_is_refused() {
        let simulate = of(&["simulate", "--plant", "p.toml", "--out", "o.csv"]).unwrap_err();
        assert_eq!(simulate, NOT_REPEATED);
        let unknown = of(&["compare", "--robot", "r", "--data", "d", "--write", "x"]).unwrap_err();
        assert!(
            unknown.starts_with("its arguments are not valid: unexpected argument '--write'"),
            "{unknown}"
        );
        assert!(of(&["map", "--fit", "f", "--out", "q"]).unwrap_err().ends_with("no --report"));
        assert!(of(&["--help"]).is_err() && of(&["--version"]).is_err() && of(&[]).is_err());
    }
}
