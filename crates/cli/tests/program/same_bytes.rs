//! The program and the workflow in Rust write the same files.

use crate::folder::Folder;
use std::fs::read;
use truepose_discover::DiscoverOptions;
use truepose_errormodel::EffectRegistry;
use truepose_io::{fit_json, parse_fit};
use truepose_solvers::PivotedQr;
use truepose_workflow::{
    DiscoverRequest, IdentifyRequest, InputFiles, Inputs, NamedSolver, Search, Unobserved, identify,
};

fn inputs(folder: &Folder) -> Inputs {
    let (robot, data) = (folder.file("robot.toml"), folder.file("data.csv"));
    InputFiles { robot, data, ..InputFiles::default() }.read(&EffectRegistry::builtin()).unwrap().0
}

fn qr() -> NamedSolver {
    NamedSolver { name: "qr".into(), solver: Box::new(PivotedQr::default()) }
}

#[test]
fn of_an_identification() {
    let folder = Folder::with_data();
    let words =
        "identify --robot robot.toml --data data.csv --holdout 20% --seed 4 --out fit.json --report r";
    folder.run(words).ended(0);
    let request = IdentifyRequest { holdout: Some(0.2), seed: 4, ..IdentifyRequest::default() };
    let mut made = identify(inputs(&folder), &request, &qr(), &Unobserved).unwrap();
    assert_eq!(
        fit_json("fit.json", &made.fitted).unwrap().as_bytes(),
        read(folder.file("fit.json")).unwrap()
    );
    made.compute_parameters();
    made.compute_places();
    let summary = serde_json::to_string_pretty(&made.summary).unwrap() + "\n";
    assert_eq!(summary.as_bytes(), read(folder.file("r/identification.json")).unwrap());
    assert!(parse_fit(&fit_json("fit.json", &made.fitted).unwrap(), &EffectRegistry::builtin()).is_ok());
}

#[test]
fn of_a_search_that_adds_nothing() {
    let folder = Folder::with_data();
    let words = "discover --robot robot.toml --data data.csv --most 0 --nested 2 --out fit.json --report r";
    folder.run(words).ended(0);
    let options = DiscoverOptions { most: 0, ..DiscoverOptions::default() };
    let nested = Some((2, truepose_workflow::SplitKind::Random));
    let request = DiscoverRequest { options, nested, specification: None };
    let search = Search::new(inputs(&folder), request, qr(), &Unobserved).unwrap();
    let mut made = search.run(&Unobserved).unwrap();
    search.validate(&mut made, &Unobserved).unwrap();
    assert_eq!(
        fit_json("fit.json", &made.fitted).unwrap().as_bytes(),
        read(folder.file("fit.json")).unwrap()
    );
    made.compute_parameters();
    let summary = serde_json::to_string_pretty(&made.summary).unwrap() + "\n";
    assert_eq!(summary.as_bytes(), read(folder.file("r/discovery.json")).unwrap());
}
