//! Robots of one type as prior for the next, on the command line.

use crate::folder::Folder;

fn fit(folder: &Folder, seed: &str) -> String {
    let (data, out) = (format!("data{seed}.csv"), format!("fit{seed}.json"));
    folder.run(&["simulate", "--plant", "plant.toml", "--seed", seed, "--out", &data]).ended(0);
    folder.run(&["identify", "--robot", "robot.toml", "--data", &data, "--out", &out]).ended(0);
    out
}

#[test]
fn a_fleet_is_the_prior_of_its_next_robot() {
    let folder = Folder::with_data();
    let fits: Vec<String> = ["11", "12", "13", "14", "15"].iter().map(|seed| fit(&folder, seed)).collect();
    let words: Vec<&str> = fits.iter().map(String::as_str).collect();
    let told = folder.run(&[&["fleet"], words.as_slice(), &["--out", "prior.json"]].concat()).ended(0);
    assert!(told.out.contains("small: a fleet of 5 robots"), "{}", told.out);
    // The next one, from the first seven poses of two targets.
    let rows = folder.read("data.csv");
    let few: String = rows.lines().take(15).map(|line| format!("{line}\n")).collect();
    folder.write("few.csv", &few);
    let identify = "identify --robot robot.toml --data few.csv --prior prior.json --out fit.json";
    let told = folder.run(identify).ended(0);
    assert!(
        told.out.contains("with its sisters as prior") && told.out.contains("like its sisters"),
        "{}",
        told.out
    );
    folder.run("predict --fit fit.json --data data.csv --out p.csv").ended(0);
    // A prior is no robot, and no member of a fleet.
    for verb in [
        &["predict", "--fit", "prior.json", "--data", "data.csv", "--out", "p.csv"][..],
        &["export", "--fit", "prior.json", "--format", "urdf", "--out", "x.urdf"],
        &["monitor", "--fit", "prior.json", "--data", "data.csv"],
        &["compensate", "--fit", "prior.json", "--joints", "data.csv", "--out", "p.csv"],
        &["fleet", "prior.json", words[0], words[1], words[2], "--out", "more.json"],
    ] {
        let log = folder.run(verb).ended(2).log;
        assert!(log.contains("prior.json: is a fleet's prior, and no robot"), "{log}");
    }
    let again = folder.read("fit.json");
    folder.run(identify).ended(0);
    assert_eq!(folder.read("fit.json"), again);
}

#[test]
fn what_is_no_fleet_is_refused_and_nothing_is_written_over() {
    let folder = Folder::with_data();
    let own = fit(&folder, "11");
    let log = folder.run(&["fleet", &own, &own, "--out", "prior.json"]).ended(2).log;
    assert!(log.contains("2 fits are no fleet") && !folder.file("prior.json").exists(), "{log}");
    let log = folder.run(&["fleet", &own, &own, &own, &own, "--out", &own]).ended(2).log;
    assert!(log.contains(&own), "{log}");
    // One robot four times is one robot.
    let log = folder.run(&["fleet", &own, &own, &own, &own, "--out", "prior.json"]).ended(2).log;
    assert!(log.contains("fits 1 and 2 are the same fit") && !folder.file("prior.json").exists(), "{log}");
    let identify = |more: &[&str]| {
        let words = ["identify", "--robot", "robot.toml", "--data", "data.csv"];
        folder.run(&[&words, more].concat()).ended(2).log
    };
    assert!(identify(&["--prior", "nowhere.json"]).contains("nowhere.json"));
    assert!(identify(&["--prior", "much"]).contains("a file of `truepose fleet`"));
    assert!(identify(&["--prior", &own, "--holdout", "20%"]).contains("--holdout"));
}
