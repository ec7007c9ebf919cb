//! `truepose simulate`: measure a robot with real physics.

use crate::args::Simulate;
use crate::failure::Failure;
use crate::terminal;
use std::path::Path;
use truepose_io::{
    ExportUnits, RobotOptions, Unit, check_writable, read_robot, read_text, robot_files, write_measurements,
};
use truepose_report::count;
use truepose_simulate::{PlantDescription, SimulateError};

/// Runs the verb.
pub fn run(args: &Simulate) -> Result<(), Failure> {
    check_writable(&args.out)?;
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
    let read: Vec<_> = read.iter().map(|file| ("the plant's `robot`", file.as_path())).collect();
    super::files::kept("--out", &args.out, &read)?;
    let (chain, warnings) = read_robot(robot, &RobotOptions::default())?;
    terminal::warn(&warnings);
    let measured = description.plant(&chain).and_then(|plant| {
        let seed = args.campaign_seed.unwrap_or(description.seed);
        plant.measure(&description.campaign.on(&chain, seed)?, seed)
    });
    let data = measured.map_err(|error| located(error.located(&text)))?;
    let unit = |word| Unit::named(word).copied().ok_or_else(|| Failure::Input(format!("no unit `{word}`")));
    let units = ExportUnits { length: unit("mm")?, angle: unit("deg")? };
    write_measurements(&args.out, &chain, &data, &units)?;
    terminal::print(&format!("{} measured, written to {}\n", count(data.len(), "row"), args.out.display()));
    Ok(())
}
