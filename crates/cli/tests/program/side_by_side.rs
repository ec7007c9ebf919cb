//! Several runs at the same time: nothing is lost, and no folder is of two runs.

use crate::folder::{Folder, Run};

/// All of these at once.
fn at_once(folder: &Folder, runs: &[Vec<&str>]) -> Vec<Run> {
    std::thread::scope(|scope| {
        let all: Vec<_> = runs.iter().map(|run| scope.spawn(move || folder.run(run))).collect();
        all.into_iter().map(|run| run.join().unwrap()).collect()
    })
}

#[test]
fn checks_at_the_same_time_are_all_in_the_history_each_at_its_own_level() {
    let folder = Folder::with_data();
    folder.run("identify --robot robot.toml --data data.csv --out fit.json").ended(0);
    let days = ["d1.csv", "d2.csv", "d3.csv", "d4.csv"];
    for (day, seed) in days.iter().zip(["11", "12", "13", "14"]) {
        folder.run(&["simulate", "--plant", "plant.toml", "--campaign-seed", seed, "--out", day]).ended(0);
    }
    let run = |day| vec!["monitor", "--fit", "fit.json", "--data", day, "--history", "h.json"];
    let runs: Vec<Vec<&str>> = days.into_iter().map(run).collect();
    at_once(&folder, &runs).into_iter().for_each(|run| drop(run.ended(0)));
    let history = folder.json("h.json");
    let levels: Vec<f64> =
        history["looks"].as_array().unwrap().iter().map(|look| look["level"].as_f64().unwrap()).collect();
    assert_eq!(levels.len(), 4);
    assert!(levels.windows(2).all(|pair| pair[1] < pair[0]), "{levels:?}");
    assert!(folder.names().iter().all(|name| !name.ends_with(".lock")), "{:?}", folder.names());
}

#[test]
fn a_folder_and_a_fit_are_of_one_run() {
    let folder = Folder::with_data();
    let run = |seed| {
        let files = ["--robot", "robot.toml", "--data", "data.csv", "--out", "o.json", "--report", "r"];
        [&["identify"][..], &files, &["--seed", seed]].concat()
    };
    let runs: Vec<Vec<&str>> = ["1", "2", "3", "4"].into_iter().map(run).collect();
    let ended = at_once(&folder, &runs);
    let done = ended.iter().filter(|run| run.code == Some(0)).count();
    for run in ended.iter().filter(|run| run.code != Some(0)) {
        assert_eq!(run.code, Some(2), "{}", run.log);
        assert!(run.log.contains("another run is writing it"), "{}", run.log);
    }
    assert!(done >= 1);
    folder.run("verify r/run.json").ended(0);
    let record = folder.json("r/run.json");
    let words: Vec<&str> =
        record["arguments"].as_array().unwrap().iter().map(|word| word.as_str().unwrap()).collect();
    let fit = folder.json("o.json");
    assert_eq!(fit["provenance"]["seed"].to_string(), *words.last().unwrap());
}
