//! A search asks whether the robot is wrong, or what observed it.

use crate::folder::Folder;
use std::cell::Cell;
use std::ops::ControlFlow::Continue;
use std::path::Path;
use truepose_cli::front::{Campaign, Searched};
use truepose_discover::{DiscoverOptions, diagnose};
use truepose_errormodel::SessionRules;
use truepose_errormodel::effects::Geometric;
use truepose_identify::FitOptions;
use truepose_io::{MeasurementsOptions, RobotOptions, read_measurements, read_robot, robot_surroundings};
use truepose_solvers::PivotedQr;

#[cfg(feature = "slow")]
#[test]
fn a_lens_that_is_not_the_stated_one_is_blamed_and_found() {
    let folder = Folder::empty();
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/10_hand_eye/robot.toml");
    let robot = std::fs::read_to_string(example).unwrap();
    // The board lies in front of the robot, whose place is known.
    folder.write("robot.toml", &robot.replace("known = false", "xyz = [-550, -150, -30]"));
    let corners: String = (1..13).map(|k| format!("[[landmarks]]\nname = \"c{k}\"\nrows = 0\n")).collect();
    let plant = "robot = \"robot.toml\"\nseed = 5\n[campaign]\nvisits = 0\nshuffled = true\n\
        [errors.geometric]\nposition_mm = 0.5\nangle_mrad = 0.5\n\
        [[cameras]]\nname = \"eye\"\nimages = 16\nxyz_mm = [40, -50, 60]\nrpy_deg = [1.7, -1.1, 34]\n\
        distance_mm = [250, 500]\nnormal = [0, 0, 1]\nsd_px = 0.1\nfx = 909\nfy = 909\n";
    folder.write("plant.toml", &(plant.to_owned() + &corners));
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    let run = folder.run("discover --robot robot.toml --data data.csv --json").ended(0);
    let found = run.json();
    let observers = &found["observers"];
    assert_eq!(observers["suspects"][0]["what"], "lens", "{observers}");
    assert_eq!(observers["preferred"], true);
    let [described, allowed] =
        ["as_described", "allowed"].map(|key| observers["kinds"][0][key].as_f64().unwrap());
    // The corners scatter by 0.1 px.
    assert!(allowed < 0.13 && described > 2.0 * allowed, "{described} {allowed}");
    assert_eq!(found["effects"].as_array().unwrap().len(), 0);
    let values = found["kinds"]["sensors"][0]["values"].as_array().unwrap();
    let fx = values.iter().find(|value| value[0] == "fx").unwrap()[1].as_f64().unwrap();
    assert!((fx - 909.0).abs() < 1.5, "{fx}");

    // Where the search fails with the lens allowed for, that of the campaign as described counts.
    let (robot, data) = (folder.file("robot.toml"), folder.file("data.csv"));
    let (chain, _) = read_robot(&robot, &RobotOptions::default()).unwrap();
    let (rows, info, _) = read_measurements(data, &chain, &MeasurementsOptions::default()).unwrap();
    let said = (SessionRules::default(), robot_surroundings(&robot).unwrap());
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    let campaign =
        Campaign::of(said, chain, vec![Box::new(Geometric::default())], rows, &info, (&solver, &options))
            .unwrap();
    let searches = Cell::new(0);
    let search = |(chain, effects, rows): Searched<'_>, fit: FitOptions| {
        searches.set(searches.get() + 1);
        let options = DiscoverOptions { fit, most: 0, ..DiscoverOptions::default() };
        let found = diagnose(chain, effects, rows, &solver, &options, &|_| Continue(()));
        if searches.get() == 1 { found.map_err(|error| error.to_string()) } else { Err("broken".into()) }
    };
    let (campaign, _, observers) = campaign.decided((&solver, &options), &search).unwrap();
    assert_eq!(searches.get(), 2);
    assert!(observers.is_none());
    let last = campaign.remarks().last().unwrap();
    assert_eq!(last, "with eye allowed for, the search failed: broken");
}
