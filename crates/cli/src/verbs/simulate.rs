//! `truepose simulate`: measure a robot with real physics.

use crate::args::{NamedFile, Simulate};
use crate::failure::Failure;
use crate::terminal;
use std::path::Path;
use truepose_io::{
    ExportUnits, RobotOptions, Unit, check_writable, read_robot, read_text, robot_files, robot_surroundings,
    write_measurements, write_observations,
};
use truepose_report::count;
use truepose_simulate::{PlantDescription, SimulateError};

/// Runs the verb.
pub fn run(args: &Simulate) -> Result<(), Failure> {
    check_writable(&args.out)?;
    args.truth.as_deref().map_or(Ok(()), check_writable)?;
    let text = read_text(&args.plant)?;
    let file = args.plant.display();
    let located = |error: SimulateError| {
        Failure::Input(match error {
            SimulateError::Description { line, column, message } => {
                format!("{file}:{line}:{column}: {message}")
            }
            error => format!("{file}: {error}"),
        })
    };
    let mut description = PlantDescription::from_toml(&text).map_err(located)?;
    if let Some(seed) = args.seed {
        description.seed = seed;
    }
    if description.robot.is_empty() {
        return Err(Failure::Input(format!("{file}: names no robot; begin with `robot = \"arm.toml\"`")));
    }
    // What comes through a pipe counts from the working folder.
    let folder = if args.plant.is_file() { args.plant.parent() } else { None };
    let robot = folder.unwrap_or_else(|| Path::new("")).join(&description.robot);
    let read = robot_files(&robot);
    let read: Vec<_> = read.into_iter().map(|path| NamedFile::new("the plant's `robot`", path)).collect();
    super::files::kept("--out", &args.out, &read)?;
    args.truth.as_deref().map_or(Ok(()), |truth| super::files::kept("--truth", truth, &read))?;
    let surroundings = robot_surroundings(&robot)?;
    let (chain, warnings) = read_robot(robot, &RobotOptions::default())?;
    terminal::warn(&warnings);
    let observed = description.plant_in(&chain, &surroundings).and_then(|plant| {
        let seed = args.campaign_seed.unwrap_or(description.seed);
        let seen = plant.observe(&description.campaign_of(&plant, seed)?, seed)?;
        Ok((plant.cell.names, seen))
    });
    let (names, seen) = observed.map_err(|error| located(error.located(&text)))?;
    let unit = |word| Unit::named(word).copied().ok_or_else(|| Failure::Input(format!("no unit `{word}`")));
    let units = ExportUnits { length: unit("mm")?, angle: unit("deg")? };
    write_observations(&args.out, &chain, &seen.data, &names, &units)?;
    let rows = count(seen.data.len(), "row");
    terminal::print(&format!("{rows} measured, written to {}\n", args.out.display()));
    if let Some(truth) = &args.truth {
        write_measurements(truth, &chain, &seen.truth(), &units)?;
        terminal::print(&format!("true poses of these rows written to {}\n", truth.display()));
    }
    Ok(())
}
