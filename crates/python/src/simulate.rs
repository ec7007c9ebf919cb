//! `simulate`: measurements of a robot with physical error sources.

use crate::data::Data;
use crate::error::{input, of_io};
use crate::robot::Robot;
use crate::run::supervised;
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use truepose_errormodel::{Dataset, configurations};
use truepose_io::{CsvInfo, read_text};
use truepose_simulate::{PlantDescription, SimulateError};

/// Of a plant file: the nominal robot and its measurements.
#[pyfunction]
#[pyo3(signature = (plant, seed, campaign_seed))]
pub fn simulate(
    py: Python<'_>,
    plant: PathBuf,
    seed: Option<u64>,
    campaign_seed: Option<u64>,
) -> PyResult<(Robot, Data)> {
    let text = read_text(&plant).map_err(of_io)?;
    let file = plant.display().to_string();
    let located = move |error: SimulateError| match error {
        SimulateError::Description { line, column, message } => {
            input(format!("{file}:{line}:{column}: {message}"))
        }
        error => input(format!("{file}: {error}")),
    };
    let mut description = PlantDescription::from_toml(&text).map_err(&located)?;
    if let Some(seed) = seed {
        description.seed = seed;
    }
    if description.robot.is_empty() {
        return Err(input(format!("{}: names no robot; begin with `robot = \"arm.toml\"`", plant.display())));
    }
    let path = plant.parent().unwrap_or_else(|| Path::new("")).join(&description.robot);
    let robot = Robot::from_file(path, None, None, [false; 2])?;
    let (chain, surroundings) = (robot.chain.clone(), robot.beside.surroundings.clone());
    let (data, landmarks) = supervised(py, None, Vec::new(), move |_| {
        let measured = description.plant_in(&chain, &surroundings).and_then(|made| {
            let seed = campaign_seed.unwrap_or(description.seed);
            let data = made.measure(&description.campaign_of(&made, seed)?, seed)?;
            Ok(named(data, &made.cell.names))
        });
        measured.map_err(|error| located(error.located(&text)))
    })?;
    let info = CsvInfo {
        landmarks,
        file: "data".into(),
        rows: data.len(),
        visits: data.visit.iter().max().map_or(0, |last| last + 1),
        configurations: configurations(&data).iter().max().map_or(0, |last| last + 1),
        ..CsvInfo::default()
    };
    let data = Data::new(Arc::clone(&robot.chain), (data, info, Vec::new()));
    Ok((robot, data))
}

/// The rows with their landmarks numbered as in a table that was read, and the names of these.
fn named(mut data: Dataset, names: &[String]) -> (Dataset, Vec<String>) {
    let mut used: Vec<usize> = Vec::new();
    let mut number = |landmark: Option<usize>| {
        let landmark = landmark?;
        Some(used.iter().position(|known| *known == landmark).unwrap_or_else(|| {
            used.push(landmark);
            used.len() - 1
        }))
    };
    let landmarks: Vec<Option<usize>> = (0..data.len()).map(|row| number(data.landmark(row))).collect();
    let points: Vec<Option<usize>> = (0..data.len()).map(|row| number(data.point(row))).collect();
    if landmarks.iter().any(Option::is_some) {
        data.set_landmarks(Some(&landmarks));
    }
    if points.iter().any(Option::is_some) {
        data.set_points(Some(&points));
    }
    (data, used.into_iter().map(|landmark| names[landmark].clone()).collect())
}
