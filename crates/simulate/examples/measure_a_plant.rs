//! Measures the plant of `plant.toml` and says how far it is from its description.
//!
//! `cargo run --package truepose-simulate --example measure_a_plant`

#![allow(clippy::print_stdout, reason = "an example talks to its reader")]

use truepose_kinematics::{Conditions, samples};
use truepose_simulate::{Plant, PlantDescription, SimulateError};

fn main() -> Result<(), SimulateError> {
    let text = include_str!("plant.toml");
    let description = PlantDescription::from_toml(text)?;
    let robot = samples::heavy();
    let plant = description.plant(&robot).map_err(|error| error.located(text))?;
    let campaign = description.campaign.on(&robot, description.seed)?;
    let seen = plant.observe(&campaign, description.seed)?;

    let perfect = Plant::perfect(&robot)?;
    let (mut before, mut noise) = (0.0, 0.0);
    for row in 0..seen.data.len() {
        let at: Conditions = seen.data.conditions(row);
        let measured = seen.data.measured_position(row);
        before += (measured - perfect.true_position(&at, seen.data.target[row])?).norm_squared();
        noise += (measured - seen.true_positions[row]).norm_squared();
    }
    let rms_mm = |sum: f64| 1e3 * (sum / seen.data.len() as f64).sqrt();
    println!("{} rows in {} visits of {}", seen.data.len(), campaign.visits.len(), robot.name());
    println!("against the description  {:.3} mm RMS", rms_mm(before));
    println!("against the truth        {:.3} mm RMS (repeatability and instrument)", rms_mm(noise));
    Ok(())
}
