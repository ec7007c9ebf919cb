//! A recorded run with its outputs elsewhere: whatever its arguments say, nothing is written outside of one folder.

use crate::args::{Args, Verb};
use std::path::Path;

/// A verb to repeat.
#[derive(Debug)]
pub struct Repeated {
    /// With every output in the folder.
    pub verb: Verb,
    /// Name of the result there.
    pub result: &'static str,
}

impl Repeated {
    /// Of recorded arguments, which are parsed as any others are: each output is a field, and is replaced.
    ///
    /// # Errors
    /// What is wrong with the arguments.
    pub fn of(arguments: &[String], own: &Path) -> Result<Self, String> {
        let args =
            Args::recorded(arguments).map_err(|words| format!("its arguments are not valid: {words}"))?;
        let report = Some(own.to_path_buf());
        let (verb, result) = match args.verb {
            Verb::Identify(mut verb) => {
                (verb.report, verb.out, verb.parameters) = (report, None, None);
                (Verb::Identify(verb), "identification.json")
            }
            Verb::Discover(mut verb) => {
                // Fits of competing hypotheses are work that the result shows.
                let rivals = verb.rivals.map(|_| own.join("rivals"));
                (verb.report, verb.out, verb.rivals) = (report, None, rivals);
                verb.parameters = None;
                (Verb::Discover(verb), "discovery.json")
            }
            Verb::Compare(mut verb) => {
                verb.report = report;
                (Verb::Compare(verb), "comparison.json")
            }
            Verb::Compensate(mut verb) => {
                (verb.report, verb.out) = (report, own.join("commands.csv"));
                (Verb::Compensate(verb), "compensation.json")
            }
            Verb::Map(mut verb) => {
                (verb.report, verb.out) = (report, own.join("map.csv"));
                (Verb::Map(verb), "map.json")
            }
            Verb::Plan(mut verb) => {
                (verb.report, verb.out) = (report, own.join("plan.csv"));
                (Verb::Plan(verb), "plan.json")
            }
            Verb::Predict(mut verb) => {
                (verb.report, verb.out) = (report, own.join("predictions.csv"));
                (Verb::Predict(verb), "prediction.json")
            }
            Verb::Iso9283(mut verb) => {
                verb.report = report;
                (Verb::Iso9283(verb), "acceptance.json")
            }
            _ => return Err(NOT_REPEATED.into()),
        };
        Ok(Repeated { verb, result })
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
        let read = ["discover", "--robot", "r.toml", "--data=d.csv"];
        for outputs in [&["--out", "fit.json", "--report=r", "--rivals", "mine"][..], &["--rivals=mine"]] {
            let Verb::Discover(verb) = of(&[&read[..], outputs].concat()).unwrap().verb else {
                panic!("discover")
            };
            assert_eq!(verb.measured.data, Path::new("d.csv"));
            assert_eq!((verb.out, verb.report.as_deref()), (None, Some(Path::new("own"))));
            assert_eq!(verb.rivals.as_deref(), Some(Path::new("own/rivals")));
        }
        let compensate = of(&["compensate", "--fit", "f", "--poses", "p", "--out", "q"]).unwrap();
        let Verb::Compensate(verb) = compensate.verb else { panic!("compensate") };
        assert_eq!(verb.out, Path::new("own/commands.csv"));
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
        assert!(of(&["--help"]).is_err() && of(&["--version"]).is_err() && of(&[]).is_err());
    }
}
