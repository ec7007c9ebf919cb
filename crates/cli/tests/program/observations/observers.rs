//! A search asks whether the robot is wrong, or what observed it.

use super::eye::of_another_lens;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use truepose_discover::DiscoverOptions;
use truepose_errormodel::EffectRegistry;
use truepose_solvers::{LeastSquares, Need, PivotedQr, Solution, SolveError, Solver};
use truepose_workflow::{DiscoverRequest, InputFiles, NamedSolver, Observer, Search};

#[test]
fn a_lens_that_is_not_the_stated_one_is_blamed_and_found() {
    let folder = of_another_lens(5, [0.5, 0.5], 16);
    let run = folder.run("discover --robot robot.toml --data data.csv --json").ended(0);
    let found = run.json();
    let observers = &found["observers"];
    assert_eq!(observers["suspects"][0]["what"], "lens", "{observers}");
    assert_eq!(observers["preferred"], true);
    let [described, allowed] =
        ["as_described", "allowed"].map(|key| observers["kinds"][0][key].as_f64().unwrap());
    // The corners scatter by 0.1 px; 16 images hold 40 unknowns, of which each fold has fewer images.
    assert!(allowed < 0.25 && described > 2.0 * allowed, "{described} {allowed}");
    assert_eq!(found["effects"].as_array().unwrap().len(), 0);
    let values = found["kinds"]["sensors"][0]["values"].as_array().unwrap();
    let fx = values.iter().find(|value| value[0] == "fx").unwrap()[1].as_f64().unwrap();
    assert!((fx - 909.0).abs() < 1.5, "{fx}");

    // Where the search fails with the lens allowed for, that of the campaign as described counts.
    let files = InputFiles {
        robot: folder.file("robot.toml"),
        data: folder.file("data.csv"),
        ..InputFiles::default()
    };
    let (inputs, _) = files.read(&EffectRegistry::builtin()).unwrap();
    let searches = Searches::default();
    let solver = NamedSolver { name: "broken".into(), solver: Box::new(Breaking(searches.clone())) };
    let options = DiscoverOptions { most: 0, ..DiscoverOptions::default() };
    let request = DiscoverRequest { options, ..DiscoverRequest::default() };
    let search = Search::new(inputs, request, solver, &searches).unwrap();
    let made = search.run(&searches).unwrap();
    assert_eq!(searches.0.load(Relaxed), 2);
    assert!(made.summary.observers.is_none() && made.allowing.is_none());
    let last = made.remarks.last().unwrap();
    assert!(last.starts_with("with eye allowed for, the search failed: "), "{last}");
    assert!(last.contains("did not converge"), "{last}");
}

/// Counts the searches of a run.
#[derive(Clone, Default)]
struct Searches(Arc<AtomicUsize>);

impl Observer for Searches {
    fn step(&self, words: &str) -> ControlFlow<()> {
        self.0.fetch_add(usize::from(words == "fitting the declared model"), Relaxed);
        ControlFlow::Continue(())
    }
}

/// A solver that fails in the second search.
struct Breaking(Searches);

impl Solver for Breaking {
    fn name(&self) -> &str {
        "breaking"
    }

    fn supports(&self, need: Need) -> bool {
        PivotedQr::default().supports(need)
    }

    fn solve(&self, problem: &LeastSquares<'_>) -> Result<Solution, SolveError> {
        match self.0.0.load(Relaxed) {
            0 | 1 => PivotedQr::default().solve(problem),
            _ => Err(SolveError::Breakdown { what: "the test", rows: 1, columns: 1 }),
        }
    }
}
